#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"

namespace vol::curvilinear {

/// One scalar at every point of a block.
struct PointArray {
  std::string name;
  std::vector<double> values;  ///< x fastest, as the points
};

/// A structured block: points[i + ni (j + nj k)] is the world position of grid point (i, j, k). A cell is the
/// solid between the eight points (i..i+1, j..j+1, k..k+1).
struct Block {
  Dims dims{0, 0, 0};
  std::vector<Vec3> points;
  std::vector<PointArray> arrays;
  std::vector<std::uint8_t> hidden;  ///< IBLANK: 1 where a point holds no flow; empty: none does

  [[nodiscard]] std::size_t offset(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>(i + dims[0] * (j + dims[1] * k));
  }
  [[nodiscard]] Dims cells() const { return {dims[0] - 1, dims[1] - 1, dims[2] - 1}; }
  [[nodiscard]] std::int64_t cell_count() const { return (dims[0] - 1) * (dims[1] - 1) * (dims[2] - 1); }
  /// A cell with a hidden corner is missing.
  [[nodiscard]] bool is_missing(const Dims& cell) const;
  [[nodiscard]] const PointArray* find(std::string_view name) const;
};

/// Curvilinear grid of one or more blocks, which may touch.
struct Grid {
  std::vector<Block> blocks;
  std::map<std::string, std::string> attributes;

  [[nodiscard]] std::int64_t point_count() const;
  [[nodiscard]] std::int64_t cell_count() const;
  /// Of the points.
  [[nodiscard]] Box3 bounds() const;
};

/// The cells [lower, upper) of a block with their points. \throws vol::Error where it has no such cells
[[nodiscard]] Block cropped(const Block& block, const Dims& lower, const Dims& upper);

/// Throws vol::Error unless every block has 2 or more points along each axis (a grid of one layer of points
/// is 2-D and encloses nothing), as many points and values as its dims say, and all of them finite.
void require_valid(const Grid& grid);

}  // namespace vol::curvilinear
