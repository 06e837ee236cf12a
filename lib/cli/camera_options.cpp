#include "cli/camera_options.h"

#include "cli/options.h"

namespace vol::cli {

void add_camera(CLI::App& app, CameraOptions& options, const std::string& group) {
  app.add_option("--size", options.size, "WIDTHxHEIGHT in pixels")->capture_default_str()->group(group);
  app.add_option("--view", options.view, "AZIMUTH,ELEVATION in degrees [0,0: along -z]")->group(group);
  auto* width =
      app.add_option("--width", options.width, "World width of the picture, orthographic [1.6 longest edge]")
          ->check(check_positive)
          ->group(group);
  app.add_option("--fov", options.fov, "Vertical field of view in degrees: a perspective view")
      ->check(CLI::Range(1e-3, 179.0))
      ->excludes(width)
      ->group(group);
}

void apply(const CameraOptions& options, camera::View& view) {
  if (!options.view.empty()) {
    const auto angles = parse_view("--view", options.view);
    view.azimuth = angles[0];
    view.elevation = angles[1];
  }
  if (options.width) {
    view.width = options.width;
    view.projection = camera::Projection::orthographic;
  }
  if (options.fov) {
    view.fov = *options.fov;
    view.width.reset();
    view.projection = camera::Projection::perspective;
  }
}

}  // namespace vol::cli
