#include "index/macrocells.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace vol::index {
namespace {

constexpr int kEdge = Macrocells::kEdge;

float rounded_down(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafterf(f, -std::numeric_limits<float>::infinity()) : f;
}

float rounded_up(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) < v ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

/// One row of macrocells: first the smallest and largest sample over the row's (y, z) cross-section for each
/// x, which vectorises; then over each block of x.
template <class T>
void fill_row(const volume::Grid<T>& grid, std::int64_t b, std::int64_t c, std::vector<T>& low,
              std::vector<T>& high, Macrocells& cells) {
  const auto [nx, ny, nz] = grid.dims();
  const auto n = static_cast<std::size_t>(nx);
  bool first = true;
  for (std::int64_t k = c * kEdge; k <= std::min(c * kEdge + kEdge, nz - 1); ++k) {
    for (std::int64_t j = b * kEdge; j <= std::min(b * kEdge + kEdge, ny - 1); ++j) {
      const T* row = grid.voxels.data() + grid.offset(0, j, k);
      T* lo = low.data();
      T* hi = high.data();
      if (first) {
        std::copy(row, row + n, lo);
        std::copy(row, row + n, hi);
      } else {
        for (std::size_t i = 0; i < n; ++i) {
          lo[i] = row[i] < lo[i] ? row[i] : lo[i];
          hi[i] = row[i] > hi[i] ? row[i] : hi[i];
        }
      }
      first = false;
    }
  }
  for (std::int64_t a = 0; a < cells.dims[0]; ++a) {
    const auto end = std::min(a * kEdge + kEdge, nx - 1) + 1;
    const T lo = *std::min_element(low.begin() + a * kEdge, low.begin() + end);
    const T hi = *std::max_element(high.begin() + a * kEdge, high.begin() + end);
    cells.ranges[cells.offset(a, b, c)] = {rounded_down(static_cast<double>(lo)),
                                           rounded_up(static_cast<double>(hi))};
  }
}

}  // namespace

Macrocells macrocells(const volume::Volume& volume) {
  Macrocells cells;
  const Dims& dims = volume.geometry().dims;
  for (int axis = 0; axis < 3; ++axis)
    cells.dims[axis] = std::max<std::int64_t>(1, (dims[axis] - 1 + kEdge - 1) / kEdge);
  cells.ranges = Buffer<Macrocells::Range>(cells.offset(0, 0, cells.dims[2]));
  volume::visit(volume, [&](const auto& grid) {
    using T = typename std::decay_t<decltype(grid)>::value_type;
    parallel_for(0, cells.dims[1] * cells.dims[2], 4, [&](std::int64_t begin, std::int64_t end) {
      std::vector<T> low(static_cast<std::size_t>(dims[0])), high(low.size());
      for (std::int64_t row = begin; row < end; ++row) {
        fill_row(grid, row % cells.dims[1], row / cells.dims[1], low, high, cells);
      }
    });
  });
  cells.all = cells.ranges[0];
  for (const auto& range : cells.ranges) {
    cells.all.min = std::min(cells.all.min, range.min);
    cells.all.max = std::max(cells.all.max, range.max);
  }
  return cells;
}

}  // namespace vol::index
