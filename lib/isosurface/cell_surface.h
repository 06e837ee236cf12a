#pragma once
#include <array>
#include <cstdint>

#include "base/vec.h"
#include "isosurface/cell_case.h"

namespace vol::isosurface {

/// Where a value crosses the isovalue between two samples of which one is inside, as a share of the way from
/// the first to the second, in [0, 1]. An infinite value (what lies beyond a closed border) is infinitely
/// far: the crossing is at the other sample.
[[nodiscard]] double crossing(double first, double second, double isovalue);

/// Triangles and inner points of a cell. Triangle corners: 0 to 11 the point on that edge, 12 + i inner point
/// i.
struct CellSurface {
  int triangle_count = 0;
  int point_count = 0;
  std::array<std::array<std::uint8_t, 3>, 36> triangles{};
  std::array<Vec3, 12> points{};  ///< cell coordinates
};

/// Number of triangles and of inner points of a decided cell, without making them.
struct CellSize {
  int triangles = 0;
  int points = 0;
};
[[nodiscard]] CellSize surface_size(const CellCase& cell, const CellDecision& decision);

/// The surface in a decided cell.
///
/// Disks as the case has them; a fan's centre is a point of the isosurface near the mean of its loop. A tube
/// is two bands of triangles between its loops and a ring of six points on the isosurface: seen from the
/// saddle they lie toward the middle of the six edges that do not touch the diagonal, in the planes x =
/// const, y = const, z = const of the saddle, where the field is f(s) + f_xy (x - s_x)(y - s_y) and so on. In
/// a cell with infinite values (no tubes there) inner points are the mean of their loop.
void make_surface(const CellValues& values, const CellDecision& decision, CellSurface& surface);

}  // namespace vol::isosurface
