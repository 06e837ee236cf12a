#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "cli/camera_options.h"
#include "cli/label_options.h"
#include "cli/surface_options.h"
#include "cli/volume_input.h"
#include "io/scene.h"

namespace vol::cli {

/// What vol-raycast is asked for. Target vol_cli_raycast.
struct RaycastOptions {
  VolumeInput input;
  std::filesystem::path output, scene, transfer, index, index_output, samples_output;
  double epsilon = 0.016;              ///< --epsilon, of --index auto
  std::optional<int> index_reduction;  ///< --index-reduction, of --index auto
  std::string format, model, quadrature, step, reconstruction, algorithm = "packet", layout = "rows";
  CameraOptions camera;
  SurfaceOptions surfaces;
  LabelOptions labels;
  std::optional<double> exposure;
  render::RenderOptions render;
  bool no_skip = false;
};

void add_raycast(CLI::App& app, RaycastOptions& options);

/// The scene file with the command line over it; fills options.render but for the step, which depends on the
/// volume. \throws vol::Error on wrong words, and on what cannot be drawn together
[[nodiscard]] io::SceneFile resolve_scene(RaycastOptions& options);

/// Whether a scene is the X-ray of the field weighted by Bezier curves.
[[nodiscard]] bool is_weighted(const io::SceneFile& file);

}  // namespace vol::cli
