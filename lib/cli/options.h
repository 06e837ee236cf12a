#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"

// Parsers of the value forms that several tools share. Each throws vol::Error that names the option.
namespace vol::cli {

/// "64x64x64" (x, y, z order) or "64" for a cube; each at least 1.
[[nodiscard]] Dims parse_dims(const std::string& option, const std::string& text);
/// "512x512" or "512": width x height in pixels.
[[nodiscard]] std::array<int, 2> parse_image_size(const std::string& option, const std::string& text);
/// "a,b,c", or "a" for all three.
[[nodiscard]] Vec3 parse_vec3(const std::string& option, const std::string& text);
/// Finite numbers "A,B,..." in one text or several, in order; by hand, since CLI11 lets "1,,2" pass for two.
[[nodiscard]] std::vector<double> parse_numbers(const std::string& option,
                                                const std::vector<std::string>& texts);
/// Labels "A,B,...", whole numbers from 0 to 255, in order.
[[nodiscard]] std::vector<int> parse_labels(const std::string& option, const std::string& text);
/// "R,G,B", or one number for grey; each 0 to 1.
[[nodiscard]] Vec3 parse_colour(const std::string& option, const std::string& text);
/// "AZIMUTH,ELEVATION" in degrees.
[[nodiscard]] std::array<double, 2> parse_view(const std::string& option, const std::string& text);

/// Half-open box of voxel indices.
struct Region {
  std::array<std::int64_t, 3> lower;
  std::array<std::int64_t, 3> upper;
};
/// "x0,y0,z0:x1,y1,z1"; lower < upper on each axis.
[[nodiscard]] Region parse_region(const std::string& option, const std::string& text);

/// "0.5" (world length) or "0.5v" (multiples of the smallest spacing); positive.
[[nodiscard]] double parse_step(const std::string& option, const std::string& text, double smallest_spacing);

// Checks for CLI11 (Option::check): empty, or what was expected. Unlike CLI11's own they refuse NaN and say
// it short.
[[nodiscard]] std::string check_positive(const std::string& text);      ///< finite, > 0
[[nodiscard]] std::string check_non_negative(const std::string& text);  ///< >= 0, infinity too
[[nodiscard]] std::string check_finite(const std::string& text);
[[nodiscard]] std::string check_whole_number(const std::string& text);  ///< 0 to 2^63 - 1

}  // namespace vol::cli
