#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "wavelet/filters.h"

namespace vol::wavelet {

/// A piecewise polynomial of degree 3 at most on the knots lower + i spacing, i = 0 .. pieces.size(), and 0
/// outside: on [knot_i, knot_i+1) it is a0 + a1 v + a2 v^2 + a3 v^3, v = (x - knot_i) / spacing in [0, 1).
struct PiecewiseCubic {
  double lower = 0;
  double spacing = 1;  ///< a power of two
  std::vector<std::array<double, 4>> pieces;

  [[nodiscard]] double upper() const { return lower + spacing * static_cast<double>(pieces.size()); }
  [[nodiscard]] double value(double x) const;
  [[nodiscard]] double derivative(double x) const;
  /// Whether the function moved by k, a whole number, takes in v: decided without rounding (v - k may round),
  /// so that of a function folded to its period exactly one image takes in each v.
  [[nodiscard]] bool covers(double v, double k) const { return v >= lower + k && v < upper() + k; }
  /// Of the function moved by k: f(v - k), 0 where it does not cover v.
  [[nodiscard]] double value(double v, double k) const;
  [[nodiscard]] double derivative(double v, double k) const;
  [[nodiscard]] double integral() const;
};

/// Scaling function and wavelet of a filter bank as functions of a continuous variable, not centred:
///   phi(x) = sqrt 2 sum_n h[n] phi(2x - n),   psi(x) = sqrt 2 sum_n g[n] phi(2x - n).
struct Prototypes {
  PiecewiseCubic phi;
  PiecewiseCubic psi;
  /// Largest distance from the true functions found at 8 points between two knots, a lower bound; 0 where
  /// they are exact.
  double phi_deviation = 0;
  double psi_deviation = 0;
};

inline constexpr int kMaxDepth = 14;

/// Exact for haar and, as splines on the integers and half integers, for Battle-Lemarie, whose B-spline
/// coefficients are kept down to 1e-16; a truncated Battle-Lemarie stands for the same functions.
///
/// All others: phi at the integers is the eigenvector of the refinement equation, from there the equation
/// leads to all multiples of 2^-depth, and a cubic spline with clamped ends goes through these values (Gross,
/// Lippert, Dreger & Koch 1995, section 4.1). The end slopes of psi are 0. Those of phi are minus the sum of
/// its slopes at the integers inside: with them, and with no others, the splines phi(x - k) add up to 1 for
/// every x. The integrals are 1 and 0. Between the dyadic points the spline is off by the stated deviation,
/// which falls with the depth as 2^(-depth r), r the Hoelder exponent (0.55 for daubechies-4 and coiflet-6).
///
/// \param depth  1 to kMaxDepth: at the integers alone psi does not add up to 0
/// \throws vol::Error on another depth
[[nodiscard]] Prototypes make_prototypes(const Wavelet& wavelet, int depth);

/// phi at the integers first .. last of the filter (not Battle-Lemarie, nor haar, which jumps there), by the
/// eigenvector of the refinement equation, scaled to sum 1.
[[nodiscard]] std::vector<long double> scaling_function_at_integers(const FilterBank& bank);

/// sum_j f(x - j period) on [lower, lower + period), for functions longer than a period; others as they are.
[[nodiscard]] PiecewiseCubic periodised(const PiecewiseCubic& f, std::int64_t period);

}  // namespace vol::wavelet
