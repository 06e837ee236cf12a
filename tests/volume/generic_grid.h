#pragma once
#include <functional>

#include "volume/volume.h"

namespace vol::volume {

/// Nothing symmetric: different and odd dims, anisotropic spacing, off-centre origin, rotated axes.
inline GridGeometry generic_geometry(const Dims& dims = {9, 12, 7}) {
  GridGeometry g;
  g.dims = dims;
  g.spacing = {0.5, 2, 1.25};
  g.origin = {-7, 3, 11};
  g.direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  return g;
}

/// Samples of a function of the index coordinates.
inline Grid<double> sampled(const GridGeometry& geometry, const std::function<double(const Vec3&)>& f_index) {
  Grid<double> grid{geometry, Buffer<double>(static_cast<std::size_t>(geometry.count()))};
  for (std::int64_t k = 0; k < geometry.dims[2]; ++k) {
    for (std::int64_t j = 0; j < geometry.dims[1]; ++j) {
      for (std::int64_t i = 0; i < geometry.dims[0]; ++i) {
        grid(i, j, k) = f_index(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
      }
    }
  }
  return grid;
}

}  // namespace vol::volume
