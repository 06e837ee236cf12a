#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "wavelet/prototypes.h"

namespace vol::wavelet {

/// A bundle of parallel lines through a product of three functions of one variable: along the third axis z,
/// the line (X, Y) passes x = X + alpha z, y = Y + beta z.
struct FootprintLines {
  const PiecewiseCubic* x = nullptr;
  const PiecewiseCubic* y = nullptr;
  const PiecewiseCubic* z = nullptr;
  double alpha = 0;
  double beta = 0;
};

/// Samples of a function of two variables at (x0 + i h, y0 + j h), i = 0 .. nx-1, j = 0 .. ny-1, j fastest,
/// and 0 beyond. float, because what is asked of footprints is 1e-6 at best.
struct FootprintTable {
  double x0 = 0, y0 = 0, h = 1;
  std::int64_t nx = 0, ny = 0;
  std::vector<float> values;

  /// By the cubic through four samples along each axis.
  [[nodiscard]] double value(double x, double y) const;
  [[nodiscard]] double x1() const { return x0 + h * static_cast<double>(nx - 1); }
  [[nodiscard]] double y1() const { return y0 + h * static_cast<double>(ny - 1); }
  [[nodiscard]] std::int64_t bytes() const { return nx * ny * static_cast<std::int64_t>(sizeof(float)); }
};

/// Weights of the cubic through f(-1), f(0), f(1), f(2) at v in [0, 1].
[[nodiscard]] std::array<double, 4> cubic_weights(double v);

/// Footprints: the line integrals of a basis function over all lines of one direction (Gross, Lippert, Dreger
/// & Koch 1995), cut off at some planes,
///   F_i(X, Y) = integral from z.lower (or from limits[i]) to limits[i] (or z.upper()) of
///               z(u) x(X + alpha u) y(Y + beta u) du,
/// sampled with distance h. Every two Gauss nodes along z serve all lines: at fixed z the integrand is a
/// function of X times one of Y, so that the sum over nodes is a product of two matrices, of which only the
/// band where neither factor vanishes is multiplied. The quadrature does not know the knots of x and y: how
/// far a table is from the truth must be measured (line_integral()).
///
/// x and y should be continuous, also at their ends.
///
/// \param limits     rising, within the support of z
/// \param below      whether a table takes what is below its limit, or what is above
/// \param h          > 0; nodes are at most h apart, and closer where z has closer knots than 2 h
[[nodiscard]] std::vector<FootprintTable> make_footprints(const FootprintLines& lines,
                                                          std::span<const double> limits, bool below,
                                                          double h);

/// Multiplications and memory that make_footprints() would take, at most.
struct FootprintCost {
  double multiplications = 0;
  std::int64_t bytes = 0;  ///< of the tables themselves
};
[[nodiscard]] FootprintCost footprint_cost(const FootprintLines& lines, std::span<const double> limits,
                                           bool below, double h);

/// Whether f is continuous on the whole line, its ends included: jumps above 1e-9 of its largest value count.
[[nodiscard]] bool continuous(const PiecewiseCubic& f);

/// Integral of f over [a, b].
[[nodiscard]] double integral(const PiecewiseCubic& f, double a, double b);

}  // namespace vol::wavelet
