#pragma once
#include "features/codebook.h"
#include "volume/analytic_field.h"
#include "volume/analytic_texture.h"
#include "wavelet/dwt.h"
#include "wavelet/significance.h"

namespace vol::features {

inline volume::Volume texture(const Dims& dims, std::uint64_t seed = 1) {
  const auto field =
      volume::make_analytic_field("texture", {.seed = seed, .geometry = volume::canonical_geometry(dims)});
  return volume::sampled_volume(field, volume::VoxelType::f32, {0, 1});
}

inline wavelet::Decomposition<float> transformed(const volume::Volume& volume, const std::string& wavelet,
                                                 int levels = 3) {
  return wavelet::analyze<float>(volume, {.wavelet = wavelet, .levels = levels}, volume::value_range(volume));
}

inline const Buffer<std::uint8_t>& voxels_of(const volume::Volume& labels) {
  return std::get<volume::Grid<std::uint8_t>>(labels.grid).voxels;
}

}  // namespace vol::features
