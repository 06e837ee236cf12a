#pragma once
#include <array>
#include <cstddef>

#include "image/image.h"

namespace vol::image {

/// Structural similarity of two equally large channels x and y. In each window, with weights w that sum to 1:
///   mu = sum w x,   var = sum w (x - mu)^2,   cov = sum w (x - mu_x)(y - mu_y),
///   ssim = (2 mu_x mu_y + C1)(2 cov + C2) / ((mu_x^2 + mu_y^2 + C1)(var_x + var_y + C2)),
///   C1 = (0.01 peak)^2,  C2 = (0.03 peak)^2.
inline constexpr int kSsimWindow = 11;
inline constexpr double kSsimSigma = 1.5;
inline constexpr double kSsimK1 = 0.01;
inline constexpr double kSsimK2 = 0.03;

/// The window's profile along one axis, exp(-(k - 5)^2 / (2 sigma^2)), scaled to sum 1: w(j, k) = w[j] w[k].
[[nodiscard]] const std::array<double, kSsimWindow>& ssim_weights();

/// The definition, window by window, in double: the oracle of the fast version. Mean over whole windows; NaN
/// for an image narrower or lower than 11 pixels.
[[nodiscard]] double ssim_reference(const Image& x, int x_channel, const Image& y, int y_channel,
                                    double peak);

/// A tile of sums s = x + y - s0 and differences d = x - y - d0, rows of `stride` doubles.
///
/// The fast version filters s, d, s^2 and d^2, down the columns and then along the rows. From them
///   2 cov = (var_s - var_d)/2,   var_x + var_y = (var_s + var_d)/2,
///   2 mu_x mu_y = (mu_s^2 - mu_d^2)/2,   mu_x^2 + mu_y^2 = (mu_s^2 + mu_d^2)/2:
/// four filtered planes instead of five, and nearly equal images lose nothing by cancellation, since their
/// difference is formed before anything is squared. s0 and d0, the tile's means, are taken off first so that
/// a small signal on a large offset keeps its digits: the error of a variance is some 1e-15 times the square
/// of the tile's range, not of its values. Equal images give exactly 1.
struct SsimTile {
  const double* s;
  const double* d;
  std::size_t stride;   ///< at least columns + 10 + kSsimPadding, all of it readable
  std::size_t columns;  ///< windows along x
  std::size_t rows;     ///< windows along y
  double s0;
  double d0;
  double c1;
  double c2;
  double* scratch;  ///< 5 stride doubles
};
inline constexpr std::size_t kSsimPadding = 16;  ///< vectors may run over the end of a row by this much

/// Sum of the similarity of the tile's windows; vectorised, the same bits on every instruction set.
[[nodiscard]] double ssim_sum(const SsimTile& tile);

}  // namespace vol::image
