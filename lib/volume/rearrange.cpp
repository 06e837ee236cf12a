#include "volume/rearrange.h"

#include <algorithm>
#include <string>

#include "base/checked.h"
#include "base/error.h"
#include "base/parallel.h"
#include "volume/arithmetic.h"

namespace vol::volume {
namespace {

constexpr std::int64_t kRows = 64;  // rows a task

/// result(i, j, k) = old[start + i stride[0] + j stride[1] + k stride[2]], for the dims of the geometry.
Volume gathered(const Volume& volume, const GridGeometry& geometry, std::int64_t start, const Dims& stride) {
  Volume result = allocate(volume.voxel_type(), geometry);
  result.attributes = volume.attributes;
  visit(volume, [&](const auto& grid) {
    auto& to = std::get<std::decay_t<decltype(grid)>>(result.grid);
    const auto [nx, ny, nz] = geometry.dims;
    parallel_for(0, ny * nz, kRows, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t row = first; row < last; ++row) {
        const auto* from = grid.voxels.data() + start + row % ny * stride[1] + row / ny * stride[2];
        auto* out = to.voxels.data() + row * nx;
        if (stride[0] == 1) {
          std::copy_n(from, nx, out);
        } else {
          for (std::int64_t i = 0; i < nx; ++i) out[i] = from[i * stride[0]];
        }
      }
    });
  });
  return result;
}

Dims strides(const Dims& dims) {
  return {1, dims[0], dims[0] * dims[1]};
}

Vec3 as_vector(const Dims& index) {
  return {static_cast<double>(index[0]), static_cast<double>(index[1]), static_cast<double>(index[2])};
}

}  // namespace

Volume cropped(const Volume& volume, const Dims& lower, const Dims& upper) {
  GridGeometry geometry = volume.geometry();
  const Dims dims = geometry.dims;
  for (int a = 0; a < 3; ++a) {
    if (lower[a] < 0 || upper[a] > dims[a] || lower[a] >= upper[a]) {
      throw Error("crop " + std::to_string(lower[a]) + ":" + std::to_string(upper[a]) + " along " +
                  std::string(1, "xyz"[a]) + " leaves the volume's 0:" + std::to_string(dims[a]));
    }
    geometry.dims[a] = upper[a] - lower[a];
  }
  geometry.origin = volume.geometry().index_to_world(as_vector(lower));
  const Dims stride = strides(dims);
  return gathered(volume, geometry, lower[0] + lower[1] * stride[1] + lower[2] * stride[2], stride);
}

Volume padded(const Volume& volume, std::int64_t margin, double value) {
  if (margin < 0) throw Error("padding " + std::to_string(margin) + " is negative");
  GridGeometry geometry = volume.geometry();
  for (auto& n : geometry.dims) {
    if (margin > (std::int64_t{1} << 40)) throw Error("padding " + std::to_string(margin) + " is too large");
    n += 2 * margin;
  }
  geometry.origin = volume.geometry().index_to_world(Vec3::Constant(-static_cast<double>(margin)));
  Volume result = allocate(volume.voxel_type(), geometry);
  result.attributes = volume.attributes;
  visit(volume, [&](const auto& grid) {
    using T = typename std::decay_t<decltype(grid)>::value_type;
    auto& to = std::get<Grid<T>>(result.grid);
    const T fill = stored_as<T>(value);
    const auto [nx, ny, nz] = grid.dims();
    parallel_for(0, to.dims()[1] * to.dims()[2], kRows, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t row = first; row < last; ++row) {
        const std::int64_t j = row % to.dims()[1] - margin;
        const std::int64_t k = row / to.dims()[1] - margin;
        T* out = to.voxels.data() + row * to.dims()[0];
        std::fill_n(out, to.dims()[0], fill);
        if (j >= 0 && j < ny && k >= 0 && k < nz) {
          std::copy_n(grid.voxels.data() + grid.offset(0, j, k), nx, out + margin);
        }
      }
    });
  });
  return result;
}

Volume flipped(const Volume& volume, int axis) {
  GridGeometry geometry = volume.geometry();
  const std::int64_t last = geometry.dims[axis] - 1;
  geometry.origin = geometry.index_to_world(static_cast<double>(last) * Vec3::Unit(axis));
  geometry.direction.col(axis) = -geometry.direction.col(axis);
  Dims stride = strides(geometry.dims);
  const std::int64_t start = last * stride[axis];
  stride[axis] = -stride[axis];
  return gathered(volume, geometry, start, stride);
}

Volume transposed(const Volume& volume, const std::array<int, 3>& order) {
  auto sorted = order;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != std::array{0, 1, 2}) throw Error("axis order names an axis twice");
  const GridGeometry& old = volume.geometry();
  GridGeometry geometry = old;
  const Dims old_stride = strides(old.dims);
  Dims stride{};
  for (int a = 0; a < 3; ++a) {
    geometry.dims[a] = old.dims[order[a]];
    geometry.spacing[a] = old.spacing[order[a]];
    geometry.direction.col(a) = old.direction.col(order[a]);
    stride[a] = old_stride[order[a]];
  }
  return gathered(volume, geometry, 0, stride);
}

std::array<int, 3> axis_order(std::string_view text) {
  std::array<int, 3> order{};
  auto sorted = std::string(text);
  std::sort(sorted.begin(), sorted.end());
  if (sorted != "xyz")
    throw Error("axis order '" + std::string(text) + "': expected x, y and z once each, as zyx");
  for (std::size_t a = 0; a < 3; ++a) order[a] = text[a] - 'x';
  return order;
}

}  // namespace vol::volume
