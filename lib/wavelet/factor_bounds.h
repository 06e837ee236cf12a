#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "wavelet/prototypes.h"

namespace vol::wavelet {

/// What a function of one variable can do on an interval; lengths in knot distances.
struct FactorBound {
  double value = 0;  ///< of |f|
  double slope = 0;  ///< of |f'|, at a jump those on either side
  double bend = 0;   ///< of |f''|, at a kink those on either side
  double jump = 0;   ///< sum of |jumps of f|
  double kink = 0;   ///< sum of |jumps of f'|
};

/// Bounds of a piecewise cubic on any interval: exact over whole pieces, by Taylor's formula on parts of one.
/// Jumps below 1e-13 of the largest |f|, and of the largest |f'|, are rounding and count as none. Refers to
/// the function, which must live longer.
class FactorBounds {
 public:
  /// \param periodic  f goes on with the period of its pieces; else it is 0 outside them
  FactorBounds(const PiecewiseCubic& f, bool periodic);

  /// On the closed interval from q = from to q = to, q = (x - f.lower) / f.spacing.
  [[nodiscard]] FactorBound on(double from, double to) const;
  /// On one period, or everywhere.
  [[nodiscard]] const FactorBound& whole() const { return whole_; }

  [[nodiscard]] const PiecewiseCubic& function() const { return *f_; }
  [[nodiscard]] bool periodic() const { return periodic_; }

  /// The piece that q lies in, none outside the support; v is where in the piece, in [0, 1).
  [[nodiscard]] const std::array<double, 4>* piece(double q, double& v) const;

 private:
  using Largest = std::array<double, 3>;  ///< of |f|, |f'|, |f''|

  void widen(FactorBound& bound, std::ptrdiff_t first, std::ptrdiff_t last) const;  ///< by whole pieces
  void widen_by_part(FactorBound& bound, std::ptrdiff_t piece, double from, double to) const;
  void add_jumps(FactorBound& bound, std::ptrdiff_t first, std::ptrdiff_t last) const;  ///< of these knots

  const PiecewiseCubic* f_;
  bool periodic_;
  std::ptrdiff_t count_;
  FactorBound whole_;
  std::vector<Largest> largest_;              // a tree of maxima: leaves from count_ on, node i over 2i, 2i+1
  std::vector<std::array<double, 2>> jumps_;  // sums over the knots before; of f and of f'
};

}  // namespace vol::wavelet
