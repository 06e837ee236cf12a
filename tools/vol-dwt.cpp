// vol-dwt: orthonormal 3-D wavelet transform of a scalar field, rejection of coefficients, and the inverse.
//   vol-dwt head.nrrd -o head.vdb --wavelet coiflet-6 --levels 3 --keep-energy 0.999 --stats dwt.json
//   vol-dwt head.vdb -o back.nrrd --inverse
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/volume_input.h"
#include "io/any_volume.h"
#include "io/vdb.h"
#include "io/volume.h"
#include "wavelet/dwt.h"
#include "wavelet/filters.h"
#include "wavelet/initialisation.h"
#include "wavelet/layout.h"
#include "wavelet/significance.h"

namespace {

using namespace vol;

struct Options {
  cli::VolumeInput input;
  std::filesystem::path output;
  bool inverse = false;
  std::string format;
  wavelet::DwtOptions dwt;
  std::string boundary = "periodic", extend = "replicate", initialise = "samples", precision = "auto",
              significance = "energy", region;
  std::optional<std::int64_t> keep;
  std::optional<double> keep_energy, threshold;
};

void declare(CLI::App& app, Options& o) {
  cli::add_volume_input(app, o.input, "Volume, or coefficients with --inverse; - is standard input");
  app.add_option("-o,--output", o.output,
                 "Coefficients (.vdb), or volume with --inverse; - is standard output")
      ->required()
      ->group("Files");
  auto* format = app.add_option("--format", o.format,
                                "Format of the volume: nrrd, mha, vti, vdb, raw [by extension; nrrd]")
                     ->group("Files");

  const char* transform = "Transform";
  auto* inverse = app.add_flag("--inverse", o.inverse, "Rebuild the volume, its voxel type and geometry")
                      ->group(transform);
  format->needs(inverse);
  for (auto* option : app.get_options()) {  // coefficients are one kind of file, with nothing to choose in it
    if (option->get_group() == cli::kVolumeInputGroup) option->excludes(inverse);
  }
  const auto forward = [&](CLI::Option* option) { option->group(transform)->excludes(inverse); };
  forward(
      app.add_option(
             "--wavelet", o.dwt.wavelet,
             "haar; daubechies-4 to -20, even; coiflet-6 to -30, by 6; battle-lemarie-1, -3, cut :29, :33")
          ->capture_default_str());
  forward(
      app.add_option("--levels", o.dwt.levels, "Levels; 0 stores the volume itself")->capture_default_str());
  forward(app.add_option("--boundary", o.boundary,
                         "periodic (orthonormal), or symmetric (half-sample; a few more coefficients)")
              ->check(CLI::IsMember({"periodic", "symmetric"}))
              ->capture_default_str());
  forward(app.add_option("--extend", o.extend, "How sizes that 2^levels does not divide are filled up")
              ->check(CLI::IsMember({"replicate", "mirror", "zero"}))
              ->capture_default_str());
  forward(
      app.add_option("--initialise", o.initialise,
                     "What wavelet-raycast and isosurf-ray draw of the coefficients: samples (the voxels are "
                     "the finest coefficients; the field is near smooth voxels, not through them), or "
                     "interpolate (the field goes through every voxel; not for daubechies-10, whose phi has "
                     "samples with a response below 0.1)")
          ->check(CLI::IsMember({"samples", "interpolate"}))
          ->capture_default_str());
  forward(app.add_option("--precision", o.precision,
                         "float, double, or auto: float for the voxel types that float holds exactly")
              ->check(CLI::IsMember({"auto", "float", "double"}))
              ->capture_default_str());

  const char* rejection = "Rejection (coefficients that are rejected are not stored)";
  auto* keep = app.add_option("--keep", o.keep, "Keep the N most significant coefficients");
  auto* share = app.add_option("--keep-energy", o.keep_energy,
                               "Keep the most significant that hold this share of the energy, 0 to 1");
  auto* threshold = app.add_option("--threshold", o.threshold, "Keep those of at least this significance");
  auto* measure =
      app.add_option("--significance", o.significance,
                     "gross 2^(s/2+3m/2)|c|, muraki 8^m|c|, energy c^2, amplitude 2^(-3m/2)|c|; m: level, "
                     "finest 1; s: number of scaling functions")
          ->check(CLI::IsMember({"gross", "muraki", "energy", "amplitude"}))
          ->capture_default_str();
  auto* region = app.add_option(
      "--region", o.region,
      "x0,y0,z0:x1,y1,z1, voxels, half open: all detail inside; outside what the criterion "
      "keeps, or only the approximation where there is none. With --initialise interpolate the box is "
      "of the coefficients c0: voxels within phi's support of its edge are approximate");
  for (auto* option : {keep, share, threshold, measure, region}) option->group(rejection)->excludes(inverse);
  keep->excludes(share)->excludes(threshold);
  share->excludes(threshold);
}

wavelet::Rejection rejection(const Options& o) {
  wavelet::Rejection r{.significance = wavelet::significance_from_name(o.significance),
                       .keep = o.keep,
                       .keep_energy = o.keep_energy,
                       .threshold = o.threshold};
  if (!o.region.empty()) {
    const auto box = cli::parse_region("--region", o.region);
    r.region = wavelet::VoxelBox{box.lower, box.upper};
  }
  return r;
}

void report(const wavelet::RejectionReport& r, const wavelet::PredictedError& error, std::int64_t voxels,
            wavelet::Initialisation initialisation, cli::Record& record) {
  record.count("coefficients_total", r.total);
  record.count("coefficients_nonzero", r.nonzero);
  record.count("coefficients_kept", r.kept);
  record.result("l2_norm", r.norm);
  record.result("energy", r.norm * r.norm);
  record.result("energy_kept_share", r.norm > 0 ? 1 - std::pow(r.rejected_norm / r.norm, 2) : 1.0);
  const std::string suffix =
      error.kind == wavelet::ErrorKind::exact ? "" : "_" + std::string(wavelet::name(error.kind));
  record.error("l2" + suffix, error.l2);
  record.error("rmse" + suffix, error.l2 / std::sqrt(static_cast<double>(voxels)));
  record.error("kind", std::string(wavelet::name(error.kind)));
  char relative[64];
  std::snprintf(relative, sizeof relative, "%.3g of the %s l2 norm", r.norm > 0 ? error.l2 / r.norm : 0.0,
                initialisation == wavelet::Initialisation::samples ? "volume's" : "coefficients'");
  record.say("kept " + std::to_string(r.kept) + " of " + std::to_string(r.total) +
             " coefficients; L2 error (" + std::string(wavelet::name(error.kind)) + ") " + relative);
}

template <class T>
int analyze(const volume::Volume& volume, const Options& o, cli::Record& record) {
  const auto wavelet = wavelet::make_wavelet(o.dwt.wavelet);
  const bool copied = o.dwt.initialisation == wavelet::Initialisation::interpolate;
  const double bytes =
      (copied ? 2 : 1) * sizeof(T) *
      wavelet::coefficient_count(wavelet, o.dwt.boundary, volume.geometry().dims, o.dwt.levels);
  if (bytes > static_cast<double>(io::ReadOptions::physical_memory())) {
    throw Error("the coefficients would take " + std::to_string(std::llround(bytes / 1e6)) +
                " MB, more than this machine has; give fewer levels or a shorter filter");
  }
  const auto range = record.timed("range", [&] { return volume::value_range(volume); });
  auto d = record.repeated("transform", [&] { return wavelet::analyze<T>(volume, o.dwt, range); });
  const auto rejected = record.timed("reject", [&] { return wavelet::reject(d, rejection(o)); });
  record.result("wavelet", d.wavelet);
  record.result("extended_dims", d.extended_dims);
  record.result("precision", sizeof(T) == 4 ? "float" : "double");
  auto attributes = volume.attributes;
  for (const auto& [key, value] : record.provenance()) attributes[key] = value;
  record.timed("write", [&] { io::write_coefficients(o.output, d, attributes); });
  record.output(o.output);
  report(rejected, wavelet::predicted_error(d, rejected), volume.geometry().count(), d.initialisation,
         record);
  return 0;
}

int synthesize(const Options& o, cli::Record& record) {
  io::require_volume_output(o.output, o.format);
  record.input(o.input.path);
  const auto coefficients = record.timed("read", [&] { return io::read_coefficients(o.input.path); });
  volume::Volume volume;
  volume.attributes = coefficients.attributes;
  const auto type = std::visit(
      [&](const auto& d) {
        volume.grid = record.repeated("transform", [&] { return wavelet::synthesize(d); });
        return d.voxel_type;
      },
      coefficients.decomposition);
  if (volume.voxel_type() != type) {
    record.timed("convert", [&] {
      volume::dispatch(type, [&]<class V>() { volume.grid = volume::converted<V>(volume); });
    });
  }
  cli::save(o.output, volume, record, o.format);
  return 0;
}

int work(Options& o, cli::Record& record) {
  if (o.inverse) return synthesize(o, record);
  if (!io::is_standard_stream(o.output) && o.output.extension() != ".vdb") {
    throw Error(o.output.string() + ": coefficients go to .vdb files, or to - (standard output)");
  }
  io::require_writable(o.output);
  o.dwt.boundary = o.boundary == "periodic" ? wavelet::Boundary::periodic : wavelet::Boundary::symmetric;
  o.dwt.extension = o.extend == "replicate" ? wavelet::Extension::replicate
                    : o.extend == "mirror"  ? wavelet::Extension::mirror
                                            : wavelet::Extension::zero;
  (void)rejection(o);
  const auto wavelet =
      wavelet::make_wavelet(o.dwt.wavelet);  // wrong words are answered before a large file is read
  if (o.initialise == "interpolate") {
    o.dwt.initialisation = wavelet::Initialisation::interpolate;
    wavelet::require_interpolation(wavelet, o.dwt.boundary);
  }
  const volume::Volume volume = cli::load(o.input, record);
  const auto type = volume.voxel_type();
  const bool wide =
      type == volume::VoxelType::f64 || type == volume::VoxelType::i32 || type == volume::VoxelType::u32;
  const bool in_double = o.precision == "double" || (o.precision == "auto" && wide);
  return in_double ? analyze<double>(volume, o, record) : analyze<float>(volume, o, record);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Orthonormal 3-D wavelet transform of a volume: coefficients go to an OpenVDB file, one sparse grid a "
      "subband.\n"
      "Insignificant coefficients can be rejected; the error that this costs is known and reported. "
      "--inverse rebuilds."};
  Options options;
  declare(app, options);
  return cli::run(
      app,
      {.name = "vol-dwt",
       .example =
           "vol-phantom marschner-lobb -o - | vol-dwt - -o ml.vdb --wavelet coiflet-6 --keep-energy 0.999",
       .references = "Mallat 1989; Gross, Lippert, Dreger & Koch 1995",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
