#include "curvilinear/phantom.h"

#include <cmath>
#include <numbers>

#include "base/checked.h"
#include "base/error.h"

namespace vol::curvilinear {
namespace {

/// sin and cos of pi x, exact at multiples of a half: seams close and collapsed edges are points to the bit.
double sin_pi(double x) {
  const double r = std::remainder(x, 2.0);  // in [-1, 1]
  if (r == 0 || std::abs(r) == 1) return 0;
  return std::sin(std::numbers::pi * (r > 0.5 ? 1 - r : r < -0.5 ? -1 - r : r));
}
double cos_pi(double x) {
  return sin_pi(0.5 - std::abs(std::remainder(x, 2.0)));
}

Vec3 half_torus(const Vec3& u) {
  const double radius = 2.5 - u[1];  // inward, so that the axes are right-handed
  return {radius * cos_pi(u[0]), radius * sin_pi(u[0]), u[2] - 0.5};
}

Vec3 spherical_shell(const Vec3& u) {
  return (1 + u[0]) * Vec3(sin_pi(u[1]) * cos_pi(2 * u[2]), sin_pi(u[1]) * sin_pi(2 * u[2]), cos_pi(u[1]));
}

Vec3 twisted_box(const Vec3& u) {
  const double c = cos_pi(0.5 * u[2]), s = sin_pi(0.5 * u[2]);
  const double x = 2 * u[0] - 1, y = 2 * u[1] - 1;
  return {c * x - s * y, s * x + c * y, 2 * u[2] - 1};
}

Vec3 sheared_box(const Vec3& u) {
  return Vec3(-0.7, 0.2, 1.1) + u[0] * Vec3(1.9, 0.3, -0.2) + u[1] * Vec3(0.8, 1.4, 0.1) +
         u[2] * Vec3(-0.5, 0.6, 1.7);
}

Vec3 c_grid(const Vec3& u) {
  const double angle = 0.25 + 1.5 * u[0], inner = 0.5 * (1 - u[2]);
  const double radius = 1.5 + (inner - 1.5) * u[1];  // inward: right-handed
  return {radius * cos_pi(angle), radius * sin_pi(angle), u[2]};
}

Vec3 delta_wing(const Vec3& u) {
  const double angle = 2 * u[2] - 1, outward = (u[1] * u[1] * (0.5 + 0.5 * u[1]) + 1e-2 * u[1]) / 1.01;
  const double outer = 1.5 + u[0];
  const double y = (u[0] + (outer - u[0]) * outward) * cos_pi(angle);
  const double z = (0.05 * u[0] + (outer - 0.05 * u[0]) * outward) * sin_pi(angle);
  return {2 * u[0], y, z};
}

struct Phantom {
  PhantomName name;
  Vec3 (*position)(const Vec3&);
};

const std::vector<Phantom>& phantoms() {
  static const std::vector<Phantom> kPhantoms = {
      {{"half-torus", "curvilinear grid: half a ring of square section, 3 cells", {4, 2, 2}}, half_torus},
      {{"spherical-shell", "curvilinear grid: radii 1 to 2, collapsed at the poles", {9, 17, 33}},
       spherical_shell},
      {{"twisted-box", "curvilinear grid: a box turned by 90 degrees from end to end", {9, 9, 17}},
       twisted_box},
      {{"sheared-box", "curvilinear grid: a parallelepiped in general position", {9, 9, 9}}, sheared_box},
      {{"c-grid", "curvilinear grid: three quarters of a turn, an edge collapsed", {33, 9, 17}}, c_grid},
      {{"delta-wing", "curvilinear grid: elliptic sections round a thin delta", {40, 80, 40}}, delta_wing},
  };
  return kPhantoms;
}

const Phantom& find(std::string_view name) {
  for (const auto& phantom : phantoms()) {
    if (phantom.name.name == name) return phantom;
  }
  throw Error("no grid phantom '" + std::string(name) + "'");
}

}  // namespace

const std::vector<PhantomName>& phantom_names() {
  static const std::vector<PhantomName> kNames = [] {
    std::vector<PhantomName> names;
    for (const auto& phantom : phantoms()) names.push_back(phantom.name);
    return names;
  }();
  return kNames;
}

Vec3 phantom_position(std::string_view name, const Vec3& uvw) {
  return find(name).position(uvw);
}

volume::AnalyticField phantom_field(const Box3& bounds, std::string_view field_name, std::uint64_t seed) {
  volume::AnalyticOptions options;
  options.seed = seed;
  options.geometry.dims = {2, 2, 2};
  options.geometry.origin = bounds.min;
  options.geometry.spacing = bounds.size();
  return volume::make_analytic_field(field_name, options);
}

Grid make_phantom(std::string_view name, const Dims& wanted, std::string_view field_name,
                  std::uint64_t seed) {
  const Phantom& phantom = find(name);
  Block block;
  block.dims = wanted[0] == 0 ? phantom.name.dims : wanted;
  const auto count = static_cast<std::size_t>(checked_count(block.dims));
  for (const auto n : block.dims) {
    if (n < 2) throw Error("--dims: a grid needs 2 or more points along each axis");
  }
  block.points.reserve(count);
  for (std::int64_t k = 0; k < block.dims[2]; ++k) {
    for (std::int64_t j = 0; j < block.dims[1]; ++j) {
      for (std::int64_t i = 0; i < block.dims[0]; ++i) {
        block.points.push_back(
            phantom.position({static_cast<double>(i) / static_cast<double>(block.dims[0] - 1),
                              static_cast<double>(j) / static_cast<double>(block.dims[1] - 1),
                              static_cast<double>(k) / static_cast<double>(block.dims[2] - 1)}));
      }
    }
  }
  Grid grid;
  grid.blocks.push_back(std::move(block));
  Block& filled = grid.blocks[0];
  const Box3 bounds = grid.bounds();
  if (!(bounds.size().minCoeff() > 0)) {
    throw Error(std::string(name) + " with " + std::to_string(filled.dims[0]) + " x " +
                std::to_string(filled.dims[1]) + " x " + std::to_string(filled.dims[2]) +
                " points is flat; take more");
  }
  const auto field = phantom_field(bounds, field_name, seed);
  PointArray array{std::string(field_name), std::vector<double>(count)};
  for (std::size_t n = 0; n < count; ++n) array.values[n] = field.value(filled.points[n]);
  filled.arrays.push_back(std::move(array));
  grid.attributes["precis.grid"] = std::string(name);
  return grid;
}

}  // namespace vol::curvilinear
