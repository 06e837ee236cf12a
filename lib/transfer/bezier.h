#pragma once
#include <span>
#include <string>
#include <vector>

#include "base/vec.h"
#include "transfer/transfer_function.h"

namespace vol::transfer {

/// Control points that files and fits may have: degree 20.
inline constexpr int kMostControlPoints = 21;
/// Curves that one transfer function may have.
inline constexpr std::size_t kMostCurves = 64;

/// Value and derivative of a polynomial in Bernstein form, sum_i C(n-1, i) (1-t)^(n-1-i) t^i P_i, by de
/// Casteljau: repeated means of neighbours, so that for t in [0, 1] nothing cancels but the P_i themselves.
struct ValueAndSlope {
  double value = 0, slope = 0;
};
/// \param points  1 to kMostControlPoints
[[nodiscard]] ValueAndSlope de_casteljau(std::span<const double> points, double t);

/// The n Bernstein polynomials of degree n - 1 at t, by the same means: out[i] = C(n-1, i) (1-t)^(n-1-i) t^i.
void bernstein_basis(double t, std::span<double> out);

/// Control points of the same polynomial at the degree of n points: each step up takes means of neighbours,
/// so that bounds of the points stay. \param n  at least as many as there are
[[nodiscard]] std::vector<double> elevated(std::vector<double> points, std::size_t n);

/// A weight B(v) of the data value v, scaled to [0, 1]; values outside count as the nearer end (Cheng 2007,
/// eq. 33). With ordinates alone B is the polynomial with these control points. With abscissae it is the
/// graph of a curve (X(t), Y(t)): B(v) = Y(t) where X(t) = v; X rises, because the abscissae do.
class BezierCurve {
 public:
  /// \param abscissae  none, or as many as ordinates: rising strictly from 0 to 1
  /// \throws vol::Error for no points or more than kMostControlPoints, one that is not finite or beyond 1e30,
  ///         abscissae of another form
  explicit BezierCurve(std::vector<double> ordinates, std::vector<double> abscissae = {});

  [[nodiscard]] double value(double v) const { return at(v).value; }
  /// B and dB/dv; the slope is that of the polynomial also at the ends, though B is constant outside.
  [[nodiscard]] ValueAndSlope at(double v) const;
  /// t with X(t) = v; v itself where there are no abscissae.
  [[nodiscard]] double parameter(double v) const;
  [[nodiscard]] bool parametric() const { return !abscissae_.empty(); }
  [[nodiscard]] const std::vector<double>& ordinates() const { return ordinates_; }
  [[nodiscard]] const std::vector<double>& abscissae() const { return abscissae_; }

 private:
  std::vector<double> ordinates_, abscissae_;
};

/// A curve and the colour that it counts in.
struct BezierBand {
  std::string name;      ///< UTF-8; may be empty
  Vec3 colour{1, 1, 1};  ///< linear light, 0 to 1e30
  BezierCurve curve;
};

/// Transfer weights as Fourier volume rendering takes them: pictures are the X-ray of the weighted field,
/// integral of v B(v) with v = (value - lo)/(hi - lo), clamped to [0, 1]; of several bands the sum of colour
/// times that.
struct BezierTransfer {
  double lo = 0, hi = 1;
  std::vector<BezierBand> bands;

  /// \throws vol::Error without bands, more than kMostCurves, a range without extent, a colour that is
  ///         negative, beyond 1e30 or not finite, a name that is not UTF-8
  void validate() const;
  [[nodiscard]] double scaled(double value) const;
  /// v sum_b colour_b[channel] B_b(v) of a data value.
  [[nodiscard]] double weighted(double value, int channel) const;
  /// Whether all bands are grey: one picture does for the three channels.
  [[nodiscard]] bool grey() const;
};

/// The same for emission and absorption: opacity is the sum of the B_b(v), each at least 0, cut at 1; colour
/// their mean, weighted by the B_b(v). Points as close as keeps lines between them within `tolerance` of
/// opacity and colour, at most 4096 pieces: what a kink costs at a point's distance of 1/4096 is the rest.
[[nodiscard]] TransferFunction as_transfer_function(const BezierTransfer& bezier, double tolerance = 1e-4);

}  // namespace vol::transfer
