#pragma once
#include <cmath>
#include <cstdint>
#include <string>

#include "isosurface/marching_cubes.h"
#include "mesh/measures.h"

// Volumes from functions, geometry in general position, and counts as text.
namespace vol::isosurface {

using volume::Grid;
using volume::Volume;

template <class T>
Volume make_volume(const Dims& dims, const auto& value) {
  Grid<T> grid;
  grid.geometry.dims = dims;
  grid.voxels = Buffer<T>(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) grid(i, j, k) = static_cast<T>(value(i, j, k));
    }
  }
  Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

inline Vec3 vec(std::int64_t x, std::int64_t y, std::int64_t z) {
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

/// Geometry in general position; `sign` of the determinant.
inline volume::GridGeometry oblique(const Dims& dims, const Vec3& spacing, double sign) {
  volume::GridGeometry g;
  g.dims = dims;
  g.spacing = spacing;
  g.direction =
      (Eigen::AngleAxisd(0.4, Vec3::UnitX()) * Eigen::AngleAxisd(-0.9, Vec3::UnitZ())).toRotationMatrix();
  g.direction.col(1) *= sign;
  g.origin =
      Vec3(30, -4, 7) - g.direction * g.spacing.cwiseProduct(vec(dims[0] - 1, dims[1] - 1, dims[2] - 1)) / 2;
  return g;
}

inline Volume sampled(const volume::GridGeometry& g, const auto& field) {
  Volume volume = make_volume<double>(g.dims, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return field(g.index_to_world(vec(i, j, k)));
  });
  volume.geometry() = g;
  return volume;
}

inline std::string describe(const mesh::Topology& t) {
  return std::to_string(t.components) + " components, chi " + std::to_string(t.euler) + ", boundary " +
         std::to_string(t.boundary_edges) + ", non-manifold " + std::to_string(t.non_manifold_edges) +
         " edges " + std::to_string(t.non_manifold_vertices) + " vertices, misoriented " +
         std::to_string(t.misoriented_edges);
}

}  // namespace vol::isosurface
