// curv-tricubic: curvilinear grids as tricubic Bezier solids.
//   curv-tricubic bluntfinxyz.bin --plot3d auto --solution bluntfinq.bin -o fin.png --opacity nonlinear
//   curv-tricubic twisted-box.vts -o box.exr --thickness physical --stats box.json
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/camera_options.h"
#include "cli/grid_input.h"
#include "cli/options.h"
#include "cli/run.h"
#include "curvilinear/cast_solids.h"
#include "curvilinear/quality.h"
#include "curvilinear/sheets_within_error.h"
#include "io/scene.h"
#include "io/write_image.h"

namespace {

using namespace vol;
using namespace vol::curvilinear;

struct Options {
  cli::GridInput input;
  std::filesystem::path output, scene, transfer;
  std::string format, cells = "tricubic", opacity = "linear", thickness, order = "faces", method = "sheets";
  cli::CameraOptions camera;
  double gamma = 1, tolerance = 1e-6, max_error = 0;
  std::optional<double> reference_length;
  SheetOptions sheets;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("input", o.input.path, "Curvilinear grid: .vts, or PLOT3D's positions (.xyz)")
      ->required()
      ->group("Files");
  app.add_option("-o,--output", o.output,
                 "Picture (.exr: R, G, B, A, samples, of rays also depth, with --max-error also error; "
                 ".png); - is standard output")
      ->required()
      ->group("Files");
  app.add_option("--format", o.format, "exr or png [by extension; exr]")->group("Files");
  app.add_option("--scene", o.scene,
                 "Scene (YAML): camera, transfer function, background; without it hues from blue to red and "
                 "opacity 0 to 1 over the variable's range")
      ->group("Files");
  app.add_option("--transfer", o.transfer,
                 "Transfer function (YAML, ParaView's JSON) in place of the scene's")
      ->group("Files");
  cli::add_grid_options(app, o.input);
  cli::add_camera(app, o.camera, "Picture (overrules the scene)");

  const char* solid = "Cells";
  app.add_option("--cells", o.cells, "tricubic (C1 across cells) or trilinear")
      ->check(CLI::IsMember({"tricubic", "trilinear"}))
      ->capture_default_str()
      ->group(solid);
  app.add_option("--beta", o.sheets.beta,
                 "Tension of tricubic cells; 1 is Catmull-Rom, the only one of order 3")
      ->check(cli::check_positive)
      ->capture_default_str()
      ->group(solid);

  app.add_option("--method", o.method,
                 "sheets (the paper's: points of forward differences, composited sheet by sheet) or rays "
                 "(the reference: the integral along each ray through each solid, to --tolerance)")
      ->check(CLI::IsMember({"sheets", "rays"}))
      ->capture_default_str()
      ->group("Accuracy against cost");

  const char* light = "Opacity";
  app.add_option(
         "--thickness", o.thickness,
         "What opacity is for: layers (a cell, spread evenly over its sheets, as in the paper) or physical "
         "(the reference length, by the way of light inside each piece) [layers; of rays physical]")
      ->check(CLI::IsMember({"layers", "physical"}))
      ->group(light);
  app.add_option("--reference-length", o.reference_length,
                 "Physical: world length that opacities are for [the scene's; else the edge of a cube as "
                 "large as the mean cell]")
      ->check(cli::check_positive)
      ->group(light);
  app.add_option(
         "--opacity", o.opacity,
         "linear (as the transfer function has it) or nonlinear (its optical depth over gamma log m, m the "
         "smallest number of cells along an axis; log m counts as 1 where it is less)")
      ->check(CLI::IsMember({"linear", "nonlinear"}))
      ->capture_default_str()
      ->group(light);
  app.add_option("--gamma", o.gamma, "Of --opacity nonlinear: larger is more transparent")
      ->check(cli::check_positive)
      ->capture_default_str()
      ->group(light);

  app.add_option("--order", o.order,
                 "Cells front to back: faces (by what lies behind each face, and where there are several "
                 "blocks along each ray; cells in circles split) or depth (by their "
                 "nearest corner, as in the paper)")
      ->check(CLI::IsMember({"faces", "depth"}))
      ->capture_default_str()
      ->group("Accuracy against cost");
  app.add_option(
         "--throttle", o.sheets.throttle,
         "Pixels from point to point and from sheet to sheet: above 1 faster, with voids; below 1 with more "
         "redundant points. With --thickness physical there are neither: from sheet to sheet, and cells' "
         "shapes "
         "within a tenth of it")
      ->check(CLI::Range(1.0 / 64, 1024.0))
      ->capture_default_str()
      ->group("Accuracy against cost");
  app.add_option("--tolerance", o.tolerance,
                 "Of --method rays: absolute error of a pixel, on the colour scale")
      ->check(cli::check_positive)
      ->capture_default_str()
      ->group("Accuracy against cost");
  auto* max_error =
      app.add_option(
             "--max-error", o.max_error,
             "Largest estimated error of a picture by sheets of physical thickness, colour scale 0 to 1: "
             "sets the throttle, draws small cells together, and pixels whose estimate is above it by "
             "rays. Random pixels of sheets are checked against rays; no guarantee: where the last check "
             "took n, with 95 % confidence less than 4.4/n of its like are off by more. Status 2 if the "
             "estimate is above it")
          ->check(cli::check_positive)
          ->group("Accuracy against cost");
  for (const char* of_sheets : {"--throttle", "--order"})
    app.get_option(of_sheets)->excludes(app.get_option("--tolerance"))->excludes(max_error);
  max_error->excludes(app.get_option("--tolerance"));
}

/// The paper's: hues from blue to red (linear RGB) and opacity from 0 to 1 over the range.
transfer::TransferFunction hue_ramp(double low, double high) {
  if (!(high > low)) high = low + 1;  // one value alone: blue, invisible
  const auto at = [&](double share) { return low + share * (high - low); };
  return {{{low, {0, 0, 1}},
           {at(0.25), {0, 1, 1}},
           {at(0.5), {0, 1, 0}},
           {at(0.75), {1, 1, 0}},
           {high, {1, 0, 0}}},
          {{low, 0}, {high, 1}}};
}

/// The scene file with the command line over it.
io::SceneFile resolve(Options& o, cli::Record& record) {
  io::SceneFile file = o.scene.empty() ? io::SceneFile{} : io::read_scene(o.scene);
  if (!o.scene.empty()) record.input(o.scene);
  if (!o.transfer.empty()) {
    file.scene.transfer = io::read_transfer_function(o.transfer);
    file.has_transfer = true;
    record.input(o.transfer);
  }
  if (file.scene.model != render::Model::composite) throw Error("--scene: the model must be composite");
  if (file.scene.shading) record.warn("the scene's shading is left out: sheets are drawn without");
  cli::apply(o.camera, file.scene.view);
  if (o.opacity == "linear" && o.gamma != 1) throw Error("--gamma goes with --opacity nonlinear");
  const bool rays = o.method == "rays";
  if (rays && o.max_error > 0) throw Error("--max-error goes with sheets; rays have --tolerance");
  if (o.thickness.empty()) o.thickness = rays || o.max_error > 0 ? "physical" : "layers";
  if (o.max_error > 0 && o.thickness == "layers")
    throw Error("--max-error goes with --thickness physical: layers follow no length that rays could check");
  if (rays && o.thickness == "layers")
    throw Error("--thickness layers: rays know no layers, their thickness is physical");
  if (o.thickness == "layers" && o.reference_length)
    throw Error("--reference-length goes with --thickness physical");
  o.sheets.cells = o.cells == "tricubic" ? CellKind::tricubic : CellKind::trilinear;
  o.sheets.thickness = o.thickness == "layers" ? Thickness::layers : Thickness::physical;
  o.sheets.order = o.order == "faces" ? CellOrder::faces : CellOrder::depth;
  return file;
}

void count(const SheetCounts& counts, cli::Record& record) {
  record.count("cells", counts.cells);
  record.count("circles", counts.circles);
  record.count("split", counts.split);
  record.count("unresolved", counts.unresolved);
  record.count("sheets", counts.sheets);
  record.count("points", counts.points);
  record.count("samples", counts.samples);
  record.count("redundant", counts.redundant);
  record.count("holes", counts.holes);
}

image::Image draw_by_sheets(const Grid& grid, const cli::GridVariable& variable, const render::Scene& scene,
                            const Options& o, cli::Record& record) {
  const auto size = cli::parse_image_size("--size", o.camera.size);
  const Box3 bounds = grid.bounds();
  const camera::Camera camera(scene.view, bounds.centre(), bounds.size().maxCoeff(), size[0], size[1]);
  SheetResult result = record.repeated("render", [&] {
    return draw_sheets(grid, variable.values, camera, scene.transfer, scene.reference_length, o.sheets);
  });
  count(result.counts, record);
  return std::move(result.image);
}

image::Image draw_within(const Grid& grid, const cli::GridVariable& variable, const render::Scene& scene,
                         const Options& o, cli::Record& record) {
  const auto size = cli::parse_image_size("--size", o.camera.size);
  const auto rays = record.timed(
      "prepare", [&] { return SolidRays(grid, variable.values, o.sheets.cells, o.sheets.beta); });
  render::Scene plain = scene;
  plain.shading.reset();
  WithinErrorResult result = record.repeated("render", [&] {
    return draw_within_error(rays, variable.values, plain, size[0], size[1], o.sheets, o.max_error);
  });
  count(result.counts.sheets, record);
  record.count("samples_in_all", result.counts.samples);
  record.count("rays", result.counts.rays);
  record.count("ray_samples", result.counts.ray_samples);
  record.count("redrawn", result.counts.redrawn);
  record.count("checked", result.counts.checked);
  record.count("missed", result.counts.missed);
  record.result("throttle", result.throttle);
  record.result("last_checked", result.last_checked);
  record.error("pixel_maximum_estimate", result.error_estimate);
  record.error("checked_maximum", result.largest_checked);
  if (!(result.error_estimate <= o.max_error)) {
    throw Error("--max-error: the estimate reached is " + nlohmann::json(result.error_estimate).dump() +
                "; allow more, or take --method rays with a --tolerance");
  }
  return std::move(result.image);
}

image::Image draw_by_rays(const Grid& grid, const cli::GridVariable& variable, const render::Scene& given,
                          const Options& o, cli::Record& record) {
  render::Scene scene = given;
  const auto size = cli::parse_image_size("--size", o.camera.size);
  render::RenderOptions options;
  options.width = size[0];
  options.height = size[1];
  options.tolerance = o.tolerance;
  scene.reference_length *= o.sheets.thinned_by;  // the same extinction
  const auto rays = record.timed(
      "prepare", [&] { return SolidRays(grid, variable.values, o.sheets.cells, o.sheets.beta); });
  render::RenderResult result = record.repeated("render", [&] { return cast_solids(rays, scene, options); });
  record.count("rays", result.counts.rays);
  record.count("samples", result.counts.samples);
  record.error("pixel_maximum_estimate", result.error_estimate);
  if (result.error_estimate > 10 * o.tolerance) {
    record.warn("the reference reached an error of about " + std::to_string(result.error_estimate));
  }
  return std::move(result.image);
}

int work(Options& o, cli::Record& record) {
  io::require_image_format(o.output, o.format);
  io::SceneFile file = resolve(o, record);  // wrong words are answered before a large file is read
  render::Scene& scene = file.scene;
  (void)cli::parse_image_size("--size", o.camera.size);
  const Grid grid = cli::load(o.input, record);
  const cli::GridVariable variable = cli::variable(o.input, grid, record);
  if (!file.has_transfer) scene.transfer = hue_ramp(variable.low, variable.high);
  if (o.reference_length) scene.reference_length = *o.reference_length;
  if (scene.reference_length == 0) scene.reference_length = mean_cell_edge(grid);
  if (!(scene.reference_length > 0)) throw Error(o.input.path.string() + ": its cells have no volume");
  if (o.opacity == "nonlinear") o.sheets.thinned_by = global_layers(grid, o.gamma);
  record.resolved("scene", io::to_json(scene));
  record.resolved("thinned_by", o.sheets.thinned_by);

  const auto draw = o.max_error > 0 ? draw_within : o.method == "sheets" ? draw_by_sheets : draw_by_rays;
  image::Image picture = draw(grid, variable, scene, o, record);
  for (const auto& [key, value] : record.provenance()) picture.attributes[key] = value;
  const Vec3& b = scene.background;
  picture.attributes["precis.background"] = nlohmann::json{b[0], b[1], b[2]}.dump();
  record.timed("write", [&] { io::write_image(o.output, picture, o.format, {b[0], b[1], b[2]}); });
  record.output(o.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Draws a curvilinear grid as tricubic Bezier solids, cells front to back, by sheets of points or along "
      "rays.\n"
      "Opacity goes by cell and layer, as in the paper, or by the length of light's way (--thickness "
      "physical)."};
  Options options;
  declare(app, options);
  return cli::run(
      app,
      {.name = "curv-tricubic",
       .example = "vol-phantom half-torus --dims 13x5x5 -o torus.vts && curv-tricubic torus.vts -o "
                  "torus.png --view 20,40",
       .references = "Bethel 1993",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
