#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "volume/field_sampler.h"

namespace vol::volume {

/// Weights of the samples of one axis under a kernel at one position: f = sum w[t] c[index[t]],
/// df/dx = sum dw[t] c[index[t]], x in index units. What a kernel needs beyond the border is folded into the
/// weights of samples that exist, so every index is one of the grid's.
template <int kTaps>
struct AxisWeights {
  std::array<std::int64_t, kTaps> index;
  std::array<double, kTaps> w;
  std::array<double, kTaps> dw;
};

/// Number of samples per axis under a kernel.
[[nodiscard]] constexpr int taps(Reconstruction kernel) {
  return kernel == Reconstruction::nearest ? 1 : kernel == Reconstruction::trilinear ? 2 : 4;
}

/// x clamped to an axis of n samples, [0, n-1]; NaN becomes 0.
[[nodiscard]] inline double clamped_to_axis(double x, std::int64_t n) {
  const double last = static_cast<double>(n - 1);
  return !(x > 0) ? 0 : x < last ? x : last;
}

/// The cell [i, i+1] that x, already clamped, lies in; the far border belongs to the last cell. n >= 2.
[[nodiscard]] inline std::int64_t cell_of(double x, std::int64_t n) {
  const auto i = static_cast<std::int64_t>(x);
  return i < n - 1 ? i : n - 2;
}

/// The nearest sample, the upper of two equally near; the derivative is that of a step function, 0.
inline AxisWeights<1> nearest_weights(double x, std::int64_t n) {
  const auto i = static_cast<std::int64_t>(x + 0.5);
  return {{i < n ? i : n - 1}, {1}, {0}};
}

inline AxisWeights<2> linear_weights(double x, std::int64_t n) {
  if (n == 1) return {{0, 0}, {1, 0}, {0, 0}};
  const std::int64_t i = cell_of(x, n);
  const double u = x - static_cast<double>(i);
  return {{i, i + 1}, {1 - u, u}, {-1, 1}};
}

/// Catmull-Rom, the cubic convolution kernel with a = -1/2 (Keys 1981): interpolates, is C1 and reproduces
/// quadratics. On [i, i+1] with u = x - i the weights of samples i-1 .. i+2 are
///   (-u + 2u^2 - u^3)/2,  (2 - 5u^2 + 3u^3)/2,  (u + 4u^2 - 3u^3)/2,  (-u^2 + u^3)/2.
/// At the border the missing sample continues the parabola through the three outermost ones,
/// c[-1] = 3 c[0] - 3 c[1] + c[2] (Keys 1981, section IV), so that quadratics are exact up to the border:
/// linear extrapolation or clamping would lose an order there. Two samples are continued by their line.
inline AxisWeights<4> catmull_rom_weights(double x, std::int64_t n) {
  if (n == 1) return {{0, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 0}};
  const std::int64_t i = cell_of(x, n);
  const double u = x - static_cast<double>(i);
  AxisWeights<4> a{{i - 1, i, i + 1, i + 2},
                   {0.5 * u * (-1 + u * (2 - u)), 0.5 * (2 + u * u * (-5 + 3 * u)),
                    0.5 * u * (1 + u * (4 - 3 * u)), 0.5 * u * u * (-1 + u)},
                   {0.5 * (-1 + u * (4 - 3 * u)), 0.5 * u * (-10 + 9 * u), 0.5 * (1 + u * (8 - 9 * u)),
                    0.5 * u * (-2 + 3 * u)}};
  const auto fold = [&](int from, int near, int far, int farthest) {
    for (auto* w : {&a.w, &a.dw}) {
      const double beyond = (*w)[from];
      (*w)[from] = 0;
      if (n == 2) {
        (*w)[near] += 2 * beyond;
        (*w)[far] -= beyond;
      } else {
        (*w)[near] += 3 * beyond;
        (*w)[far] -= 3 * beyond;
        (*w)[farthest] += beyond;
      }
    }
    a.index[from] = a.index[near];
  };
  if (i == 0) fold(0, 1, 2, 3);
  if (i == n - 2) fold(3, 2, 1, 0);
  return a;
}

/// Cubic B-spline: on [i, i+1] with u = x - i the weights of coefficients i-1 .. i+2 are
///   (1-u)^3/6,  2/3 - u^2 + u^3/2,  2/3 - (1-u)^2 + (1-u)^3/2,  u^3/6.
/// Coefficients beyond the border are their mirror images, c[-1] = c[1], as the prefilter assumes.
inline AxisWeights<4> b_spline_weights(double x, std::int64_t n) {
  if (n == 1) return {{0, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 0}};
  const std::int64_t i = cell_of(x, n);
  const double u = x - static_cast<double>(i);
  const double v = 1 - u;
  AxisWeights<4> a{
      {i - 1, i, i + 1, i + 2},
      {v * v * v / 6, 2.0 / 3 + u * u * (0.5 * u - 1), 2.0 / 3 + v * v * (0.5 * v - 1), u * u * u / 6},
      {-0.5 * v * v, u * (1.5 * u - 2), -v * (1.5 * v - 2), 0.5 * u * u}};
  if (i == 0) a.index[0] = 1;
  if (i == n - 2) a.index[3] = n - 2;
  return a;
}

/// The weights of a kernel chosen at compile time; x already clamped to [0, n-1].
template <Reconstruction kKernel>
inline AxisWeights<taps(kKernel)> axis_weights(double x, std::int64_t n) {
  if constexpr (kKernel == Reconstruction::nearest) {
    return nearest_weights(x, n);
  } else if constexpr (kKernel == Reconstruction::trilinear) {
    return linear_weights(x, n);
  } else if constexpr (kKernel == Reconstruction::catmull_rom) {
    return catmull_rom_weights(x, n);
  } else {
    return b_spline_weights(x, n);
  }
}

}  // namespace vol::volume
