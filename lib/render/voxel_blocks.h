#pragma once
#include <cstddef>
#include <cstdint>

#include "base/buffer.h"
#include "volume/volume.h"

namespace vol::render {

/// Where blocks have a voxel: at
///
///   i size + (j + 8 k) pitch + (i / width) beyond[0] + (j / 8) beyond[1] + (k / 8) beyond[2],
///
/// size being a voxel and width the voxels of 64 bytes, in bytes for voxels of one and two bytes, in voxels
/// for f32.
struct BlockStrides {
  static constexpr int kEdgeLog2 = 3;      ///< rows of a block along y and along z: 8
  static constexpr int kRowBytesLog2 = 6;  ///< of a row, without the voxel that it repeats
  std::int32_t pitch = 0, beyond[3]{};
};

/// Whether packets can have a volume in blocks: two samples and more along every axis, of a type that they
/// read, with less than 2^31 - 1 bytes (f32: voxels) in blocks, and dims that leave few places in these empty:
/// at most a quarter of the volume and a MiB more.
[[nodiscard]] bool fits_blocks(const volume::Volume& volume);

/// A volume's voxels in blocks of 64 bytes x 8 x 8, about a page of memory each, so that rays close to each
/// other find their voxels close to each other along every axis. A row repeats the first voxel of the row
/// that follows it along x, so that neighbours along x are always next to each other: 65/64 of the volume for
/// bytes, 33/32 and 17/16 for two and four of them, where its dims are multiples of a block's.
class VoxelBlocks {
 public:
  /// Takes the voxels of `volume`, which is left with its geometry alone: their memory goes back to the
  /// system 8 slices at a time, so that both together take little more than one of them. \throws vol::Error where
  /// fits_blocks() is false
  explicit VoxelBlocks(volume::Volume& volume);

  [[nodiscard]] const void* data() const { return bytes_.data(); }
  [[nodiscard]] const BlockStrides& strides() const { return strides_; }

 private:
  template <class T>
  void take(volume::Grid<T>& grid);

  BlockStrides strides_;
  Buffer<std::byte> bytes_;
};

}  // namespace vol::render
