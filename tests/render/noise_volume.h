#pragma once
#include "base/rng.h"
#include "volume/volume.h"

namespace vol::render {

/// Noise evenly spread between two values, on a grid with nothing symmetric about it; not turned, the views
/// along the world's axes are along its own.
inline volume::Volume noise(const Dims& dims, std::uint64_t seed, double least, double most,
                            bool turned = true) {
  volume::GridGeometry geometry;
  geometry.dims = dims;
  geometry.spacing = {0.7, 1.3, 0.9};
  geometry.origin = {-12.5, 3, 101};
  if (turned) geometry.direction = Eigen::AngleAxisd(0.4, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  Rng rng(seed);
  volume::Grid<double> grid{geometry, Buffer<double>(static_cast<std::size_t>(geometry.count()))};
  for (double& v : grid.voxels) v = rng.uniform(least, most);
  volume::Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

}  // namespace vol::render
