#pragma once
#include <string_view>
#include <vector>

#include "curvilinear/grid.h"
#include "volume/analytic_field.h"

namespace vol::curvilinear {

struct PhantomName {
  std::string_view name;
  std::string_view description;  ///< one line
  Dims dims;                     ///< points by default
};
[[nodiscard]] const std::vector<PhantomName>& phantom_names();

/// World position at (u, v, w) in [0,1]^3 of the solid of that name, in closed form:
/// - half-torus: a ring of square section, half a turn; radius 2 + c in the plane, c and z in [-1/2, 1/2]
/// - spherical-shell: radii 1 to 2; the poles are collapsed edges, the seam closes on itself
/// - twisted-box: [-1, 1]^3, turned about z by 90 degrees from end to end
/// - sheared-box: a parallelepiped in general position, an affine map
/// - c-grid: three quarters of a turn about z, inner radius (1 - w) / 2: at w = 1 an edge is collapsed
/// - delta-wing: elliptic sections around a thin delta of half span u, out to a circle of radius 1.5 + u; u
///   runs from the apex, where the wing is a point, and v from the wing outward
/// All right-handed. \throws vol::Error on another name
[[nodiscard]] Vec3 phantom_position(std::string_view name, const Vec3& uvw);

/// The solid cut evenly in u, v, w, with the field at its points as the array of `field_name`.
/// \param dims points along u, v, w, 2 or more each; 0,0,0: the phantom's own
/// \throws vol::Error on fewer, and where so few make a flat grid
/// \param field_name of volume::analytic_field_names(), mapped to the bounds of the solid's own grid
[[nodiscard]] Grid make_phantom(std::string_view name, const Dims& dims, std::string_view field_name,
                                std::uint64_t seed);

/// The field that make_phantom() samples.
[[nodiscard]] volume::AnalyticField phantom_field(const Box3& bounds, std::string_view field_name,
                                                  std::uint64_t seed);

}  // namespace vol::curvilinear
