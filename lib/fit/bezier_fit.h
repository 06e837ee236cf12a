#pragma once
#include <string>
#include <vector>

#include "fit/samples.h"
#include "transfer/bezier.h"

namespace vol::fit {

/// What comes close to the target: the weight B(v), or the v B(v) that pictures add up.
enum class Quantity { weight, emission };
/// Of what least .. most are bounds: of nothing; of every control point, and so of the curve; or of the curve
/// alone.
enum class Bounds { none, points, curve };
/// What a residual r counts: r^2, or beyond the scale less, Huber's linear in r, Cauchy's logarithmic.
enum class Loss { none, huber, cauchy };

struct FitOptions {
  int points = 6;
  Quantity quantity = Quantity::weight;
  Bounds bounds = Bounds::points;
  double least = 0, most = 2;
  Loss loss = Loss::none;
  double loss_scale = 0.1;
  double smoothness = 0;    ///< times the sum of the squared second differences of the control points
  bool free_range = false;  ///< the values of v = 0 and v = 1 are unknowns, too
  bool parametric = false;  ///< points have abscissae of their own, which are unknowns
};

/// How near one curve came.
struct Residual {
  double rms = 0;      ///< root of the weighted mean of squares, weights of sum 1
  double largest = 0;  ///< over the samples
};

struct Fit {
  std::vector<transfer::BezierCurve> curves;  ///< one a target
  std::vector<Residual> residuals;            ///< one a target, of the quantity fitted
  volume::Range range;                        ///< data values of v = 0 and v = 1
  std::string method;    ///< qr, active-set (points at bounds), exchange (curve at bounds), ceres
  double condition = 0;  ///< of the (weighted) least squares matrix, for the range and abscissae found
  int rank = 0;          ///< of it; less than points: many curves are as near, of qr's the shortest is taken
  int iterations = 0;    ///< of Ceres, all curves together
};

/// Control points that minimise, over the samples,
///     sum_j weight_j loss(q(v_j) B(v_j) - target_j) + smoothness sum_i (P_i - 2 P_i+1 + P_i+2)^2,
/// q = 1 or v. The linear problem is solved by QR (never by normal equations), of the solutions of a
/// rank-deficient one the shortest; where that breaks the bounds of the points by QR on those that are not at
/// a bound, exchanged until the conditions of optimality hold. What is not linear goes to Ceres, in turn with
/// QR for the points alone, and may have several minima: of two starts the better end is taken, never worse
/// than the best evenly spaced curve.
///
/// \param targets  one a curve, each of a value a sample; with free_range all curves share the range
/// \throws vol::Error for no sample, points beyond kMostControlPoints, bounds without extent, a loss_scale
///         below 1e-12 of the largest target or beyond 1e-100 .. 1e100, smoothness beyond 0 .. 1e12; options
///         that exclude each other: free_range with parametric, bounds on the curve with a loss, a free range
///         or abscissae; bounds on the curve of a rank-deficient problem; numbers that Ceres cannot solve
[[nodiscard]] Fit fit_bezier(const Samples& samples, const std::vector<std::vector<double>>& targets,
                             const FitOptions& options);

/// The fit with the fewest points, up to options.points, whose curves all have an RMS of at most `error`.
/// \throws vol::Error where none has, saying what the last one leaves
[[nodiscard]] Fit fit_within(const Samples& samples, const std::vector<std::vector<double>>& targets,
                             const FitOptions& options, double error);

}  // namespace vol::fit
