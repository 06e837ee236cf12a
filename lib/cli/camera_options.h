#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "camera/camera.h"

namespace vol::cli {

/// A view on the command line, over that of a scene: the same words in every renderer that has one picture.
struct CameraOptions {
  std::string size = "512x512";      ///< --size, pixels (parse_image_size)
  std::string view;                  ///< --view AZIMUTH,ELEVATION; empty: the scene's
  std::optional<double> width, fov;  ///< --width, world units: orthographic; --fov, degrees: perspective
};

/// Declares --size, --view, --width and --fov in a group of the help.
void add_camera(CLI::App& app, CameraOptions& options, const std::string& group);

/// Puts what was given over a view. Throws vol::Error on angles that are none.
void apply(const CameraOptions& options, camera::View& view);

}  // namespace vol::cli
