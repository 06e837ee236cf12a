#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "io/byte_source.h"
#include "io/volume.h"

// Private to lib/io: from a stream of bytes to voxels in memory, and back.
namespace vol::io {

struct VoxelLayout {
  volume::VoxelType type = volume::VoxelType::u8;
  volume::GridGeometry geometry;
  bool big_endian = false;
};

/// Bytes that the voxels take in the file. Throws, naming the file, for unusable geometry, on overflow, and
/// when it is more than the memory limit: call it before anything is sized by the header.
[[nodiscard]] std::int64_t checked_bytes(const std::string& name, const VoxelLayout& layout,
                                         const ReadOptions& options);

/// Reads binary voxels. Where the source knows its size, that is checked first; where it does not (a pipe, a
/// compressed stream) memory grows with what comes.
[[nodiscard]] volume::Volume read_binary(ByteSource& source, const VoxelLayout& layout,
                                         const ReadOptions& options);
/// The same from text, numbers between white space; each must be one that the voxel type holds.
[[nodiscard]] volume::Volume read_ascii(Scanner& scanner, const VoxelLayout& layout,
                                        const ReadOptions& options);

/// Calls f(data, bytes) once with all voxels as little-endian bytes.
template <class F>
void with_voxel_bytes(const volume::Volume& volume, F&& f) {
  volume::visit(volume, [&](const auto& grid) {
    f(static_cast<const void*>(grid.voxels.data()),
      grid.voxels.size() * sizeof(typename std::decay_t<decltype(grid)>::value_type));
  });
}

/// Deflates `n` bytes at zlib's default level and calls sink(data, n) with what comes; `gzip`: with a gzip
/// header (without name and time, so that the same data give the same bytes), else zlib's.
void deflate_to(const void* data, std::size_t n, bool gzip,
                const std::function<void(const void*, std::size_t)>& sink);

/// Attribute that marks f16 voxels stored as f32 in formats that have no f16.
inline constexpr const char* kVoxelTypeAttribute = "precis.voxel_type";
/// The volume as the formats without f16 hold it: f16 widened to f32 (which is exact) and marked.
[[nodiscard]] volume::Volume widened(const volume::Volume& volume);
/// The inverse of widened(), for a volume just read; one whose values are no longer f16 stays f32.
void narrow_if_marked(volume::Volume& volume);

}  // namespace vol::io
