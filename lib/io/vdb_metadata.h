#pragma once
#include <map>
#include <string>

#include "volume/volume.h"
#include "wavelet/decomposition.h"

// What a VDB file of ours says beside its grids, as text under keys "precis.*". Numbers are written with as
// many digits as bring the same double back.
namespace vol::io {

using Metadata = std::map<std::string, std::string>;

inline constexpr const char* kContentKey = "precis.content";  ///< "volume" or "coefficients"

/// Geometry, voxel type and range under their keys.
void put_volume(Metadata& metadata, const volume::GridGeometry& geometry, volume::VoxelType type,
                volume::Range range);
[[nodiscard]] volume::GridGeometry geometry_from(const Metadata& metadata);
[[nodiscard]] volume::VoxelType voxel_type_from(const Metadata& metadata);

/// Everything of a decomposition but its coefficients; subbands by their level, orientation, lower and dims.
template <class T>
void put_decomposition(Metadata& metadata, const wavelet::Decomposition<T>& decomposition);
/// The decomposition with its subbands' extents, coefficients not allocated; throws vol::Error on what cannot
/// be.
template <class T>
[[nodiscard]] wavelet::Decomposition<T> decomposition_from(const Metadata& metadata);

/// "level1.LLH".
[[nodiscard]] std::string subband_name(int level, int orientation);

/// True for the keys that the functions above write; the others are attributes.
[[nodiscard]] bool is_own_key(const std::string& key);

}  // namespace vol::io
