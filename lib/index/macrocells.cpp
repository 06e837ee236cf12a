#include "index/macrocells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "volume/b_spline.h"

namespace vol::index {
namespace {

using volume::Reconstruction;

constexpr std::int64_t kEdge = Macrocells::kEdge;

float rounded_down(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafterf(f, -std::numeric_limits<float>::infinity()) : f;
}

float rounded_up(double v) {
  const auto f = static_cast<float>(v);
  return static_cast<double>(f) < v ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

/// Samples [first, end) of an axis of n that macrocell `a` depends on; `margin` samples beyond its corners.
struct Reach {
  std::int64_t first, end;
  Reach(std::int64_t a, std::int64_t n, std::int64_t margin)
      : first(std::max<std::int64_t>(0, kEdge * a - margin)), end(std::min(n, kEdge * (a + 1) + 1 + margin)) {
    if (margin == 0) return;
    // The parabola that continues a cubic kernel beyond the border reaches one sample further in.
    if (first == 0) end = std::min(n, std::max<std::int64_t>(end, 3));
    if (end == n) first = std::max<std::int64_t>(0, std::min(first, n - 3));
  }
};

/// One row of macrocells: first the smallest and largest sample over the row's (y, z) cross-section for each
/// x, which vectorises; then over each block of x.
template <class T>
void fill_row(const volume::Grid<T>& grid, std::int64_t b, std::int64_t c, std::int64_t margin,
              double widening, std::vector<T>& low, std::vector<T>& high, Macrocells& cells) {
  const auto [nx, ny, nz] = grid.dims();
  const auto n = static_cast<std::size_t>(nx);
  const Reach rows(b, ny, margin), slices(c, nz, margin);
  bool first = true;
  for (std::int64_t k = slices.first; k < slices.end; ++k) {
    for (std::int64_t j = rows.first; j < rows.end; ++j) {
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
    const Reach columns(a, nx, margin);
    auto lo = static_cast<double>(*std::min_element(low.begin() + columns.first, low.begin() + columns.end));
    auto hi =
        static_cast<double>(*std::max_element(high.begin() + columns.first, high.begin() + columns.end));
    if (widening > 1) {
      const double middle = 0.5 * lo + 0.5 * hi, half = widening * (0.5 * hi - 0.5 * lo);
      lo = std::min(middle - half, lo);
      hi = std::max(middle + half, hi);
    }
    cells.ranges[cells.offset(a, b, c)] = {rounded_down(lo), rounded_up(hi)};
  }
}

template <class T>
void fill(const volume::Grid<T>& grid, std::int64_t margin, double widening, Macrocells& cells) {
  parallel_for(0, cells.dims[1] * cells.dims[2], 4, [&](std::int64_t begin, std::int64_t end) {
    std::vector<T> low(static_cast<std::size_t>(grid.dims()[0])), high(low.size());
    for (std::int64_t row = begin; row < end; ++row) {
      fill_row(grid, row % cells.dims[1], row / cells.dims[1], margin, widening, low, high, cells);
    }
  });
}

}  // namespace

Macrocells macrocells(const volume::Volume& volume, Reconstruction reconstruction) {
  Macrocells cells;
  const Dims& dims = volume.geometry().dims;
  for (int axis = 0; axis < 3; ++axis)
    cells.dims[axis] = std::max<std::int64_t>(1, (dims[axis] - 1 + kEdge - 1) / kEdge);
  cells.ranges = Buffer<Macrocells::Range>(cells.offset(0, 0, cells.dims[2]));
  volume::visit(volume, [&](const auto& grid) {
    if (reconstruction == Reconstruction::b_spline) {
      fill(volume::Grid<double>{grid.geometry, volume::b_spline_coefficients(grid)}, 1, 1, cells);
    } else if (reconstruction == Reconstruction::catmull_rom) {
      fill(grid, 1, 1.25 * 1.25 * 1.25, cells);
    } else {
      fill(grid, 0, 1, cells);
    }
  });
  cells.all = cells.ranges[0];
  for (const auto& range : cells.ranges) {
    cells.all.min = std::min(cells.all.min, range.min);
    cells.all.max = std::max(cells.all.max, range.max);
  }
  return cells;
}

}  // namespace vol::index
