#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "render/optics.h"

namespace vol::render {

/// By how much an extinction of -log(1 - opacity) may be off: a share of it, or for one reference length.
inline constexpr double kExtinctionShare = 2e-6, kLeastExtinctionError = 1e-9;
[[nodiscard]] inline double extinction_error(double opacity) {
  return std::max(kLeastExtinctionError, kExtinctionShare * -std::log1p(-opacity));
}

/// log2(1 - opacity) over part of a ramp, as a polynomial in the distance of the value from the piece's
/// clearer end: its terms then have nearly all one sign, and no digit is lost between them.
struct ExtinctionPiece {
  static constexpr int kDegree = 5;
  double from;                      ///< holds from this value up to where the next piece begins
  double origin;                    ///< the clearer end
  double coefficient[kDegree + 1];  ///< of ((value - origin) / (hi - lo))^j

  /// The same polynomial by the distance from another value, `shift` times hi - lo away.
  [[nodiscard]] ExtinctionPiece around(double other, double shift) const;
};

/// Cuts log2(1 - opacity) over the values [lo, hi] into polynomials of degree 5, through Chebyshev points,
/// that err by at most extinction_error(). With d the change of opacity over a piece and q = d / (1 -
/// opacity) at its denser end, the derivatives of the logarithm bound the error of interpolation (Davis 1975,
/// section 3.1) by
///   q^6 / (6 2^11)     of the piece as it is,
///   t q^6 / (6 2^9)    at a share t of a piece that begins with opacity 0: there the logarithm over t is
///                      interpolated, so that the polynomial is 0 where it must be.
///
/// \returns nothing where opacity is 1; where it takes more than `most` pieces, as near opacity 1; and where
///          one is narrower than 1e-5 of hi - lo, whose coefficients would come near the end of floats
[[nodiscard]] std::vector<ExtinctionPiece> extinction_pieces(const Optics& optics, double lo, double hi,
                                                             std::size_t most);

}  // namespace vol::render
