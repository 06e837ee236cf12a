#include "render/voxel_blocks.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/heap.h"
#include "base/parallel.h"
#include "render/packet_set_up.h"

namespace vol::render {
namespace {

constexpr std::int64_t kEdge = std::int64_t{1} << BlockStrides::kEdgeLog2;
constexpr std::int64_t kRowBytes = std::int64_t{1} << BlockStrides::kRowBytesLog2;

/// Blocks along the axes, and bytes of them all, for voxels of so many bytes.
struct Extent {
  std::int64_t blocks[3], row_bytes, block_bytes, bytes;
};

Extent extent_of(const Dims& dims, std::int64_t voxel_bytes) {
  const std::int64_t edge[3] = {kRowBytes / voxel_bytes, kEdge, kEdge};
  Extent e{};
  for (int a = 0; a < 3; ++a) e.blocks[a] = (dims[a] + edge[a] - 1) / edge[a];
  e.row_bytes = kRowBytes + voxel_bytes;
  e.block_bytes = kEdge * kEdge * e.row_bytes;
  e.bytes = e.blocks[0] * e.blocks[1] * e.blocks[2] * e.block_bytes;
  return e;
}

/// Bytes of what offsets count.
std::int64_t unit_of(std::int64_t voxel_bytes) {
  return voxel_bytes == 4 ? 4 : 1;
}

}  // namespace

bool fits_blocks(const volume::Volume& volume) {
  const Dims& dims = volume.geometry().dims;
  if (!are_read_as_they_are(volume.voxel_type()) || *std::min_element(dims.begin(), dims.end()) < 2)
    return false;
  const auto size = static_cast<std::int64_t>(volume::size_in_bytes(volume.voxel_type()));
  const std::int64_t bytes = extent_of(dims, size).bytes, own = volume.geometry().count() * size;
  constexpr std::int64_t kAllowed = std::int64_t{1} << 20;
  return bytes <= own + own / 4 + kAllowed &&
         bytes / unit_of(size) < std::numeric_limits<std::int32_t>::max();
}

VoxelBlocks::VoxelBlocks(volume::Volume& volume) {
  if (!fits_blocks(volume)) throw Error("the volume's voxels cannot be laid out in blocks for packets");
  volume::visit(volume, [&]<class T>(volume::Grid<T>& grid) { take(grid); });
}

template <class T>
void VoxelBlocks::take(volume::Grid<T>& grid) {
  const Dims& dims = grid.dims();
  const Extent e = extent_of(dims, sizeof(T));
  constexpr std::int64_t kWidth = kRowBytes / std::int64_t{sizeof(T)};
  const std::int64_t unit = unit_of(sizeof(T));
  const auto in_units = [&](std::int64_t bytes) { return static_cast<std::int32_t>(bytes / unit); };
  const std::int64_t row_of_blocks = e.blocks[0] * e.block_bytes, slab = e.blocks[1] * row_of_blocks;
  strides_.pitch = in_units(e.row_bytes);
  strides_.beyond[0] = in_units(e.block_bytes - kRowBytes);
  strides_.beyond[1] = in_units(row_of_blocks - kEdge * e.row_bytes);
  strides_.beyond[2] = in_units(slab - e.block_bytes);

  bytes_ = Buffer<std::byte>(static_cast<std::size_t>(e.bytes));
  prefer_large_pages(bytes_.data(), bytes_.size());
  parallel_for(0, e.blocks[2], 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t b = first; b < last; ++b) {
      const std::int64_t begin = b * kEdge, end = std::min(dims[2], begin + kEdge);
      for (std::int64_t k = begin; k < end; ++k) {
        for (std::int64_t j = 0; j < dims[1]; ++j) {
          const T* const from = grid.voxels.data() + grid.offset(0, j, k);
          std::byte* to = bytes_.data() + b * slab + (j / kEdge) * row_of_blocks +
                          ((k - begin) * kEdge + j % kEdge) * e.row_bytes;
          for (std::int64_t i = 0; i < dims[0]; i += kWidth, to += e.block_bytes) {
            const auto bytes = static_cast<std::size_t>(std::min(kWidth + 1, dims[0] - i)) * sizeof(T);
            std::memcpy(to, from + i, bytes);
            // A gather of whole words reads on behind the last voxel.
            std::memset(to + bytes, 0, static_cast<std::size_t>(e.row_bytes) - bytes);
          }
        }
      }
      give_back_pages(grid.voxels.data() + grid.offset(0, 0, begin),
                      static_cast<std::size_t>((end - begin) * dims[0] * dims[1]) * sizeof(T));
    }
  });
  grid.voxels = {};
}

}  // namespace vol::render
