#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace vol::curvilinear {

/// A cell that is to be drawn, with the rows of the picture that its solid may meet.
struct VisibleCell {
  double depth;  ///< smallest of its corners
  std::uint32_t block;
  std::int64_t number;      ///< in its block, x fastest
  int top = 0, bottom = 0;  ///< [top, bottom)
  /// At the middle of the face to the next cell along each axis: 1 where light meets this cell before that
  /// one, seen from the eye; -1 after; 0 where the ray lies in the face.
  std::array<std::int8_t, 3> before_next{0, 0, 0};
};

/// depth: by the smallest depth, as Bethel 1993 has it, which fails where large cells meet small ones. faces:
/// a cell comes before those that lie behind its faces (Williams 1992), and by depth where that says nothing;
/// where such cells go round in a circle, the nearest of those left is taken.
enum class CellOrder { depth, faces };

/// Puts cells, which come by block and number, front to back. \param block_cells  of each block \returns how
/// often a circle was cut
std::int64_t put_in_order(std::vector<VisibleCell>& cells, const std::vector<Dims>& block_cells,
                          CellOrder order);

}  // namespace vol::curvilinear
