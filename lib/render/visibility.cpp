#include "render/visibility.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "volume/b_spline.h"
#include "volume/field_sampler.h"

namespace vol::render {

using volume::Reconstruction;

BlockRanges::BlockRanges(const volume::Volume& volume, Reconstruction reconstruction) {
  const Dims& dims = volume.geometry().dims;
  for (int a = 0; a < 3; ++a) {
    cells_[a] = std::max<std::int64_t>(1, dims[a] - 1);
    blocks_[a] = (cells_[a] + kBlock - 1) / kBlock;
  }
  ranges_.resize(static_cast<std::size_t>(blocks_[0] * blocks_[1] * blocks_[2]));
  const bool cubic =
      reconstruction == Reconstruction::catmull_rom || reconstruction == Reconstruction::b_spline;
  volume::visit(volume, [&](const auto& grid) {
    if (reconstruction == Reconstruction::b_spline) {
      gather(volume::Grid<double>{grid.geometry, volume::b_spline_coefficients(grid)}, 1);
    } else {
      gather(grid, cubic ? 1 : 0);
    }
  });
  const double widening = reconstruction == Reconstruction::catmull_rom ? 1.25 * 1.25 * 1.25 : 1;
  for (auto& range : ranges_) {
    const double middle = 0.5 * range.min + 0.5 * range.max;
    const double half = widening * (0.5 * range.max - 0.5 * range.min);
    // A weighted mean of equal samples may round beyond them.
    const double slack = 1e-14 * std::max(std::abs(range.min), std::abs(range.max));
    range = {std::min(middle - half, range.min) - slack, std::max(middle + half, range.max) + slack};
  }
}

template <class T>
void BlockRanges::gather(const volume::Grid<T>& grid, std::int64_t margin) {
  const Dims& dims = grid.dims();
  parallel_for(0, blocks_[2] * blocks_[1], 8, [&](std::int64_t first, std::int64_t end) {
    for (std::int64_t row = first; row < end; ++row) {
      const std::int64_t at[3] = {0, row % blocks_[1], row / blocks_[1]};
      for (std::int64_t b = 0; b < blocks_[0]; ++b) {
        std::int64_t lower[3], upper[3];  // samples, half open
        for (int a = 0; a < 3; ++a) {
          const std::int64_t cell = (a == 0 ? b : at[a]) * kBlock;
          lower[a] = std::max<std::int64_t>(0, cell - margin);
          upper[a] = std::min(dims[a], cell + kBlock + 1 + margin);
          // The parabola that continues Catmull-Rom beyond the border reaches one sample further in.
          if (margin > 0 && cell == 0) upper[a] = std::min(dims[a], std::max<std::int64_t>(upper[a], 3));
          if (margin > 0 && upper[a] == dims[a]) {
            lower[a] = std::max<std::int64_t>(0, std::min(lower[a], dims[a] - 3));
          }
        }
        double lo = static_cast<double>(grid(lower[0], lower[1], lower[2]));
        double hi = lo;
        for (std::int64_t k = lower[2]; k < upper[2]; ++k) {
          for (std::int64_t j = lower[1]; j < upper[1]; ++j) {
            for (std::int64_t i = lower[0]; i < upper[0]; ++i) {
              const auto v = static_cast<double>(grid(i, j, k));
              lo = std::min(lo, v);
              hi = std::max(hi, v);
            }
          }
        }
        ranges_[static_cast<std::size_t>(b + blocks_[0] * row)] = {lo, hi};
      }
    }
  });
}

std::size_t BlockRanges::block_at(const Vec3& u) const {
  std::int64_t b[3];
  for (int a = 0; a < 3; ++a) {
    const double cell = u[a] * static_cast<double>(cells_[a]);
    b[a] = !(cell > 0) ? 0 : std::min(static_cast<std::int64_t>(cell), cells_[a] - 1) / kBlock;
  }
  return static_cast<std::size_t>(b[0] + blocks_[0] * (b[1] + blocks_[1] * b[2]));
}

}  // namespace vol::render
