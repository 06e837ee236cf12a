#include "cli/label_options.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/naming.h"
#include "cli/options.h"
#include "cli/volume_input.h"
#include "io/label_looks.h"
#include "volume/labels.h"

namespace vol::cli {

void add_labels(CLI::App& app, LabelOptions& o) {
  auto* labels =
      app.add_option("--labels", o.labels,
                     "Label volume of the volume's dims, in its place, whole numbers 0 to 255: colour and "
                     "opacity by label (composite, rectangle or trapezoid)")
          ->group("Files");
  app.add_option("--label-transfer", o.looks,
                 "Colour and opacity of each label (YAML), as configs/transfer/labels.yaml [seven colours in "
                 "turn, label 0 not seen]")
      ->needs(labels)
      ->group("Files");
  const char* group = "Labels in the picture";
  const auto add = [&](const char* name, auto& value, const char* text) {
    return app.add_option(name, value, text)->needs(labels)->group(group);
  };
  add("--label-use", o.use, "alone, or multiply: times the transfer function of the value")
      ->check(CLI::IsMember({"alone", "multiply"}))
      ->capture_default_str();
  add("--label-membership", o.membership, "Between samples: nearest label, or interpolated shares of each")
      ->check(CLI::IsMember({"nearest", "interpolated"}))
      ->capture_default_str();
  auto* splat = add("--splat", o.splat,
                    "Voxels of these labels as opaque splats in place of a medium: cubic radial basis "
                    "functions, their sum contoured; LABEL,LABEL,... or all")
                    ->type_name("LABEL,...");
  add("--splat-support", o.support, "Radius of a splat: world length, or 1.5v for 1.5 smallest spacings")
      ->needs(splat)
      ->capture_default_str();
  add("--splat-threshold", o.threshold, "Contour of the sum; one splat's largest value is 1")
      ->needs(splat)
      ->check(check_positive)
      ->capture_default_str();
  labels->excludes(app.get_option("--index"));  // its bound is for the field
}

namespace {

/// Within what files round: a millionth of a spacing.
bool same_place(const volume::GridGeometry& a, const volume::GridGeometry& b) {
  const double near = 1e-6 * b.spacing.minCoeff();
  return (a.origin - b.origin).norm() <= near && (a.spacing - b.spacing).norm() <= near &&
         (a.direction - b.direction).norm() <= 1e-6;
}

}  // namespace

LabelSet::LabelSet(const LabelOptions& o) : options_(o) {
  if (!o.splat.empty() && o.splat != "all") chosen_ = parse_labels("--splat", o.splat);
}

std::vector<bool> LabelSet::splatted(const std::vector<render::LabelLook>& looks) const {
  std::vector<bool> result(256, false);
  if (options_.splat.empty()) return result;
  const auto seen = [&](std::size_t label) { return label < looks.size() && looks[label].opacity > 0; };
  for (std::size_t label = 0; label < result.size(); ++label) result[label] = chosen_.empty() && seen(label);
  for (const int label : chosen_) {
    if (!seen(static_cast<std::size_t>(label))) {
      throw Error(
          "--splat: label " + std::to_string(label) + " has no colour, or no opacity" +
          (options_.looks.empty() ? " (--label-transfer)" : " in " + io::display_name(options_.looks)));
    }
    result[static_cast<std::size_t>(label)] = true;
  }
  return result;
}

void LabelSet::load(const volume::GridGeometry& geometry, Record& record) {
  if (!options_.any()) return;
  if (!options_.looks.empty()) record.input(options_.looks);
  const std::vector<render::LabelLook> looks =
      options_.looks.empty() ? io::default_label_looks() : io::read_label_looks(options_.looks);
  record.resolved("label_looks", io::to_json(looks));
  const std::vector<bool> chosen = splatted(looks);
  volume::SplatOptions splat;
  splat.support = parse_step("--splat-support", options_.support, geometry.spacing.minCoeff());
  VolumeInput input;
  input.path = options_.labels;
  const volume::Volume volume = cli::load(input, record);
  naming(options_.labels, [&] {
    render::require_dims_of(volume.geometry(), geometry);
    if (!same_place(volume.geometry(), geometry)) {
      record.warn(
          io::display_name(options_.labels) +
          ": says another place than the volume; its labels are drawn where the volume's samples are");
    }
    record.timed("labels", [&] {
      render::LabelStyle style{
          looks,
          options_.membership == "nearest" ? render::Membership::nearest : render::Membership::interpolated,
          options_.use == "multiply"};
      for (std::size_t label = 0; label < looks.size(); ++label) {
        if (chosen[label]) style.looks[label].opacity = 0;
      }
      medium_ = std::make_unique<const render::LabelledMedium>(volume::label_grid(volume), geometry,
                                                               std::move(style));
      if (options_.splat.empty()) return;
      splats_ = std::make_unique<const render::SplatRays>(
          volume::SplatField(medium_->labels(), chosen, splat), looks, options_.threshold);
    });
  });
  if (splats_) {
    record.count("splats", splats_->field().count());
    if (splats_->field().count() == 0) record.warn("--splat: no voxel has such a label");
  }
}

}  // namespace vol::cli
