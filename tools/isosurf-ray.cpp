// isosurf-ray: an isosurface of a volume as a picture, by rays that do not miss.
//   isosurf-ray head.nrrd --isovalue 90 -o head.exr
//   isosurf-ray head.nrrd --isovalue 90 -o head.png --view 30,20 --reconstruction b-spline
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "cli/camera_options.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/volume_input.h"
#include "io/scene.h"
#include "io/write_image.h"
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
};

void declare(CLI::App& app, Options& o) {
  cli::add_volume_input(app, o.input);
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
  app.add_option("--reconstruction", o.reconstruction, "trilinear, catmull-rom, b-spline [trilinear]")
      ->check(CLI::IsMember({"trilinear", "catmull-rom", "b-spline"}))
      ->group(surface);
  app.add_flag("--close", o.close, "Close the surface at the volume's border: all beyond is outside")
      ->group(surface);
  app.add_option("--colour", o.colour, "R,G,B of the surface, linear, 0 to 1; one number is grey")
      ->capture_default_str()
      ->group(surface);

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

int work(Options& o, cli::Record& record) {
  io::require_image_format(o.output, o.format);
  const io::SceneFile file = resolve(o);
  const auto size = cli::parse_image_size("--size", o.camera.size);
  const Vec3 colour = cli::parse_colour("--colour", o.colour);
  if (!o.scene.empty()) record.input(o.scene);
  const volume::Volume volume = cli::load(o.input, record);
  const auto reconstruction = file.reconstruction.value_or(volume::Reconstruction::trilinear);
  record.resolved("scene", io::to_json(file.scene));
  record.resolved("reconstruction", render::name(reconstruction));
  const auto surface = record.timed(
      "prepare", [&] { return render::IsosurfaceRays(volume, reconstruction, o.isovalue, o.close); });
  auto drawn = record.repeated(
      "render", [&] { return render::draw_isosurface(surface, file.scene, colour, size[0], size[1]); });
  record.count("rays", drawn.counts.rays);
  record.count("hits", drawn.counts.hits);
  record.count("cells", drawn.counts.cells);
  record.count("undecided", drawn.counts.undecided);
  for (const auto& [key, value] : record.provenance()) drawn.image.attributes[key] = value;
  const Vec3& b = file.scene.background;
  drawn.image.attributes["precis.background"] = nlohmann::json{b[0], b[1], b[2]}.dump();
  record.timed("write", [&] { io::write_image(o.output, drawn.image, o.format, {b[0], b[1], b[2]}); });
  record.output(o.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "An isosurface of a volume as a picture: the first hit of every ray with the reconstructed field,\n"
      "by root isolation in each cell, which cannot skip a pair of roots; Blinn-Phong from the gradient."};
  Options options;
  declare(app, options);
  return cli::run(app,
                  {.name = "isosurf-ray",
                   .example = "vol-phantom marschner-lobb -o - | isosurf-ray - --isovalue 0.5 -o ml.exr "
                              "--view 30,40 --size 256x256",
                   .references = "Farouki & Rajan 1987; Blinn 1977",
                   .repeats = true},
                  argc, argv, [&](cli::Record& record) { return work(options, record); });
}
