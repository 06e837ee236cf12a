#pragma once
#include "curvilinear/grid.h"

namespace vol::curvilinear {

/// What the cells of a block are like. The Jacobian is det dx/d(i,j,k), a volume per cell.
struct Quality {
  double jacobian_min = 0, jacobian_max = 0;  ///< at the centres of the trilinear cells
  double volume = 0;                          ///< sum of these: of the block, to second order
  std::int64_t inverted = 0;   ///< cells whose centre has a Jacobian of the other sign than the volume, or 0
  std::int64_t collapsed = 0;  ///< cells with an edge of length 0
  /// Tricubic solids (beta 1) whose Jacobian has the other sign than the volume at one of 4^3 even points.
  std::int64_t folded = 0;
  std::int64_t missing = 0;  ///< cells with a hidden corner
};
[[nodiscard]] Quality quality(const Block& block);

/// Edge of a cube as large as the grid's mean cell, by the Jacobians at the centres of the trilinear cells
/// that are not missing; 0 where there is none or all are flat.
[[nodiscard]] double mean_cell_edge(const Grid& grid);

}  // namespace vol::curvilinear
