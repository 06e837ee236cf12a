#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>

#include "volume/volume.h"

namespace vol::isosurface {

/// The value of what lies beyond a closed border.
inline constexpr double kOutside = -std::numeric_limits<double>::infinity();

/// The grid as the algorithm sees it: `pad` samples outside at every end.
template <class T>
struct PaddedGrid {
  const T* samples;
  Dims dims;  // of the samples
  int pad;

  explicit PaddedGrid(const volume::Grid<T>& grid, bool close)
      : samples(grid.voxels.data()), dims(grid.dims()), pad(close ? 1 : 0) {}
  [[nodiscard]] bool is_beyond(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return pad != 0 && (i < 1 || j < 1 || k < 1 || i > dims[0] || j > dims[1] || k > dims[2]);
  }
  [[nodiscard]] double sample(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<double>(samples[i + dims[0] * (j + dims[1] * k)]);
  }
  /// By padded indices.
  [[nodiscard]] double value(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return is_beyond(i, j, k) ? kOutside : sample(i - pad, j - pad, k - pad);
  }
  /// Adds share times the central differences, one-sided at the border, in value per sample; by the samples'
  /// own indices.
  void add_gradient(std::int64_t i, std::int64_t j, std::int64_t k, double share, double* g) const {
    const std::int64_t at[3] = {i, j, k};
    const std::int64_t stride[3] = {1, dims[0], dims[0] * dims[1]};
    const T* here = samples + i + stride[1] * j + stride[2] * k;
    for (int a = 0; a < 3; ++a) {
      const bool low = at[a] > 0;
      const bool high = at[a] + 1 < dims[a];
      const double difference =
          static_cast<double>(here[high ? stride[a] : 0]) - static_cast<double>(here[low ? -stride[a] : 0]);
      g[a] += (low && high ? 0.5 * share : share) * difference;
    }
  }
};

/// The grid with every axis of one sample made two, half a spacing to either side.
template <class T>
[[nodiscard]] volume::Grid<T> thickened(const volume::Grid<T>& grid) {
  volume::Grid<T> result;
  result.geometry = grid.geometry;
  for (auto& n : result.geometry.dims) n = std::max<std::int64_t>(n, 2);
  result.voxels = Buffer<T>(static_cast<std::size_t>(result.geometry.count()));
  const Dims& d = result.dims();
  const Dims& from = grid.dims();
  for (std::int64_t k = 0; k < d[2]; ++k) {
    for (std::int64_t j = 0; j < d[1]; ++j) {
      for (std::int64_t i = 0; i < d[0]; ++i) {
        result(i, j, k) = grid(std::min(i, from[0] - 1), std::min(j, from[1] - 1), std::min(k, from[2] - 1));
      }
    }
  }
  return result;
}

}  // namespace vol::isosurface
