// wavelet-raycast: pictures of the field that wavelet coefficients stand for, without rebuilding the volume.
//   vol-dwt head.nrrd -o head.vdb --wavelet coiflet-6 --keep-energy 0.999
//   wavelet-raycast head.vdb -o head.exr --view 30,20 --size 256x256 --stats head.json
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "base/error.h"
#include "cli/camera_options.h"
#include "cli/composite_options.h"
#include "cli/naming.h"
#include "cli/options.h"
#include "cli/run.h"
#include "image/exposure.h"
#include "io/scene.h"
#include "io/vdb.h"
#include "io/volume.h"
#include "io/write_image.h"
#include "render/wavelet_footprints.h"
#include "render/wavelet_xray.h"
#include "wavelet/significance.h"

namespace {

using namespace vol;

constexpr double kFootprintError = 1e-4;

struct Options {
  std::filesystem::path input, output, scene;
  std::string format, model = "xray";
  cli::CameraOptions camera;
  cli::CompositeOptions composite;
  std::optional<double> every;
  std::optional<double> exposure;
  std::string levels, region;
  std::optional<std::int64_t> budget;
  wavelet::ExpansionOptions expansion;
  std::string algorithm = "rays";
  std::optional<double> footprint_error;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("input", o.input, "Coefficients of vol-dwt (.vdb); - is standard input")
      ->required()
      ->group("Files");
  app.add_option("-o,--output", o.output,
                 "Picture (.exr: R, G, B, A, samples: coefficients met, depth; .png); - is standard output")
      ->required()
      ->group("Files");
  app.add_option("--format", o.format, "exr or png [by extension; exr]")->group("Files");
  app.add_option(
         "--scene", o.scene,
         "Scene (YAML): its camera and background; with --model composite its transfer function and shading")
      ->group("Files");
  app.add_option(
         "--every", o.every,
         "Pictures on the way: of the coarsest level first, then of finer ones too, one at most every so "
         "many seconds in the output's place; the last is the same as without")
      ->check(cli::check_positive)
      ->group("Files");

  const char* picture = "Picture (overrules the scene)";
  cli::add_camera(app, o.camera, picture);
  app.add_option("--model", o.model,
                 "xray (integral, value times world length), or composite (emission and absorption)")
      ->check(CLI::IsMember({"xray", "composite"}))
      ->capture_default_str()
      ->group(picture);
  app.add_option("--exposure", o.exposure,
                 "PNG: what values are multiplied by [the largest becomes white; composite: 1]")
      ->check(cli::check_positive)
      ->group(picture);

  const char* detail = "Level of detail (what of the file's coefficients is drawn)";
  app.add_option("--levels", o.levels,
                 "A:B, levels A to B, 1 the finest; the approximation belongs to the coarsest [all]")
      ->group(detail);
  app.add_option("--budget", o.budget, "The N of the largest energy [all]")
      ->check(cli::check_whole_number)
      ->group(detail);
  app.add_option("--region", o.region,
                 "x0,y0,z0:x1,y1,z1, voxels, half open: all detail inside; outside what --budget leaves, or "
                 "only the approximation where there is none")
      ->group(detail);

  cli::add_composite(app, o.composite);

  const char* accuracy = "Accuracy against cost";
  app.add_option(
         "--depth", o.expansion.depth,
         "Basis functions are cubic splines through their values at multiples of 2^-DEPTH, 1 to 14 "
         "(haar and battle-lemarie are exact). daubechies-4 and coiflet-6 are rough: up to 0.08 off at depth "
         "6, 0.02 at 10. Coefficients of --initialise interpolate go through the voxels from a depth of "
         "their "
         "levels on")
      ->check(CLI::Range(1, wavelet::kMaxDepth))
      ->capture_default_str()
      ->group(accuracy);
  app.add_option(
         "--algorithm", o.algorithm,
         "rays: each ray visits the coefficients that it meets, exactly. footprint: each coefficient adds "
         "its line integrals, tabulated once for the view, to the pixels it reaches (orthographic)")
      ->check(CLI::IsMember({"rays", "footprint"}))
      ->capture_default_str()
      ->group(accuracy);
  app.add_option(
         "--footprint-error", o.footprint_error,
         "Error of a pixel that footprints may make, a share of the range (largest minus smallest) of the "
         "picture's values; tables are refined, or left for exact integrals, until it is kept by their "
         "estimate [1e-4]")
      ->check(cli::check_positive)
      ->group(accuracy);
}

struct Levels {
  int finest, coarsest;
};

Levels parse_levels(const std::string& text) {
  std::istringstream in(text);
  Levels levels{};
  char colon = 0;
  if (in >> levels.finest >> colon >> levels.coarsest && colon == ':' && in.peek() == EOF &&
      levels.finest >= 0 && levels.finest <= levels.coarsest) {
    return levels;
  }
  throw Error("--levels " + text + ": expected A:B, two levels, the finer first, as 1:3");
}

/// l2 norm, scaled before squaring.
template <class T>
double norm(const Buffer<T>& coefficients) {
  double largest = 0, sum = 0;
  for (const T c : coefficients) largest = std::max(largest, std::abs(static_cast<double>(c)));
  if (largest == 0) return 0;
  for (const T c : coefficients) {
    const double scaled = static_cast<double>(c) / largest;
    sum += scaled * scaled;
  }
  return largest * std::sqrt(sum);
}

/// Sets to zero what is not to be drawn.
template <class T>
void limit_detail(wavelet::Decomposition<T>& d, const Options& o, cli::Record& record) {
  double not_drawn = 0;
  if (!o.levels.empty()) {
    const Levels levels = parse_levels(o.levels);
    const int finest = std::min(1, d.levels);  // 0 is the volume itself, where it was not transformed
    if (levels.finest < finest || levels.coarsest > d.levels) {
      throw Error("--levels " + o.levels + ": the coefficients have levels " + std::to_string(finest) +
                  " to " + std::to_string(d.levels));
    }
    for (auto& band : d.subbands) {
      if (band.level >= levels.finest && band.level <= levels.coarsest) continue;
      not_drawn = std::hypot(not_drawn, norm(band.coefficients));
      std::fill(band.coefficients.begin(), band.coefficients.end(), T{0});
    }
  }
  wavelet::Rejection rejection{.keep = o.budget};
  if (!o.region.empty()) {
    const auto box = cli::parse_region("--region", o.region);
    rejection.region = wavelet::VoxelBox{box.lower, box.upper};
  }
  if (rejection.any()) not_drawn = std::hypot(not_drawn, wavelet::reject(d, rejection).rejected_norm);
  if (!o.levels.empty() || rejection.any()) record.result("norm_not_drawn", not_drawn);
}

/// What a picture cost, by its model.
struct Costs {
  render::CompositeCounts composite;
  render::WaveletCounts xray;
};

render::RenderResult drawn(const wavelet::Expansion& expansion, const render::Scene& scene,
                           const render::RenderOptions& options, const render::CompositeOptions& composite,
                           const Options& o, Costs& costs) {
  if (scene.model == render::Model::composite) {
    return render::WaveletComposite(expansion, scene, options, composite).draw(&costs.composite);
  }
  if (o.algorithm == "footprint") {
    return render::WaveletFootprints(expansion, scene, options, o.footprint_error.value_or(kFootprintError))
        .draw();
  }
  return render::WaveletXray(expansion).draw(scene, options, &costs.xray);
}

void write(image::Image& picture, const render::Scene& scene, const Options& o, cli::Record& record) {
  for (const auto& [key, value] : record.provenance()) picture.attributes[key] = value;
  const Vec3& b = scene.background;
  picture.attributes["precis.background"] = nlohmann::json{b[0], b[1], b[2]}.dump();
  // The values of an X-ray are no colours.
  const double own = scene.model == render::Model::composite ? 1 : image::exposure_to_white(picture);
  record.timed("write", [&] {
    io::write_image(o.output, picture, o.format, {b[0], b[1], b[2]}, o.exposure.value_or(own));
  });
}

/// Pictures of the coarser levels alone, each in the place of the one before it.
template <class Draw>
void draw_on_the_way(const wavelet::Expansion& expansion, const render::Scene& scene, const Options& o,
                     const Draw& draw, cli::Record& record) {
  std::set<int> levels;
  for (const auto& band : expansion.bands()) levels.insert(band.level);
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> last;
  std::int64_t written = 0;
  for (auto level = levels.rbegin(); level != levels.rend() && *level != *levels.begin(); ++level) {
    auto result =
        record.timed("coarse", [&] { return draw(expansion.from_level(*level, o.expansion.memory_limit)); });
    if (last && std::chrono::duration<double>(Clock::now() - *last).count() < *o.every) continue;
    result.image.attributes["precis.levels_drawn"] =
        std::to_string(*level) + ":" + std::to_string(*levels.rbegin());
    write(result.image, scene, o, record);
    last = Clock::now();
    ++written;
  }
  record.count("pictures_on_the_way", written);
}

render::RenderResult by_footprints(const wavelet::Expansion& expansion, const render::Scene& scene,
                                   const render::RenderOptions& options, const Options& o,
                                   cli::Record& record) {
  std::optional<render::WaveletFootprints> footprints;
  record.timed("tables", [&] {
    footprints.emplace(expansion, scene, options, o.footprint_error.value_or(kFootprintError));
  });
  auto result = record.repeated("render", [&] { return footprints->draw(); });
  const auto& report = footprints->report();
  record.count("terms_by_boxes", report.terms_boxes);
  record.count("terms_by_products", report.terms_products);
  record.count("terms_by_tables", report.terms_tables);
  record.count("terms_exact", report.terms_exact);
  record.count("footprints", report.tables);
  record.count("table_bytes", report.table_bytes);
  record.error("footprint_error_allowed", report.allowed);
  record.error("footprint_error_estimate", report.estimate);
  record.error("footprint_error_found", report.found);
  return result;
}

int work(Options& o, cli::Record& record) {
  io::require_image_format(o.output, o.format);
  if (o.every && io::is_standard_stream(o.output)) {
    throw Error("--every: pictures that replace each other go to a file, not to standard output");
  }
  if (o.footprint_error && o.algorithm != "footprint") {
    throw Error("--footprint-error is for --algorithm footprint: rays are exact");
  }
  if (o.algorithm == "footprint" && o.model != "xray") {
    throw Error(
        "--algorithm footprint: line integrals are of --model xray; composite pictures take --algorithm "
        "rays");
  }
  io::SceneFile file = o.scene.empty() ? io::SceneFile{} : io::read_scene(o.scene);
  cli::apply(o.camera, file.scene.view);
  file.scene.model = o.model == "xray" ? render::Model::xray : render::Model::composite;
  const render::CompositeOptions composite = cli::resolve(o.composite, file, record);
  render::RenderOptions options;
  options.tolerance = o.composite.tolerance.value_or(cli::kCompositeTolerance);
  const auto size = cli::parse_image_size("--size", o.camera.size);
  options.width = size[0];
  options.height = size[1];
  if (!o.levels.empty()) (void)parse_levels(o.levels);  // wrong words are answered before a file is read
  if (!o.region.empty()) (void)cli::parse_region("--region", o.region);
  if (!o.scene.empty()) record.input(o.scene);
  record.input(o.input);
  o.expansion.memory_limit = io::ReadOptions::physical_memory();
  auto coefficients = record.timed("read", [&] { return io::read_coefficients(o.input); });
  const auto expansion = record.timed("prepare", [&] {
    return cli::naming(o.input, [&] {
      return std::visit(
          [&](auto& d) {
            if (d.initialisation == wavelet::Initialisation::interpolate && o.expansion.depth < d.levels) {
              record.warn("--depth is below the " + std::to_string(d.levels) +
                          " levels: the field does not go through the voxels");
            }
            limit_detail(d, o, record);
            return wavelet::Expansion(std::move(d), o.expansion);
          },
          coefficients.decomposition);
    });
  });
  record.resolved("scene", io::to_json(file.scene));
  record.count("coefficients", expansion.coefficients());
  record.count("planned_bytes", expansion.planned_bytes());
  record.error("phi_deviation", expansion.phi_deviation());
  record.error("psi_deviation", expansion.psi_deviation());

  Costs costs;
  const auto draw = [&](const wavelet::Expansion& e) {
    return drawn(e, file.scene, options, composite, o, costs);
  };
  if (o.every) draw_on_the_way(expansion, file.scene, o, draw, record);
  auto result = o.algorithm == "footprint" ? by_footprints(expansion, file.scene, options, o, record)
                                           : record.repeated("render", [&] { return draw(expansion); });
  if (file.scene.model == render::Model::composite) {
    cli::report(result, costs.composite, o.composite, record);
  } else if (o.algorithm == "rays") {
    record.count("pieces", costs.xray.pieces);
  }
  record.count("rays", result.counts.rays);
  record.count("coefficients_met", result.counts.samples);
  write(result.image, file.scene, o, record);
  record.output(o.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Pictures of the field that wavelet coefficients stand for, without rebuilding the volume: X-rays, or\n"
      "with self-occlusion. Along a ray the field is a polynomial between knots, integrated exactly."};
  Options options;
  declare(app, options);
  return cli::run(
      app,
      {.name = "wavelet-raycast",
       .example = "vol-phantom gaussian --dims 32 -o - | vol-dwt - -o - --wavelet haar --keep 500 | "
                  "wavelet-raycast - -o picture.exr --view 30,20 --size 128x128",
       .references = "Gross, Lippert, Dreger & Koch 1995",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
