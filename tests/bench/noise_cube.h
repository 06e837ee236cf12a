#pragma once
#include <map>

#include "base/rng.h"
#include "volume/volume.h"

namespace vol {

/// n^3 random floats, made once.
inline const volume::Volume& noise_cube(std::int64_t n) {
  static std::map<std::int64_t, volume::Volume> cubes;
  auto& volume = cubes[n];
  if (volume.geometry().count() != n * n * n) {
    volume::GridGeometry geometry;
    geometry.dims = {n, n, n};
    volume = volume::allocate(volume::VoxelType::f32, geometry);
    Rng rng(1);
    for (float& v : std::get<volume::Grid<float>>(volume.grid).voxels) v = static_cast<float>(rng.uniform());
  }
  return volume;
}

}  // namespace vol
