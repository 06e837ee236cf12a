#pragma once
#include <map>
#include <string>
#include <variant>

#include "base/buffer.h"
#include "volume/grid_geometry.h"
#include "volume/voxel_type.h"

namespace vol::volume {

/// Samples on a regular grid: voxels[i + nx (j + ny k)] at geometry.index_to_world({i, j, k}).
template <class T>
struct Grid {
  using value_type = T;

  GridGeometry geometry;
  Buffer<T> voxels;

  [[nodiscard]] const Dims& dims() const { return geometry.dims; }
  [[nodiscard]] std::size_t offset(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>(i + geometry.dims[0] * (j + geometry.dims[1] * k));
  }
  [[nodiscard]] const T& operator()(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return voxels[offset(i, j, k)];
  }
  [[nodiscard]] T& operator()(std::int64_t i, std::int64_t j, std::int64_t k) { return voxels[offset(i, j, k)]; }
};

/// A volume as a file holds it: a grid of whatever voxel type, and its key/value attributes.
/// Algorithms are templates over Grid<T>; visit() is where the type is decided once.
struct Volume {
  std::variant<Grid<std::int8_t>, Grid<std::uint8_t>, Grid<std::int16_t>, Grid<std::uint16_t>, Grid<std::int32_t>,
               Grid<std::uint32_t>, Grid<half>, Grid<float>, Grid<double>>
      grid;
  std::map<std::string, std::string> attributes;

  [[nodiscard]] VoxelType voxel_type() const { return static_cast<VoxelType>(grid.index()); }
  [[nodiscard]] const GridGeometry& geometry() const;
  [[nodiscard]] GridGeometry& geometry();
};

/// Calls f(grid) with the grid as its own type.
template <class F>
decltype(auto) visit(const Volume& volume, F&& f) {
  return std::visit(std::forward<F>(f), volume.grid);
}
template <class F>
decltype(auto) visit(Volume& volume, F&& f) {
  return std::visit(std::forward<F>(f), volume.grid);
}

/// Volume of a type, its voxels NOT initialised; checks the geometry before it takes memory.
[[nodiscard]] Volume allocate(VoxelType type, const GridGeometry& geometry);

struct Range {
  double min = 0;
  double max = 0;
};

/// Smallest and largest voxel; throws vol::Error on NaN or infinity, with their number and the first position.
[[nodiscard]] Range value_range(const Volume& volume);

/// Refuses NaN and infinities, with their number and the first position, or replaces them by `missing`.
void require_finite(Volume& volume, const double* missing = nullptr);

/// Every voxel as another type: integers are rounded to nearest even and clamped to the type's range.
/// The same type is a plain copy.
template <class T>
[[nodiscard]] Grid<T> converted(const Volume& volume);

}  // namespace vol::volume
