#include "index/build_index.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::index {
namespace {

/// Voxels before and after the cell's lower corner that the kernel reads at positions in the cell.
struct Footprint {
  std::int64_t before, after;
};

Footprint footprint(volume::Reconstruction reconstruction) {
  switch (reconstruction) {
    case volume::Reconstruction::catmull_rom:
    case volume::Reconstruction::b_spline: return {1, 2};
    case volume::Reconstruction::nearest:
    case volume::Reconstruction::trilinear: break;
  }
  return {0, 1};
}

/// Raises the entries whose block of cells has no forbidden cell to `level`.
void raise_entries(IndexVolume& index, const BitGrid& forbidden, int level) {
  const std::int64_t r = index.reduction();
  const Dims& entries = index.dims();
  const Dims& cells = index.volume_dims();
  parallel_for(0, entries[2], 4, [&](std::int64_t begin, std::int64_t end) {
    std::vector<std::uint64_t> row(static_cast<std::size_t>(forbidden.words_per_row()));
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int64_t j = 0; j < entries[1]; ++j) {
        std::fill(row.begin(), row.end(), 0);
        for (std::int64_t z = r * k; z < std::min(r * k + r, cells[2]); ++z) {
          for (std::int64_t y = r * j; y < std::min(r * j + r, cells[1]); ++y) {
            for (std::size_t w = 0; w < row.size(); ++w) row[w] |= forbidden.row(y, z)[w];
          }
        }
        std::uint8_t* nibbles = index.nibbles().data() + index.row_bytes() * (j + entries[1] * k);
        for (std::int64_t i = 0; i < entries[0]; ++i) {
          bool free = true;
          for (std::int64_t x = r * i; free && x < std::min(r * i + r, cells[0]); ++x) {
            free = (row[static_cast<std::size_t>(x >> 6)] >> (x & 63) & 1) == 0;
          }
          if (!free) continue;
          const int shift = static_cast<int>(i & 1) * 4;
          nibbles[i >> 1] = static_cast<std::uint8_t>((nibbles[i >> 1] & ~(15 << shift)) | (level << shift));
        }
      }
    }
  });
}

}  // namespace

IndexVolume build_index(const std::vector<BitGrid>& significant, const volume::GridGeometry& geometry,
                        const IndexOptions& options) {
  IndexVolume index(geometry.dims, options.reduction, options.standard_distance);
  const Footprint kernel = footprint(options.reconstruction);
  const Mat3 to_index = geometry.world_to_index_matrix();
  const int levels = std::min(static_cast<int>(significant.size()), IndexVolume::kMaxLevel);
  BitGrid up_to_level(geometry.dims);
  for (int level = 1; level <= levels; ++level) {
    const BitGrid& details = significant[static_cast<std::size_t>(level - 1)];
    if (details.dims() != geometry.dims) throw Error("index: the details are of a volume of other dimensions");
    up_to_level |= details;
    BitGrid forbidden = up_to_level;
    for (int axis = 0; axis < 3; ++axis) {
      // A world vector of length s moves at most s |row of the world-to-index matrix| along an index axis.
      const double step = options.look_ahead ? std::ldexp(options.standard_distance, level) : 0.0;
      const double reach = std::min(std::ceil(step * to_index.row(axis).norm()),
                                    static_cast<double>(geometry.dims[static_cast<std::size_t>(axis)]));
      forbidden.dilate(axis, static_cast<std::int64_t>(reach) + kernel.before, static_cast<std::int64_t>(reach) + kernel.after);
    }
    raise_entries(index, forbidden, level);
  }
  return index;
}

}  // namespace vol::index
