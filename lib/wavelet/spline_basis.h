#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "volume/grid_geometry.h"
#include "wavelet/prototypes.h"

namespace vol::wavelet {

/// Battle's and Lemarie's functions in the B-splines that they are sums of, beta centred and of the same
/// degree:
///   phi(x) = sum_m a[m] beta(x - m),   psi(x) = sum_m b[m] beta(2x - m),
/// with first numbers of m. A function reaches as far as its coefficients are kept (1e-16, prototypes.h); a
/// B-spline reaches 1 or 2 to each side.
struct SplineBasis {
  std::vector<double> a, b;
  std::int64_t first_a = 0, first_b = 0;
  PiecewiseCubic beta;
};

/// \param degree  1 or 3
[[nodiscard]] SplineBasis battle_lemarie_basis(int degree);

/// One axis of a subband, as to_b_splines() takes it: n coefficients become n of phi's axes, 2n of psi's.
enum class SplineAxis { none, phi, psi };

/// Number of B-spline coefficients along an axis of n coefficients.
[[nodiscard]] constexpr std::int64_t spline_length(SplineAxis axis, std::int64_t n) {
  return axis == SplineAxis::psi ? 2 * n : n;
}

/// Coefficients of a subband's functions turned into those of B-splines, axis after axis, periodic:
///   d[j] = sum_k c[k] a[j - k]  or  sum_k c[k] b[j - 2k].
/// What is below 1e-17 of the largest is 0 then, the coefficients of a few functions far from each of them
/// among it. Overwrites dims. x fastest. The sums' rounding is at most some ulp of sum |c|.
[[nodiscard]] std::vector<double> to_b_splines(const SplineBasis& basis, std::vector<double> coefficients,
                                               Dims& dims, const std::array<SplineAxis, 3>& axes);

}  // namespace vol::wavelet
