#pragma once
#include <functional>

#include "curvilinear/cell_order.h"
#include "curvilinear/screen.h"

// Private to lib/curvilinear: the order of cells that have no face in common.
namespace vol::curvilinear {

using SolidOf = std::function<Solid(const VisibleCell&)>;  ///< in view coordinates

/// A ray through a pixel's centre leaves the grid (or its block) by a face of one cell and next enters by a
/// face of another. Places in the list of cells, and where, in parameters of their blocks, counted in cells.
struct GapCrossing {
  std::uint32_t front, back;
  Vec3 left_at, entered_at;
};

/// All of a picture, after Cook, Max, Silva and Williams 2004: the faces that no other cell lies beside are
/// scan-converted, to a tenth of a pixel, and each pixel's passages sorted. So cells of different blocks, and
/// of arms of one, come in the order of the rays. Sorted by front, then back. Faces that touch, as blocks'
/// do, are told from overlapping ones to a tenth of a pixel of depth.
[[nodiscard]] std::vector<GapCrossing> gap_crossings(const std::vector<VisibleCell>& cells,
                                                     const std::vector<Dims>& block_cells,
                                                     const SolidOf& solid_of, const Screen& screen, int width,
                                                     int height);

}  // namespace vol::curvilinear
