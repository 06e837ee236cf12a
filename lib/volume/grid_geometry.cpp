#include "volume/grid_geometry.h"

#include <cmath>
#include <string>

#include "base/checked.h"
#include "base/error.h"

namespace vol::volume {

std::string_view name(Space space) {
  switch (space) {
    case Space::lps: return "LPS";
    case Space::ras: return "RAS";
    case Space::none: break;
  }
  return "none";
}

void GridGeometry::validate() const {
  (void)checked_count(dims);
  for (int a = 0; a < 3; ++a) {
    if (!(spacing[a] > 0) || !std::isfinite(spacing[a])) {
      throw Error("spacing " + std::to_string(spacing[a]) + " along " + std::string(1, "xyz"[a]) +
                  " is not a positive length");
    }
    if (!std::isfinite(origin[a])) throw Error("origin is not finite");
    if (!(std::abs(direction.col(a).norm() - 1.0) < 1e-4)) throw Error("axis direction is not a unit vector");
  }
  if (!(std::abs(direction.determinant()) > 1e-6)) throw Error("axis directions do not span space");
}

Vec3 GridGeometry::index_to_world(const Vec3& p_index) const {
  return origin + direction * spacing.cwiseProduct(p_index);
}

Mat3 GridGeometry::world_to_index_matrix() const {
  return spacing.cwiseInverse().asDiagonal() * direction.inverse();
}

Vec3 GridGeometry::world_to_index(const Vec3& p_world) const {
  return world_to_index_matrix() * (p_world - origin);
}

Box3 GridGeometry::index_box() const {
  Box3 box;
  for (int a = 0; a < 3; ++a) {
    box.min[a] = dims[a] == 1 ? -0.5 : 0.0;
    box.max[a] = dims[a] == 1 ? 0.5 : static_cast<double>(dims[a] - 1);
  }
  return box;
}

Vec3 GridGeometry::centre() const { return index_to_world(index_box().centre()); }

Vec3 GridGeometry::edge_lengths() const { return index_box().size().cwiseProduct(spacing); }

}  // namespace vol::volume
