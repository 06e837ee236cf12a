// tf-fit: Bezier transfer curves for Fourier volume rendering, fitted to what the user wants to see.
//   tf-fit bone.yaml -o fitted.yaml --points 6 --volume head.nrrd
//   tf-fit --band bone=1150:3926=1 --band skin=300:900=0.4 --band-colours 1,1,0.9:0.9,0.6,0.5
//   --range=-1024,3926 -o fitted.yaml
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "cli/fit_target.h"
#include "cli/naming.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/volume_input.h"
#include "fit/bezier_fit.h"
#include "io/file.h"
#include "io/scene.h"

namespace {

using namespace vol;

struct Options {
  cli::FitTargetOptions target;
  std::filesystem::path output, volume;
  std::optional<int> points;
  std::optional<double> error_below;
  std::string weight, quantity = "weight", bounds_on = "points", loss = "none", curve = "even";
  std::vector<double> range, bounds;
  std::optional<double> loss_scale;
  int samples = 1024;
  fit::FitOptions fit;
};

void declare(CLI::App& app, Options& o) {
  cli::add_fit_target(app, o.target);
  app.add_option("-o,--output", o.output, "Transfer function of Bezier curves (.yaml); - is standard output")
      ->required()
      ->group("Files");
  app.add_option("--volume", o.volume,
                 "Volume whose histogram says what counts, and whose range is fitted over")
      ->group("Files");

  const char* target = cli::kFitTargetGroup;
  app.add_option("--range", o.range,
                 "Values of v = 0 and v = 1 [of the volume, else of the target file; of --band alone 0,1]")
      ->delimiter(',')
      ->expected(2)
      ->type_name("LO,HI")
      ->group(target);
  app.add_option("--fit", o.quantity,
                 "weight: B(v) comes close to the target; emission: v B(v), what a picture adds up")
      ->check(CLI::IsMember({"weight", "emission"}))
      ->capture_default_str()
      ->group(target);

  const char* curve = "Curve";
  app.add_option("--points", o.points, "Control points, 1 to 21; with --error-below the most [6; 21]")
      ->check(CLI::Range(1, transfer::kMostControlPoints))
      ->group(curve);
  app.add_option("--error-below", o.error_below,
                 "The fewest points whose RMS is at most this; status 2 if none has")
      ->check(cli::check_non_negative)
      ->group(curve);
  app.add_option("--curve", o.curve,
                 "even: points evenly spaced in v, as spectra need them; parametric: their abscissae are "
                 "fitted too (vol-raycast alone draws it)")
      ->check(CLI::IsMember({"even", "parametric"}))
      ->capture_default_str()
      ->group(curve);
  app.add_flag("--free-range", o.fit.free_range, "Fit the values of v = 0 and v = 1, too, from --range on")
      ->group(curve);
  app.add_option("--bounds", o.bounds, "Least and largest weight [0,2]")
      ->delimiter(',')
      ->expected(2)
      ->type_name("LO,HI")
      ->group(curve);
  app.add_option("--bounds-on", o.bounds_on,
                 "What keeps them: the control points, and so the curve; the curve alone; or none")
      ->check(CLI::IsMember({"points", "curve", "none"}))
      ->capture_default_str()
      ->group(curve);

  const char* error = "What counts";
  app.add_option(
         "--weight", o.weight,
         "Of a value: uniform, or by its voxels in the volume n: histogram n, log-histogram log(1 + n) "
         "[histogram with --volume, else uniform]")
      ->check(CLI::IsMember({"uniform", "histogram", "log-histogram"}))
      ->group(error);
  app.add_option("--samples", o.samples,
                 "Places of the uniform weight, bins of volumes that are not integers")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str()
      ->group(error);
  app.add_option("--loss", o.loss, "Of a residual: none (its square), huber or cauchy (less for outliers)")
      ->check(CLI::IsMember({"none", "huber", "cauchy"}))
      ->capture_default_str()
      ->group(error);
  app.add_option("--loss-scale", o.loss_scale,
                 "Residual from which on a loss counts less than the square [0.1]")
      ->check(cli::check_positive)
      ->group(error);
  app.add_option("--smoothness", o.fit.smoothness,
                 "Added to the mean square: this times the squared second differences of the points")
      ->check(cli::check_non_negative)  // CLI::Range lets NaN pass
      ->check(CLI::Range(0.0, 1e12))
      ->capture_default_str()
      ->group(error);
}

fit::FitOptions fit_options(const Options& o, cli::Record& record) {
  fit::FitOptions f = o.fit;
  f.points = o.points.value_or(o.error_below ? transfer::kMostControlPoints : 6);
  f.quantity = o.quantity == "emission" ? fit::Quantity::emission : fit::Quantity::weight;
  f.bounds = o.bounds_on == "points"  ? fit::Bounds::points
             : o.bounds_on == "curve" ? fit::Bounds::curve
                                      : fit::Bounds::none;
  if (!o.bounds.empty()) {
    if (f.bounds == fit::Bounds::none) throw Error("--bounds: --bounds-on none keeps none");
    f.least = o.bounds[0];
    f.most = o.bounds[1];
  }
  if (!(f.least < f.most) || !std::isfinite(f.most - f.least)) {
    throw Error("--bounds: two numbers are expected, the first below the second");
  }
  f.loss = o.loss == "huber" ? fit::Loss::huber : o.loss == "cauchy" ? fit::Loss::cauchy : fit::Loss::none;
  if (o.loss_scale) {
    if (f.loss == fit::Loss::none) throw Error("--loss-scale is for --loss huber or cauchy");
    f.loss_scale = *o.loss_scale;
  }
  if (f.bounds != fit::Bounds::none) record.resolved("bounds", {f.least, f.most});
  if (f.loss != fit::Loss::none) record.resolved("loss-scale", f.loss_scale);
  f.parametric = o.curve == "parametric";
  return f;
}

fit::Samples samples_of(const Options& o, cli::FitTargets& wanted, cli::Record& record) {
  if (!o.range.empty()) wanted.range = {o.range[0], o.range[1]};
  if (o.volume.empty()) {
    if (!o.weight.empty() && o.weight != "uniform") throw Error("--weight " + o.weight + " needs --volume");
    return fit::uniform_samples(wanted.range, o.samples);
  }
  const volume::Volume volume = cli::load(o.volume, {}, record);
  return cli::naming(o.volume, [&] {
    if (o.range.empty()) wanted.range = volume::value_range(volume);
    const auto weighting = fit::weighting_from_name(o.weight.empty() ? "histogram" : o.weight);
    if (weighting == fit::Weighting::uniform) return fit::uniform_samples(wanted.range, o.samples);
    return record.timed("histogram",
                        [&] { return fit::histogram_samples(volume, wanted.range, o.samples, weighting); });
  });
}

void report(const fit::Fit& found, const std::vector<cli::FitTarget>& targets, cli::Record& record) {
  const int points = static_cast<int>(found.curves.front().ordinates().size());
  nlohmann::json curves = nlohmann::json::array();
  fit::Residual worst;
  for (std::size_t c = 0; c < found.curves.size(); ++c) {
    const fit::Residual& r = found.residuals[c];
    curves.push_back({{"name", targets[c].name},
                      {"points", found.curves[c].ordinates()},
                      {"abscissae", found.curves[c].abscissae()},
                      {"residual_rms", r.rms},
                      {"residual_largest", r.largest}});
    worst.rms = std::max(worst.rms, r.rms);
    worst.largest = std::max(worst.largest, r.largest);
  }
  record.result("curves", curves);
  record.result("range", {found.range.min, found.range.max});
  record.result("method", found.method);
  record.result("rank", found.rank);
  record.result("condition",
                std::isfinite(found.condition) ? nlohmann::json(found.condition) : nlohmann::json());
  record.error("residual_rms", worst.rms);
  record.error("residual_largest", worst.largest);
  record.count("points", points);
  record.count("iterations", found.iterations);
  if (found.rank < points && found.method == "qr") {
    record.warn("rank " + std::to_string(found.rank) + " of " + std::to_string(points) +
                ": many curves are as near, of their control points the shortest were taken");
  }
  char text[160];
  std::snprintf(text, sizeof text, "%d points by %s: RMS %.4g, largest %.4g, condition %.3g", points,
                found.method.c_str(), worst.rms, worst.largest, found.condition);
  record.say(text);
}

int work(const Options& o, cli::Record& record) {
  if (!io::is_standard_stream(o.output) && o.output.extension() != ".yaml" &&
      o.output.extension() != ".yml") {
    throw Error(o.output.string() + ": a transfer function goes to a .yaml file, or to - (standard output)");
  }
  io::require_writable(o.output);
  const fit::FitOptions f = fit_options(o, record);  // wrong words are answered before a large file is read
  cli::FitTargets wanted = cli::fit_targets(o.target, record);
  const fit::Samples samples = samples_of(o, wanted, record);
  record.resolved("range", {wanted.range.min, wanted.range.max});
  std::vector<std::vector<double>> targets;
  for (const auto& target : wanted.curves) targets.push_back(samples.targets(target.weight));
  cli::require_samples(o.target, samples);
  const fit::Fit found = record.repeated("fit", [&] {
    return o.error_below ? fit::fit_within(samples, targets, f, *o.error_below)
                         : fit::fit_bezier(samples, targets, f);
  });
  report(found, wanted.curves, record);
  transfer::BezierTransfer bezier{found.range.min, found.range.max, {}};
  for (std::size_t c = 0; c < found.curves.size(); ++c) {
    bezier.bands.push_back({wanted.curves[c].name, wanted.curves[c].colour, found.curves[c]});
  }
  record.timed("write", [&] { io::write_bezier(o.output, bezier, record.provenance()); });
  record.output(o.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Bezier transfer curves fitted to a target: weights B(v) for fvr-slice, vol-fft and vol-raycast, v\n"
      "the data value scaled to 0 to 1. Linear fits by QR; other losses and unknowns by Ceres."};
  Options options;
  declare(app, options);
  return cli::run(app,
                  {.name = "tf-fit",
                   .example = "tf-fit --band 0.5:0.8=1 -o fitted.yaml --points 8",
                   .references = "Cheng 2007",
                   .repeats = true},
                  argc, argv, [&](cli::Record& record) { return work(options, record); });
}
