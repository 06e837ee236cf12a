#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "render/options.h"
#include "transfer/bezier.h"
#include "transfer/profile.h"

namespace vol::io {

// clang-format off
/// What a scene file says; what it leaves out is the program's default.
///
///     camera: {azimuth: 30, elevation: 20, width: 100}   # or fov, distance (perspective); target, up
///     transfer: bone.yaml            # beside the scene; or the map of a transfer function, inline
///     reference_length: 1            # world length the opacities are for; default: the smallest spacing
///     shading: true                  # or {ambient, diffuse, specular, exponent, light: [x, y, z]} [none]
///     background: [0, 0, 0]          # linear RGB
///     model: composite               # or xray, mip
///     quadrature: trapezoid
///     step: 0.5v                     # or a world length
///     reconstruction: trilinear
// clang-format on
struct SceneFile {
  render::Scene scene;
  bool has_transfer = false;
  std::optional<transfer::BezierTransfer> bezier;  ///< where the transfer function is one of Bezier curves
  std::optional<render::Quadrature> quadrature;
  std::optional<std::string> step;  ///< as --step takes it
  std::optional<volume::Reconstruction> reconstruction;
};

/// Reads a scene (YAML). \throws vol::Error naming file and line: unknown or repeated key, wrong form, value
/// out of range, file over 1 MB, what TransferFunction refuses
[[nodiscard]] SceneFile read_scene(const std::filesystem::path& path);

// clang-format off
/// Reads a transfer function:
///     space: srgb                            # of the colours; default linear
///     range: [0, 255]                        # values below are scaled from [0, 1] to this [as they are]
///     colours: [[0, 0, 0, 0], [255, 1, 1, 1]]      # value, red, green, blue
///     opacity: [[0, 0], [255, 0.3]]                # value, opacity for one reference length
// clang-format on
/// or, by extension .json, a ParaView preset (the first of its list): RGBPoints, sRGB, become linear points
/// and are joined in linear light whatever its ColorSpace; Points with midpoint and sharpness become VTK's
/// curve, sampled where it is not piecewise linear; a preset without Points gets opacity 0 to 1 over its
/// range.
[[nodiscard]] transfer::TransferFunction read_transfer_function(const std::filesystem::path& path);

// clang-format off
/// The Bezier curves of a transfer function:
///     range: [0, 4095]                       # values that are v = 0 and v = 1; default 0 and 1
///     bezier: [0, 0, 1.5, 0.2]               # control points of the weight B(v), or a list of curves:
///     bezier:
///       - {name: bone, colour: [1, 0.9, 0.8], points: [0, 0, 1, 1]}      # name and colour may be left out
///       - {points: [[0, 0], [0.2, 1], [1, 0]]}       # a curve of points in both coordinates
// clang-format on
/// read_transfer_function() takes such a file too, as transfer::as_transfer_function() makes one of it.
/// \returns nothing for a transfer function of another form
[[nodiscard]] std::optional<transfer::BezierTransfer> read_bezier(const std::filesystem::path& path);
/// Writes that form. `attributes` go before it as comments; none of them may hold a line end.
void write_bezier(const std::filesystem::path& path, const transfer::BezierTransfer& bezier,
                  const std::map<std::string, std::string>& attributes);
[[nodiscard]] nlohmann::json to_json(const transfer::BezierTransfer& bezier);

/// Points of a profile from a text of "value, weight" lines (.csv); blank lines, lines that begin with # and
/// one line of headings are passed over. \throws vol::Error naming file and line, NaN and infinity included
[[nodiscard]] transfer::Profile read_profile(const std::filesystem::path& path);

/// A scene as it was resolved, for provenance.
[[nodiscard]] nlohmann::json to_json(const render::Scene& scene);

}  // namespace vol::io
