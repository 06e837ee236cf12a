// isosurf-ray: an isosurface of a volume, or of wavelet coefficients, as a picture, by rays that do not miss.
//   isosurf-ray head.nrrd --isovalue 90 -o head.exr
//   isosurf-ray coefficients.vdb --isovalue 90 -o head.exr --stats head.json
//   isosurf-ray head.nrrd --isovalue 90 -o head.png --view 30,20 --reconstruction b-spline
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/error.h"
#include "cli/camera_options.h"
#include "cli/naming.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/volume_input.h"
#include "io/scene.h"
#include "io/vdb.h"
#include "io/volume.h"
#include "io/write_image.h"
#include "render/expansion_surface.h"
#include "render/isosurface_rays.h"
#include "render/names.h"

namespace {

using namespace vol;

struct Options {
  cli::VolumeInput input;
  std::filesystem::path output, scene;
  double isovalue = 0;
  std::string format, reconstruction, colour = "0.8";
  cli::CameraOptions camera;
  bool close = false;
  std::string bound, tolerance;  // of coefficients; empty: not given
  std::optional<int> depth;
};

constexpr std::array<std::pair<const char*, render::SurfaceBound>, 3> kBounds{
    {{"bernstein", render::SurfaceBound::bernstein},
     {"local", render::SurfaceBound::local},
     {"global", render::SurfaceBound::global}}};

void declare(CLI::App& app, Options& o) {
  cli::add_volume_input(
      app, o.input,
      "Volume (.nrrd .nhdr .mha .mhd .vti .vtk .nii .vdb or raw) or coefficients of vol-dwt (.vdb); - is "
      "standard input");
  app.add_option(
         "-o,--output", o.output,
         "Picture (.exr: R, G, B, A, depth, normal.x .. z, position.x .. z; .png); - is standard output")
      ->required()
      ->group("Files");
  app.add_option("--format", o.format, "exr or png [by extension; exr]")->group("Files");
  app.add_option("--scene", o.scene, "Scene (YAML): its camera, shading, background and reconstruction")
      ->group("Files");

  const char* surface = "Surface";
  app.add_option("--isovalue", o.isovalue,
                 "Value of the surface, in the volume's units; at least that is inside")
      ->required()
      ->check(cli::check_finite)
      ->group(surface);
  app.add_option("--reconstruction", o.reconstruction,
                 "Of a volume: trilinear, catmull-rom, b-spline [trilinear]")
      ->check(CLI::IsMember({"trilinear", "catmull-rom", "b-spline"}))
      ->group(surface);
  app.add_flag("--close", o.close, "Close the surface at the volume's border: all beyond is outside")
      ->group(surface);
  app.add_option("--colour", o.colour, "R,G,B of the surface, linear, 0 to 1; one number is grey")
      ->capture_default_str()
      ->group(surface);

  const char* coefficients = "Coefficients (their field itself, the volume never rebuilt)";
  app.add_option("--bound", o.bound,
                 "What a ray knows of the field between two points: bernstein, its polynomial between knots; "
                 "local, the Lipschitz bound of the coefficients at hand; global, one for the whole box, as "
                 "published: slow [bernstein]")
      ->check(CLI::IsMember({"bernstein", "local", "global"}))
      ->group(coefficients);
  app.add_option("--tolerance", o.tolerance,
                 "Along a ray, what is wider than this is not missed: world length, or multiples of the "
                 "smallest spacing [0.001v]")
      ->group(coefficients);
  app.add_option("--depth", o.depth,
                 "Basis functions are cubic splines through their values at multiples of 2^-DEPTH, 1 to 14 "
                 "(haar and battle-lemarie are exact) [6]")
      ->check(CLI::Range(1, wavelet::kMaxDepth))
      ->group(coefficients);

  const char* picture = "Picture (overrules the scene)";
  cli::add_camera(app, o.camera, picture);
}

/// The scene file with the command line over it.
io::SceneFile resolve(const Options& o) {
  io::SceneFile file = o.scene.empty() ? io::SceneFile{} : io::read_scene(o.scene);
  cli::apply(o.camera, file.scene.view);
  if (!o.reconstruction.empty()) file.reconstruction = render::reconstruction_from_name(o.reconstruction);
  if (!file.scene.shading) file.scene.shading = render::Shading{};
  return file;
}

struct Task {
  const Options& o;
  const io::SceneFile& file;
  Vec3 colour;
  int width, height;
};

image::Image draw_volume(const Task& task, io::InputFile& input, cli::Record& record) {
  const Options& o = task.o;
  if (!o.bound.empty() || !o.tolerance.empty() || o.depth) {
    throw Error(io::display_name(input.path()) +
                ": a volume, and --bound, --tolerance and --depth are for coefficients of vol-dwt");
  }
  const volume::Volume volume = cli::load(input, o.input, record);
  const auto reconstruction = task.file.reconstruction.value_or(volume::Reconstruction::trilinear);
  record.resolved("reconstruction", render::name(reconstruction));
  const auto surface = record.timed(
      "prepare", [&] { return render::IsosurfaceRays(volume, reconstruction, o.isovalue, o.close); });
  auto drawn = record.repeated("render", [&] {
    return render::draw_isosurface(surface, task.file.scene, task.colour, task.width, task.height);
  });
  record.count("rays", drawn.counts.rays);
  record.count("hits", drawn.counts.hits);
  record.count("cells", drawn.counts.cells);
  record.count("undecided", drawn.counts.undecided);
  return std::move(drawn.image);
}

image::Image draw_coefficients(const Task& task, io::InputFile& input, cli::Record& record) {
  const Options& o = task.o;
  if (!o.reconstruction.empty()) {
    throw Error(
        io::display_name(input.path()) +
        ": coefficients, whose field is that of their basis functions: --reconstruction is for volumes");
  }
  render::ExpansionSurfaceOptions options{.close = o.close};
  for (const auto& [name, bound] : kBounds) {
    if (o.bound == name) options.bound = bound;
  }
  wavelet::ExpansionOptions accuracy{.memory_limit = io::ReadOptions::physical_memory()};
  if (o.depth) accuracy.depth = *o.depth;
  record.input(input.path());
  auto coefficients = record.timed("read", [&] { return io::read_coefficients(input); });
  const auto expansion = record.timed("prepare", [&] {
    return cli::naming(input.path(), [&] {
      return std::visit([&](auto& d) { return wavelet::Expansion(std::move(d), accuracy); },
                        coefficients.decomposition);
    });
  });
  const std::string tolerance = o.tolerance.empty() ? "0.001v" : o.tolerance;
  options.tolerance = cli::parse_step("--tolerance", tolerance, expansion.geometry().spacing.minCoeff());
  const render::ExpansionSurface surface(expansion, o.isovalue, options);
  record.count("coefficients", expansion.coefficients());
  record.error("phi_deviation", expansion.phi_deviation());
  record.error("psi_deviation", expansion.psi_deviation());
  record.error("tolerance", surface.tolerance());
  auto drawn = record.repeated("render", [&] {
    return render::draw_expansion_surface(surface, task.file.scene, task.colour, task.width, task.height);
  });
  const auto& counts = drawn.counts;
  record.count("rays", counts.rays);
  record.count("hits", counts.hits);
  record.count("evaluations", counts.evaluations);
  record.count("bounds", counts.bounds);
  record.count("polynomials", counts.polynomials);
  record.count("terms", counts.terms);
  record.count("undecided", counts.undecided);
  const auto rays = static_cast<double>(std::max<std::int64_t>(counts.rays, 1));
  record.result("evaluations_per_ray", static_cast<double>(counts.evaluations) / rays);
  return std::move(drawn.image);
}

int work(Options& o, cli::Record& record) {
  io::require_image_format(o.output, o.format);
  const io::SceneFile file = resolve(o);
  const auto size = cli::parse_image_size("--size", o.camera.size);
  if (!o.tolerance.empty()) (void)cli::parse_step("--tolerance", o.tolerance, 1);  // before a file is read
  if (!o.scene.empty()) record.input(o.scene);
  record.resolved("scene", io::to_json(file.scene));
  const Task task{o, file, cli::parse_colour("--colour", o.colour), size[0], size[1]};
  io::InputFile input(o.input.path);
  const bool coefficients =
      o.input.raw_dims.empty() && io::is_vdb(input.peek(8)) && io::is_coefficients(input);
  image::Image image =
      coefficients ? draw_coefficients(task, input, record) : draw_volume(task, input, record);
  for (const auto& [key, value] : record.provenance()) image.attributes[key] = value;
  const Vec3& b = file.scene.background;
  image.attributes["precis.background"] = nlohmann::json{b[0], b[1], b[2]}.dump();
  record.timed("write", [&] { io::write_image(o.output, image, o.format, {b[0], b[1], b[2]}); });
  record.output(o.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "An isosurface of a volume, or of wavelet coefficients, as a picture: the first hit of every ray with "
      "the "
      "field,\nby root isolation, which cannot skip a pair of roots; Blinn-Phong from the gradient."};
  Options options;
  declare(app, options);
  return cli::run(
      app,
      {.name = "isosurf-ray",
       .example = "vol-phantom marschner-lobb -o - | isosurf-ray - --isovalue 0.5 -o ml.exr "
                  "--view 30,40 --size 256x256",
       .references =
           "Farouki & Rajan 1987; Kalra & Barr 1989; Gross, Lippert, Dreger & Koch 1995; Blinn 1977",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
