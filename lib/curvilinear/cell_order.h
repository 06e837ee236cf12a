#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "curvilinear/front_to_back.h"

namespace vol::curvilinear {

/// A cell, or a group of 2^level along each axis as one, that is to be drawn, with the rows of the picture
/// that its solid may meet.
struct VisibleCell {
  double depth;  ///< smallest of its corners
  std::uint32_t block;
  std::int64_t number;      ///< in its block, x fastest; of a group its first cell's
  int top = 0, bottom = 0;  ///< [top, bottom)
  /// At the middle of the face to the next cell along each axis: 1 where light meets this cell before that
  /// one, seen from the eye; -1 after; 0 where the ray lies in the face.
  std::array<std::int8_t, 3> before_next{0, 0, 0};
  std::array<std::int8_t, 3> before_previous{0, 0, 0};  ///< asked for where that one is a larger group
  std::uint8_t level = 0;
  bool is_large = false;  ///< reaches far beyond the picture: drawn in parts, those outside left out
};

/// depth: by the smallest depth, as Bethel 1993 has it, which fails where large cells meet small ones. faces:
/// a cell comes before those that lie behind its faces (Williams 1992), and by depth where that says nothing.
enum class CellOrder { depth, faces };

/// Which of the listed cells a cell of a grid is, or is in.
class CellPlaces {
 public:
  /// \param block_cells  of each block
  CellPlaces(const std::vector<VisibleCell>& cells, const std::vector<Dims>& block_cells);
  /// Its place in the list; -1: none, or beyond the block.
  [[nodiscard]] std::int32_t operator()(std::uint32_t block, const Dims& cell) const;

 private:
  std::vector<Dims> block_cells_;
  std::vector<std::vector<std::int32_t>> place_;
};

/// The first cell of a block's cell or group.
[[nodiscard]] Dims first_cell(const VisibleCell& cell, const std::vector<Dims>& block_cells);

/// By depth; by block and number where depths are equal, so that pictures are the same on every machine.
void sort_by_depth(std::vector<VisibleCell>& cells);

/// The relation between neighbours of a block, by the middle of the smaller one's face.
[[nodiscard]] std::vector<Before> before_by_faces(const std::vector<VisibleCell>& cells,
                                                  const std::vector<Dims>& block_cells);

}  // namespace vol::curvilinear
