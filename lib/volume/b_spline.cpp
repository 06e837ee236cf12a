#include "volume/b_spline.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace vol::volume {
namespace {

const double kPole = std::sqrt(3.0) - 2;
constexpr std::int64_t kHorizon = 40;  // |z|^40 = 1e-23: below the rounding of any sum of doubles
constexpr std::int64_t kColumns =
    512;  // lines filtered side by side: contiguous in memory, and within the L2 cache

/// Filters `width` lines side by side: sample m of line w is data[m * stride + w].
void filter_lines(double* data, std::int64_t n, std::int64_t stride, std::int64_t width) {
  if (n == 1) return;
  const double z = kPole;
  const auto row = [&](std::int64_t m) { return data + m * stride; };
  // c+[0] = sum over the mirrored period of z^k s[k] / (1 - z^(2n-2)), into row 0.
  const double period = std::pow(z, static_cast<double>(2 * n - 2));
  for (std::int64_t m = 1; m < std::min(n, kHorizon); ++m) {
    const double forward = std::pow(z, static_cast<double>(m));
    const double weight = m == n - 1 ? forward : forward + std::pow(z, static_cast<double>(2 * n - 2 - m));
    for (std::int64_t w = 0; w < width; ++w) row(0)[w] += weight * row(m)[w];
  }
  for (std::int64_t w = 0; w < width; ++w) row(0)[w] *= 6 / (1 - period);
  for (std::int64_t m = 1; m < n; ++m) {
    for (std::int64_t w = 0; w < width; ++w) row(m)[w] = 6 * row(m)[w] + z * row(m - 1)[w];
  }
  for (std::int64_t w = 0; w < width; ++w) {
    row(n - 1)[w] = z / (z * z - 1) * (row(n - 1)[w] + z * row(n - 2)[w]);
  }
  for (std::int64_t m = n - 2; m >= 0; --m) {
    for (std::int64_t w = 0; w < width; ++w) row(m)[w] = z * (row(m + 1)[w] - row(m)[w]);
  }
}

}  // namespace

template <class T>
Buffer<double> b_spline_coefficients(const Grid<T>& grid) {
  const auto [nx, ny, nz] = grid.dims();
  const std::int64_t slice = nx * ny;
  Buffer<double> c(grid.voxels.size());
  parallel_for(0, nz, 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) {
      double* plane = c.data() + k * slice;
      std::transform(grid.voxels.begin() + k * slice, grid.voxels.begin() + (k + 1) * slice, plane,
                     [](T value) { return static_cast<double>(value); });
      for (std::int64_t j = 0; j < ny; ++j) filter_lines(plane + j * nx, nx, 1, 1);  // along x
      for (std::int64_t i = 0; i < nx; i += kColumns) {                              // along y
        filter_lines(plane + i, ny, nx, std::min(kColumns, nx - i));
      }
    }
  });
  parallel_for(0, slice, kColumns, [&](std::int64_t first, std::int64_t last) {  // along z
    filter_lines(c.data() + first, nz, slice, last - first);
  });
  return c;
}

template Buffer<double> b_spline_coefficients(const Grid<std::int8_t>&);
template Buffer<double> b_spline_coefficients(const Grid<std::uint8_t>&);
template Buffer<double> b_spline_coefficients(const Grid<std::int16_t>&);
template Buffer<double> b_spline_coefficients(const Grid<std::uint16_t>&);
template Buffer<double> b_spline_coefficients(const Grid<std::int32_t>&);
template Buffer<double> b_spline_coefficients(const Grid<std::uint32_t>&);
template Buffer<double> b_spline_coefficients(const Grid<half>&);
template Buffer<double> b_spline_coefficients(const Grid<float>&);
template Buffer<double> b_spline_coefficients(const Grid<double>&);

}  // namespace vol::volume
