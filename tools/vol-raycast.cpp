// vol-raycast: ray casting of a volume, uniform, index-guided, or the reference integral.
//   vol-raycast head.nrrd -o head.exr --scene configs/scenes/ct-head.yaml --size 512x512 --stats head.json
//   vol-raycast head.nrrd -o skull.png --isovalue 500 --surface-opacity 0.4 --isovalue 1150 --mesh probe.ply
//   vol-raycast head.nrrd -o regions.png --labels labels.nrrd --label-transfer configs/transfer/labels.yaml
//   vol-raycast head.nrrd -o truth.exr --scene configs/scenes/ct-head.yaml --quadrature reference --tolerance
//   1e-8
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/heap.h"
#include "cli/options.h"
#include "cli/raycast_options.h"
#include "cli/run.h"
#include "image/difference.h"
#include "image/exposure.h"
#include "index/scene_index.h"
#include "io/index.h"
#include "io/write_image.h"
#include "render/caster.h"
#include "render/names.h"
#include "render/weighted_field.h"

namespace {

using namespace vol;
using Options = cli::RaycastOptions;

/// The index that guides the rays, if any, and the length of a step, which is the index's own unless another
/// is asked for.
std::optional<index::IndexVolume> index_and_step(const volume::Volume& volume, const io::SceneFile& file,
                                                 Options& o, cli::Record& record) {
  std::optional<index::IndexVolume> index;
  const bool automatic = o.index == "auto";
  if (!o.index.empty() && !automatic) {
    record.input(o.index);
    auto read = record.timed("read", [&] { return io::read_index(o.index); });
    index = std::move(read.index);
    record.resolved("index", read.attributes);
    o.render.step = index->standard_distance();
  }
  const std::string step = !o.step.empty() ? o.step : file.step.value_or("0.5v");
  if (!index || !o.step.empty()) {
    const bool of_scene = o.step.empty() && file.step;
    o.render.step = cli::parse_step(of_scene ? io::display_name(o.scene) + ": step" : "--step", step,
                                    volume.geometry().spacing.minCoeff());
  }
  if (index && std::abs(o.render.step / index->standard_distance() - 1) > 1e-6) {
    record.warn("--step differs from the index's standard distance, " +
                std::to_string(index->standard_distance()) + ": its bound does not hold");
  }
  if (automatic) {
    index::IndexOptions options;
    options.standard_distance = o.render.step;
    options.reconstruction = o.render.reconstruction;
    options.reduction = o.index_reduction.value_or(1);
    index = record.timed("index", [&] {
      return index::index_of_scene(volume, file.scene.transfer, file.scene.reference_length, o.epsilon,
                                   options);
    });
    return_freed_memory();
    record.count("index_bytes", static_cast<std::int64_t>(index->nibbles().size()));
  }
  return index;
}

/// Lays the voxels out in blocks if these are asked for. \param volume  gives them up
/// \return whether they are
bool in_blocks(render::Caster& caster, volume::Volume& volume, const Options& o) {
  return o.layout == "blocks" && caster.lay_out_in_blocks(volume);
}

void report_layout(bool blocks, const Options& o, cli::Record& record) {
  record.resolved("layout", blocks ? "blocks" : "rows");
  if (o.layout == "blocks" && !blocks) {
    record.warn("--layout blocks: drawn from rows: packets do not draw this, or its dims do not fill blocks");
  }
}

/// One picture, prepared and cast, each timed.
/// \param volume  left without its voxels where they are laid out in blocks
render::RenderResult drawn(volume::Volume& volume, const render::Scene& scene, const Options& o,
                           cli::SurfaceSet& surfaces, const cli::LabelSet& labels,
                           const index::IndexVolume* index, cli::Record& record) {
  render::CasterOptions with{.packets = o.algorithm == "packet", .index = index, .labels = labels.medium()};
  if (o.surfaces.any() || labels.splats()) {
    surfaces.prepare(volume, o.render.reconstruction, scene, labels.splats(), record);
    with.surfaces = &surfaces.surfaces();
  }
  bool blocks = false;
  const auto caster = record.timed("prepare", [&] {
    auto made = std::make_unique<render::Caster>(volume, scene, o.render, with);
    blocks = in_blocks(*made, volume, o);
    return made;
  });
  report_layout(blocks, o, record);
  render::RenderResult result;  // each picture in the memory of the one before
  record.repeated("render", [&] { result = caster->cast(std::move(result.image)); });
  return result;
}

/// The X-ray of the field weighted by Bezier curves, of grey ones one picture, of colours one a channel. A
/// phase is all channels' work, and so are the counts and the picture's samples.
/// \param volume  given up
render::RenderResult drawn_weighted(volume::Volume volume, const transfer::BezierTransfer& bezier,
                                    const render::Scene& scene, const Options& o, cli::Record& record) {
  std::vector<volume::Volume> weighted;  // none moves once there is something prepared for it
  record.timed("weight", [&] {
    for (int c = 0; c < (bezier.grey() ? 1 : 3); ++c) {
      weighted.push_back(render::weighted_volume(volume, bezier, c));
    }
  });
  volume = {};
  std::vector<std::unique_ptr<const render::Caster>> casters;
  bool blocks = false;
  record.timed("prepare", [&] {
    const render::CasterOptions with{.packets = o.algorithm == "packet"};
    for (auto& w : weighted) {
      auto made = std::make_unique<render::Caster>(w, scene, o.render, with);
      blocks = in_blocks(*made, w, o);  // of dims that all share
      casters.push_back(std::move(made));
    }
  });
  report_layout(blocks, o, record);
  return record.repeated("render", [&] { return render::cast_channels(casters); });
}

void report(const render::RenderResult& result, const Options& o, cli::Record& record) {
  record.result("caster", result.caster);
  record.count("rays", result.counts.rays);
  record.count("samples", result.counts.samples);
  record.count("gradients", result.counts.gradients);
  record.count("skipped", result.counts.skipped);
  record.count("terminated", result.counts.terminated);
  if (o.surfaces.any() || !o.labels.splat.empty()) {
    record.count("surface_hits", result.counts.surface_hits);
    record.count("surface_undecided", result.counts.surface_undecided);
  }
  if (result.counts.rays > 0) {
    record.result("samples_per_ray", double(result.counts.samples) / double(result.counts.rays));
  }
  const bool reference = o.render.quadrature == render::Quadrature::reference;
  if (o.render.max_error > 0 || reference) record.error("pixel_maximum_estimate", result.error_estimate);
  if (o.render.max_error > 0 && !(result.error_estimate <= o.render.max_error)) {
    throw Error("--max-error: the estimate reached is " + nlohmann::json(result.error_estimate).dump() +
                ", above " + nlohmann::json(o.render.max_error).dump() + "; allow more");
  }
  if (o.render.max_error == 0 && reference && result.error_estimate > 10 * o.render.tolerance) {
    record.warn("the reference reached an error of about " + std::to_string(result.error_estimate));
  }
}

/// The picture and, where it is asked for, where its work went: the channel `samples` in false colours.
void write(image::Image& picture, const render::Scene& scene, const Options& o, cli::Record& record) {
  for (const auto& [key, value] : record.provenance()) picture.attributes[key] = value;
  const Vec3& b = scene.background;
  picture.attributes["precis.background"] = nlohmann::json{b[0], b[1], b[2]}.dump();
  // The values of an X-ray and of a maximum are no colours.
  const double own = scene.model == render::Model::composite ? 1 : image::exposure_to_white(picture);
  record.timed("write", [&] {
    io::write_image(o.output, picture, o.format, {b[0], b[1], b[2]}, o.exposure.value_or(own));
  });
  if (!o.samples_output.empty()) {
    auto shown = image::channel_in_false_colours(picture, "samples");
    shown.image.attributes["precis.samples_scale"] = nlohmann::json(shown.largest).dump();
    record.timed("write", [&] { io::write_image(o.samples_output, shown.image); });
    record.result("samples_largest", shown.largest);
    record.output(o.samples_output);
  }
}

int work(Options& o, cli::Record& record) {
  io::require_image_format(o.output, o.format);
  if (!o.samples_output.empty()) io::require_image_format(o.samples_output);
  io::SceneFile file = cli::resolve_scene(o);  // wrong words are answered before a large file is read
  cli::SurfaceSet surfaces(o.surfaces);
  cli::LabelSet labels(o.labels);
  surfaces.load(record);
  if (!o.scene.empty()) record.input(o.scene);
  if (!o.transfer.empty()) record.input(o.transfer);
  volume::Volume volume = cli::load(o.input, record);
  const volume::GridGeometry geometry = volume.geometry();
  render::Scene& scene = file.scene;
  if (!file.has_transfer) {
    const volume::Range range = volume::value_range(volume);
    scene.transfer = transfer::grey_ramp(range.min, range.max);
  }
  if (scene.reference_length == 0) scene.reference_length = geometry.spacing.minCoeff();
  labels.load(geometry, record);
  const auto index = index_and_step(volume, file, o, record);

  record.resolved("scene", io::to_json(scene));
  record.resolved("quadrature", render::name(o.render.quadrature));
  record.resolved("reconstruction", render::name(o.render.reconstruction));
  if (o.render.max_error == 0) record.resolved("step_world", o.render.step);
  const bool weighted = cli::is_weighted(file);
  if (weighted) record.resolved("transfer", io::to_json(*file.bezier));
  auto result = weighted ? drawn_weighted(std::move(volume), *file.bezier, scene, o, record)
                         : drawn(volume, scene, o, surfaces, labels, index ? &*index : nullptr, record);
  report(result, o, record);

  write(result.image, scene, o, record);
  if (!o.index_output.empty()) {
    record.timed("write", [&] { io::write_index(o.index_output, *index, geometry, record.provenance()); });
    record.output(o.index_output);
  }
  record.output(o.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Ray casting of a volume to a picture: emission-absorption, X-ray or maximum projection.\n"
      "Steps may be uniform or guided by an index; --quadrature reference is the truth, to a stated "
      "tolerance.\n"
      "--isovalue, --mesh and --splat put surfaces into it at their exact depth; --labels colours by label."};
  Options options;
  cli::add_raycast(app, options);
  return cli::run(
      app,
      {.name = "vol-raycast",
       .example = "vol-phantom marschner-lobb -o - | vol-raycast - -o ml.exr --view 30,20 --size 256x256",
       .references = "Max 1995; He 1998; Gross et al. 1995, section 5 (labels, splats)",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
