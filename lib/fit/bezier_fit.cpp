#include "fit/bezier_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "fit/least_squares.h"

namespace vol::fit {
namespace {

using Targets = std::vector<std::vector<double>>;

/// A loss's scale below what rounding leaves of residuals would count noise alone; the square of one below
/// 1e-100, which Ceres divides by, is 0 before long.
void require_scale(const FitOptions& o, double largest_target) {
  constexpr double kRounding = 1e-12, kLeast = 1e-100, kMost = 1e100;
  if (o.loss == Loss::none) return;
  const double least = std::max(kLeast, kRounding * largest_target);
  if (o.loss_scale >= least && o.loss_scale <= kMost) return;
  char text[120];
  std::snprintf(text, sizeof text,
                "the scale of the loss: %.3g to %.3g is possible for this target, not %.3g", least, kMost,
                o.loss_scale);
  throw Error(text);
}

void require_possible(const Samples& samples, const Targets& targets, const FitOptions& o) {
  if (samples.v.empty() || targets.empty()) throw Error("there is nothing to fit to: no samples");
  if (o.points < 1 || o.points > transfer::kMostControlPoints) {
    throw Error("1 to " + std::to_string(transfer::kMostControlPoints) +
                " control points are possible, not " + std::to_string(o.points));
  }
  if (o.bounds != Bounds::none && !(o.least < o.most))
    throw Error("bounds: the lower must be below the upper");
  if (o.free_range && o.parametric) throw Error("a free range and free abscissae exclude each other");
  if (o.parametric && o.points < 2)
    throw Error("a curve with abscissae of its own has at least 2 control points");
  if (!(o.smoothness >= 0) || o.smoothness > 1e12) throw Error("smoothness: 0 to 1e12 is possible");
  if (o.bounds == Bounds::curve && (o.loss != Loss::none || o.free_range || o.parametric)) {
    throw Error(
        "bounds on the curve alone are for the linear problem: no loss, free range or free abscissae");
  }
  double largest = 0;
  for (const auto& target : targets) {
    for (const double t : target) {
      if (!(std::abs(t) <= 1e30)) throw Error("the target is not finite, or beyond 1e30");
      largest = std::max(largest, std::abs(t));
    }
  }
  require_scale(o, largest);
}

bool within(const Eigen::VectorXd& p, const FitOptions& o) {
  return o.bounds == Bounds::none || (p.minCoeff() >= o.least && p.maxCoeff() <= o.most);
}

/// Within the bounds of the points, where these are bound.
Eigen::VectorXd made_feasible(Eigen::VectorXd p, const FitOptions& o) {
  if (o.bounds == Bounds::points) p = p.cwiseMax(o.least).cwiseMin(o.most);
  return p;
}

struct Linear {
  Eigen::VectorXd points;
  int rank = 0;
  double condition = 0;
  const char* method = "qr";
};

/// The linear problem with its bounds; t are the parameters of the samples.
Linear solve_linear(const Samples& samples, std::span<const double> t, std::span<const double> target,
                    const FitOptions& o) {
  const Triangle problem = triangle(design_matrix(samples, t, o), right_hand_side(samples, target, o));
  const LinearSolution free = solve(problem);
  Linear linear{free.points, free.rank, free.condition, "qr"};
  if (within(free.points, o)) return linear;
  if (o.bounds == Bounds::curve) {
    if (free.rank < o.points) {
      throw Error("bounds on the curve need a full-rank problem, this one has rank " +
                  std::to_string(free.rank) + " of " + std::to_string(o.points) +
                  "; fewer points, or some smoothness");
    }
    linear.points = solve_curve_bounded(problem, o.least, o.most);
    linear.method = "exchange";
    return linear;
  }
  linear.points = made_feasible(free.points, o);
  linear.method = "active-set";
  if (!solve_bounded(problem, o.least, o.most, linear.points)) {
    throw Error("the exchange of points at their bounds does not end; fewer points, or other bounds");
  }
  return linear;
}

/// v as a range {a, s} makes it of the sample's own.
Samples rescaled(const Samples& samples, double a, double s) {
  Samples moved = samples;
  for (double& v : moved.v) v = std::clamp((v - a) / s, 0.0, 1.0);
  const double extent = samples.range.max - samples.range.min;
  moved.range = {samples.range.min + a * extent, samples.range.min + (a + s) * extent};
  return moved;
}

/// Where no target changes any more toward either end: what a clamped range holds of itself.
Eigen::VectorXd range_of_change(const Samples& samples, const Targets& targets) {
  const std::size_t n = samples.v.size();
  std::size_t first = n - 1, last = 0;
  for (const auto& target : targets) {
    std::size_t f = 0, l = n - 1;
    while (f + 1 < n && target[f + 1] == target.front()) ++f;
    while (l > 0 && target[l - 1] == target.back()) --l;
    first = std::min(first, f);
    last = std::max(last, l);
  }
  const double lo = samples.v[first], extent = std::max(0.02, samples.v[last] - lo);
  return Eigen::Vector2d(std::clamp(lo, -1.0, 0.98), std::min(extent, 3.0));
}

/// Increments that put the abscissae where the target changes: quantiles of half an even spread, half its
/// variation.
Eigen::VectorXd increments_of_change(const Samples& samples, std::span<const double> target, int points) {
  const std::size_t n = samples.v.size();
  std::vector<double> spread(n, 0);  // from 0 to 1 over the samples
  double variation = 0;
  for (std::size_t j = 1; j < n; ++j) variation += std::abs(target[j] - target[j - 1]);
  double part = 0;
  for (std::size_t j = 1; j < n; ++j) {
    part += std::abs(target[j] - target[j - 1]);
    spread[j] = 0.5 * samples.v[j] + 0.5 * (variation > 0 ? part / variation : samples.v[j]);
  }
  Eigen::VectorXd increments(points - 1);
  double before = 0;
  for (int k = 1; k < points; ++k) {
    const double wanted = static_cast<double>(k) / (points - 1);
    const auto at = std::lower_bound(spread.begin(), spread.end(), wanted);
    const double x =
        k == points - 1 || at == spread.end() ? 1 : samples.v[static_cast<std::size_t>(at - spread.begin())];
    increments[k - 1] = std::clamp((points - 1) * (x - before), 0.02, 50.0);
    before = x;
  }
  return increments;
}

/// The samples as a range moves them, and their parameters on curves with these abscissae.
struct Placed {
  Samples samples;
  std::vector<double> t;
};

Placed placed(const Samples& samples, const FitOptions& o, const Eigen::VectorXd& rest) {
  Placed p{o.free_range ? rescaled(samples, rest[0], rest[1]) : samples, {}};
  p.t = p.samples.v;
  if (o.parametric) {
    const transfer::BezierCurve places(std::vector<double>(static_cast<std::size_t>(o.points), 0.0),
                                       abscissae_of(rest));
    for (double& place : p.t) place = places.parameter(place);
  }
  return p;
}

/// d loss/d r^2: what a square counts for that has the loss's slope (Holland & Welsch 1977).
double share(double r, const FitOptions& o) {
  const double a = o.loss_scale;
  if (o.loss == Loss::huber) return std::abs(r) <= a ? 1 : a / std::abs(r);
  if (o.loss == Loss::cauchy) {
    const double x = r / a;  // before it is squared: a a may be 0
    return 1 / (1 + x * x);
  }
  return 1;
}

/// The best points for this range or these abscissae, under a loss the best for squares that count as it does
/// where the residuals are: no worse than before, because both losses are concave in the square.
Eigen::VectorXd solve_again(const Placed& at, std::span<const double> target, const FitOptions& o,
                            const Eigen::VectorXd& points) {
  Samples counted = at.samples;
  double sum = 0;
  for (std::size_t j = 0; j < at.t.size(); ++j) {
    const double q = o.quantity == Quantity::emission ? at.samples.v[j] : 1;
    const std::span<const double> p(points.data(), static_cast<std::size_t>(points.size()));
    counted.weight[j] *= share(q * transfer::de_casteljau(p, at.t[j]).value - target[j], o);
    sum += counted.weight[j];
  }
  if (!(sum > 0)) throw Error("to this loss all samples are outliers; a larger scale of it is needed");
  return solve_linear(counted, at.t, target, o).points;
}

/// A start's own points by QR; then all unknowns by Ceres and the points by QR in turn, as long as that
/// helps: Ceres cuts its steps at the bounds and may stop where points should leave them, the exchanges of
/// solve_bounded() do not.
Nonlinear from(const Samples& samples, const Targets& targets, const FitOptions& o,
               const Eigen::VectorXd& rest) {
  Nonlinear state{{}, rest, 0, 0};
  Placed at = placed(samples, o, rest);
  for (const auto& target : targets) state.points.push_back(solve_linear(at.samples, at.t, target, o).points);
  improve(samples, targets, o, state);
  const int most_turns =
      o.parametric ? 3 : 50;  // a turn of a parametric curve solves for its parameters again and again
  for (int turn = 0; turn < most_turns; ++turn) {
    const double before = state.cost;
    at = placed(samples, o, state.rest);
    for (std::size_t c = 0; c < targets.size(); ++c) {
      state.points[c] = solve_again(at, targets[c], o, made_feasible(state.points[c], o));
    }
    improve(samples, targets, o, state);
    if (!(state.cost < before * (1 - 1e-9))) break;
  }
  for (auto& points : state.points) points = made_feasible(points, o);
  return state;
}

Nonlinear best_of(const Samples& samples, const Targets& targets, const FitOptions& o) {
  std::vector<Eigen::VectorXd> starts;
  if (o.free_range) {
    starts = {Eigen::Vector2d(0, 1), range_of_change(samples, targets)};
  } else if (o.parametric) {
    starts = {Eigen::VectorXd::Ones(o.points - 1), increments_of_change(samples, targets.front(), o.points)};
  } else {
    starts = {Eigen::VectorXd()};
  }
  Nonlinear best;
  int iterations = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    Nonlinear end = from(samples, targets, o, starts[i]);
    iterations += end.iterations;
    if (i == 0 || end.cost < best.cost) best = std::move(end);
  }
  best.iterations = iterations;
  return best;
}

Residual residual_of(const Samples& samples, std::span<const double> target,
                     const transfer::BezierCurve& curve, const FitOptions& o) {
  Residual residual;
  double sum = 0;
  for (std::size_t j = 0; j < samples.v.size(); ++j) {
    const double q = o.quantity == Quantity::emission ? samples.v[j] : 1;
    const double off = std::abs(q * curve.value(samples.v[j]) - target[j]);
    sum += samples.weight[j] * off * off;
    residual.largest = std::max(residual.largest, off);
  }
  residual.rms = std::sqrt(sum);
  return residual;
}

std::vector<double> listed(const Eigen::VectorXd& p) {
  return {p.begin(), p.end()};
}

void add_curve(Fit& fit, const Samples& samples, std::span<const double> target, transfer::BezierCurve curve,
               const FitOptions& o) {
  fit.residuals.push_back(residual_of(samples, target, curve, o));
  fit.curves.push_back(std::move(curve));
}

void note_matrix(Fit& fit, const Samples& samples, std::span<const double> t, const FitOptions& o) {
  const Eigen::MatrixXd a = design_matrix(samples, t, o);
  const LinearSolution matrix = solve(triangle(a, Eigen::VectorXd::Zero(a.rows())));
  fit.rank = fit.curves.size() > 1 ? std::min(fit.rank, matrix.rank) : matrix.rank;
  fit.condition = std::max(fit.condition, matrix.condition);
}

Fit fit_linear(const Samples& samples, const Targets& targets, const FitOptions& o) {
  Fit fit;
  fit.range = samples.range;
  fit.method = "qr";
  for (const auto& target : targets) {
    const Linear linear = solve_linear(samples, samples.v, target, o);
    if (std::string(linear.method) != "qr") fit.method = linear.method;
    fit.rank = linear.rank;
    fit.condition = linear.condition;
    add_curve(fit, samples, target, transfer::BezierCurve(listed(linear.points)), o);
  }
  return fit;
}

/// Of curves that share nothing each for itself, of those that share the range all together.
Fit fit_nonlinear(const Samples& samples, const Targets& targets, const FitOptions& o) {
  Fit fit;
  fit.method = "ceres";
  fit.range = samples.range;
  if (o.free_range) {
    const Nonlinear end = best_of(samples, targets, o);
    const Samples moved = rescaled(samples, end.rest[0], end.rest[1]);
    fit.range = moved.range;
    fit.iterations = end.iterations;
    for (std::size_t c = 0; c < targets.size(); ++c) {
      add_curve(fit, moved, targets[c], transfer::BezierCurve(listed(end.points[c])), o);
    }
    note_matrix(fit, moved, moved.v, o);
    return fit;
  }
  for (const auto& target : targets) {
    const Nonlinear end = best_of(samples, {target}, o);
    fit.iterations += end.iterations;
    std::vector<double> t = samples.v;
    if (o.parametric) {
      add_curve(fit, samples, target, transfer::BezierCurve(listed(end.points[0]), abscissae_of(end.rest)),
                o);
      for (double& place : t) place = fit.curves.back().parameter(place);
    } else {
      add_curve(fit, samples, target, transfer::BezierCurve(listed(end.points[0])), o);
    }
    note_matrix(fit, samples, t, o);
  }
  return fit;
}

}  // namespace

Fit fit_bezier(const Samples& samples, const std::vector<std::vector<double>>& targets,
               const FitOptions& options) {
  require_possible(samples, targets, options);
  const bool nonlinear = options.loss != Loss::none || options.free_range || options.parametric;
  return nonlinear ? fit_nonlinear(samples, targets, options) : fit_linear(samples, targets, options);
}

Fit fit_within(const Samples& samples, const std::vector<std::vector<double>>& targets,
               const FitOptions& options, double error) {
  require_possible(samples, targets, options);
  FitOptions o = options;
  double left = 0;
  for (o.points = options.parametric ? 2 : 1; o.points <= options.points; ++o.points) {
    Fit fit = fit_bezier(samples, targets, o);
    left = 0;
    for (const auto& residual : fit.residuals) left = std::max(left, residual.rms);
    if (left <= error) return fit;
  }
  char text[120];
  std::snprintf(text, sizeof text, "%d control points leave an RMS of %.3g, more than the %.3g asked for",
                options.points, left, error);
  throw Error(text);
}

}  // namespace vol::fit
