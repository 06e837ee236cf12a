#include "curvilinear/grid.h"

#include <cmath>

#include "base/checked.h"
#include "base/error.h"

namespace vol::curvilinear {
namespace {

std::string block_name(const Grid& grid, std::size_t b) {
  return grid.blocks.size() == 1 ? std::string() : "block " + std::to_string(b) + ": ";
}

std::string size_text(const Dims& d) {
  return std::to_string(d[0]) + " x " + std::to_string(d[1]) + " x " + std::to_string(d[2]);
}

}  // namespace

bool Block::is_missing(const Dims& c) const {
  if (hidden.empty()) return false;
  for (int n = 0; n < 8; ++n) {
    if (hidden[offset(c[0] + (n & 1), c[1] + (n >> 1 & 1), c[2] + (n >> 2))] != 0) return true;
  }
  return false;
}

const PointArray* Block::find(std::string_view name) const {
  for (const auto& array : arrays) {
    if (array.name == name) return &array;
  }
  return nullptr;
}

std::int64_t Grid::point_count() const {
  std::int64_t n = 0;
  for (const auto& block : blocks) n += static_cast<std::int64_t>(block.points.size());
  return n;
}

std::int64_t Grid::cell_count() const {
  std::int64_t n = 0;
  for (const auto& block : blocks) n += block.cell_count();
  return n;
}

Box3 Grid::bounds() const {
  Box3 box{blocks.at(0).points.at(0), blocks.at(0).points.at(0)};
  for (const auto& block : blocks) {
    for (const Vec3& p : block.points) {
      box.min = box.min.cwiseMin(p);
      box.max = box.max.cwiseMax(p);
    }
  }
  return box;
}

Block cropped(const Block& block, const Dims& lower, const Dims& upper) {
  Block part;
  for (std::size_t a = 0; a < 3; ++a) {
    if (lower[a] < 0 || upper[a] > block.cells()[a] || lower[a] >= upper[a]) {
      throw Error("cells " + std::to_string(lower[a]) + " to " + std::to_string(upper[a]) +
                  " are asked for along axis " + std::to_string(a) + ", of " +
                  std::to_string(block.cells()[a]));
    }
    part.dims[a] = upper[a] - lower[a] + 1;
  }
  for (const auto& array : block.arrays) part.arrays.push_back({array.name, {}});
  for (std::int64_t k = lower[2]; k <= upper[2]; ++k) {
    for (std::int64_t j = lower[1]; j <= upper[1]; ++j) {
      for (std::int64_t i = lower[0]; i <= upper[0]; ++i) {
        const std::size_t n = block.offset(i, j, k);
        part.points.push_back(block.points[n]);
        if (!block.hidden.empty()) part.hidden.push_back(block.hidden[n]);
        for (std::size_t f = 0; f < part.arrays.size(); ++f)
          part.arrays[f].values.push_back(block.arrays[f].values[n]);
      }
    }
  }
  return part;
}

void require_valid(const Grid& grid) {
  if (grid.blocks.empty()) throw Error("grid without a block");
  for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
    const Block& block = grid.blocks[b];
    const std::string where = block_name(grid, b);
    const auto count = static_cast<std::size_t>(checked_count(block.dims));
    for (const auto n : block.dims) {
      if (n < 2) {
        throw Error(where + size_text(block.dims) +
                    " points are a 2-D grid, which encloses no volume; expected 2 or more along each axis");
      }
    }
    if (block.points.size() != count || (!block.hidden.empty() && block.hidden.size() != count)) {
      throw Error(where + "has " + std::to_string(block.points.size()) + " points, its size is " +
                  size_text(block.dims));
    }
    for (std::size_t n = 0; n < count; ++n) {
      if (!block.points[n].allFinite()) {
        throw Error(where + "position of point " + std::to_string(n) + " is not finite");
      }
    }
    for (const auto& array : block.arrays) {
      if (array.values.size() != count) {
        throw Error(where + "array '" + array.name + "' has " + std::to_string(array.values.size()) +
                    " values for " + std::to_string(count) + " points");
      }
      for (std::size_t n = 0; n < count; ++n) {
        if (!std::isfinite(array.values[n])) {
          throw Error(where + "array '" + array.name + "' is not finite at point " + std::to_string(n));
        }
      }
    }
  }
}

}  // namespace vol::curvilinear
