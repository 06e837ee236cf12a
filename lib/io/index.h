#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "index/index_volume.h"
#include "io/volume.h"
#include "volume/volume.h"

namespace vol::io {

/// An index volume with what its file says of how it was made.
struct IndexFile {
  index::IndexVolume index;
  std::map<std::string, std::string> attributes;
};

/// Writes an index volume as NRRD u8 of ceil(nx/2) x ny x nz bytes, two entries a byte along x, low nibble
/// first. Keys: precis.kind = index, precis.index.dims (of the volume), precis.index.reduction,
/// precis.index.standard_distance; and the attributes (wavelet, epsilon, rule ...).
/// \param geometry of the volume that was indexed, so that the file lies where its volume does
void write_index(const std::filesystem::path& path, const index::IndexVolume& index,
                 const volume::GridGeometry& geometry, const std::map<std::string, std::string>& attributes);

/// Inverse of write_index(). \throws vol::Error for a file that is no index volume, or one whose size is not
/// what its keys say
[[nodiscard]] IndexFile read_index(const std::filesystem::path& path);

/// One u8 voxel an entry, for looking at. \throws vol::Error as read_index()
[[nodiscard]] volume::Volume unpack_index(const volume::Volume& packed);

}  // namespace vol::io
