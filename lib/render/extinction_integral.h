#pragma once
#include <functional>
#include <vector>

#include "render/picture.h"
#include "render/ray_polynomial.h"
#include "render/shading.h"

namespace vol::render {

/// A medium whose extinction is a field itself, f per world length, and whose colour is white (Gross,
/// Lippert, Dreger & Koch 1995, eq. 36 and 39), of one ray, front to back over polynomial pieces of the
/// field:
///   I = integral of L(t) f(t) T(t) dt,  T(t) = exp(-integral of f up to t),
/// L what light makes of white, 1 without. T is exact at every t but for rounding: the integral of a
/// polynomial is one. Without light so is I = 1 - T(end), for f T = -dT/dt.
///
/// With light a piece is cut where f changes sign (and, for a headlight, where f's slope along the ray does,
/// the kinks of |N.L|), so that T is monotone in it, and where T falls by more than e^-2. On a panel
/// I = (T0 - T1) mean of L, weighted by f T; the mean over seven Kronrod nodes is taken where that over the
/// three Gauss nodes among them is within the panel's share of the tolerance, else the panel is halved.
///
/// f < 0 would be light from nowhere. It counts as 0, pieces being cut at its roots, unless asked otherwise;
/// the integral then follows its definition, and T may exceed 1.
class ExtinctionIntegral {
 public:
  using Light = std::function<Lit(double t)>;

  struct Options {
    bool keep_negative = false;
    double tolerance = 1e-6;  ///< absolute, of the ray's integral; > 0
    double brightest = 1;     ///< upper bound of L
    bool headlight = false;
  };
  /// \param ray_length  of the chord, which the tolerance is for
  /// \param light       of the point at t, or empty for none
  ExtinctionIntegral(const Options& options, double ray_length, Light light = {});

  /// Adds the next piece of f. \returns false once nothing more can be seen.
  bool add(const RayPiece& piece);

  /// alpha = 1 - T, depth where T falls to 1/2, error what was accepted: at most the tolerance, a few times
  /// it on rays of more than a thousand pieces, and more where a piece takes 1000 panels or 40 halvings: it
  /// says how much.
  [[nodiscard]] Pixel pixel() const;

  [[nodiscard]] double optical_depth() const { return depth_; }
  /// Integral of -f over where it was taken for 0.
  [[nodiscard]] double clamped_depth() const { return clamped_depth_; }
  /// Pieces with such a stretch; those no deeper than rounding, 1e-12 of the largest |f|, do not count.
  [[nodiscard]] std::int64_t clamped_pieces() const;

 private:
  void stretch(const Bernstein& f, double t0, double t1);
  void lit_panel(const Bernstein& f, double t0, double t1, double u0, double u1, double tolerance, int level);

  Options options_;
  double ray_length_;
  Light light_;
  double depth_ = 0;  // optical, so far
  double colour_ = 0, error_ = 0;
  double half_ = std::numeric_limits<double>::infinity();
  int panels_ = 0;  // of the stretch at hand
  double clamped_depth_ = 0;
  double largest_ = 0;           // |f|
  std::vector<double> clamped_;  // how far below 0, of every clamped piece
  std::vector<double> cuts_;
};

}  // namespace vol::render
