#include <gtest/gtest.h>

#include "base/error.h"
#include "curves.h"

namespace vol::fit {
namespace {

using namespace fit_test;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// min ||A p - b|| within bounds, by trying every choice of which points are at which bound.
VectorXd by_all_choices(const MatrixXd& a, const VectorXd& b, double least, double most) {
  const int n = static_cast<int>(a.cols());
  int choices = 1;
  for (int i = 0; i < n; ++i) choices *= 3;
  VectorXd best;
  double best_cost = 1e300;
  for (int choice = 0; choice < choices; ++choice) {
    VectorXd p = VectorXd::Zero(n);
    std::vector<int> free;
    for (int i = 0, c = choice; i < n; ++i, c /= 3) {
      if (c % 3 == 0) free.push_back(i);
      if (c % 3 == 1) p[i] = least;
      if (c % 3 == 2) p[i] = most;
    }
    if (!free.empty()) {
      MatrixXd columns(a.rows(), static_cast<Eigen::Index>(free.size()));
      for (std::size_t k = 0; k < free.size(); ++k)
        columns.col(static_cast<Eigen::Index>(k)) = a.col(free[k]);
      const VectorXd z = columns.householderQr().solve(b - a * p);
      for (std::size_t k = 0; k < free.size(); ++k) p[free[k]] = z[static_cast<Eigen::Index>(k)];
    }
    if (p.minCoeff() < least || p.maxCoeff() > most) continue;
    const double cost = (a * p - b).squaredNorm();
    if (cost < best_cost) {
      best_cost = cost;
      best = p;
    }
  }
  return best;
}

std::vector<double> random_target(const Samples& samples, Rng& rng) {
  const double a = rng.uniform(0.1, 0.5), b = rng.uniform(0.5, 0.9), height = rng.uniform(0.5, 3);
  std::vector<double> target;
  for (const double v : samples.v) target.push_back(v < a ? 0 : v < b ? height : 0.3 * v);
  return target;
}

TEST(Bounds, OfThePointsAgreeWithTryingAllChoices) {
  Rng rng(17);
  const Samples samples = uniform_samples({0, 1}, 120);
  int bounded = 0;
  for (int trial = 0; trial < 40; ++trial) {
    FitOptions o;
    o.points = 2 + static_cast<int>(rng.below(5));
    o.most = rng.uniform(0.5, 2);
    const auto target = random_target(samples, rng);
    const Fit fit = fit_bezier(samples, {target}, o);
    const VectorXd truth =
        by_all_choices(written_out(samples, o.points), weighted(samples, target), o.least, o.most);
    for (int i = 0; i < o.points; ++i) {
      EXPECT_NEAR(fit.curves[0].ordinates()[static_cast<std::size_t>(i)], truth[i], 1e-9) << trial;
    }
    if (fit.method != "qr") ++bounded;
  }
  EXPECT_GT(bounded, 20);
}

// The conditions of Karush, Kuhn and Tucker, from the matrix written out: no slope where a point is free, at
// a bound none that leads inward. Their size is rounding of sums of products below 2, and no condition number
// enters.
TEST(Bounds, OfThePointsSatisfyTheOptimalityConditions) {
  Rng rng(23);
  const Samples samples = uniform_samples({0, 1}, 400);
  for (int n = 2; n <= 21; ++n) {
    for (int trial = 0; trial < 3; ++trial) {
      FitOptions o;
      o.points = n;
      o.most = rng.uniform(0.5, 2);
      const auto target = random_target(samples, rng);
      const Fit fit = fit_bezier(samples, {target}, o);
      const VectorXd p = Eigen::Map<const VectorXd>(fit.curves[0].ordinates().data(), n);
      const MatrixXd a = written_out(samples, n);
      const VectorXd gradient = a.transpose() * (a * p - weighted(samples, target));
      for (int i = 0; i < n; ++i) {
        ASSERT_GE(p[i], o.least);
        ASSERT_LE(p[i], o.most);
        EXPECT_LT(p[i] > o.least ? gradient[i] : 0, 1e-13) << n << " " << i;
        EXPECT_GT(p[i] < o.most ? gradient[i] : 0, -1e-13) << n << " " << i;
      }
    }
  }
}

// Where a curve touches a bound, ends included, and whether it is the upper one: extremes found by the sign
// of the slope, bisected.
std::vector<std::pair<double, bool>> touches(const transfer::BezierCurve& curve, double least, double most) {
  std::vector<double> places = {0, 1};
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    double lo = double(i) / kSteps, hi = double(i + 1) / kSteps;
    const bool rises = curve.at(lo).slope > 0;
    if (rises == (curve.at(hi).slope > 0)) continue;
    for (int halving = 0; halving < 45; ++halving) {
      const double middle = 0.5 * (lo + hi);
      ((curve.at(middle).slope > 0) == rises ? lo : hi) = middle;
    }
    places.push_back(lo);
  }
  std::vector<std::pair<double, bool>> found;
  for (const double place : places) {
    const double value = curve.value(place);
    if (std::abs(value - least) < 1e-7) found.emplace_back(place, false);
    if (std::abs(value - most) < 1e-7) found.emplace_back(place, true);
  }
  return found;
}

// Only the curve bounded: it keeps its bounds, comes nearer than with bounded points, and not as near as
// without; and it is optimal: no step toward any other curve within the bounds comes nearer (the problem is
// convex).
TEST(Bounds, OfTheCurveAloneAreKeptAndOptimal) {
  Rng rng(29);
  const Samples samples = uniform_samples({0, 1}, 300);
  for (const int n : {3, 6, 10, 14}) {
    FitOptions o;
    o.points = n;
    o.most = 1.2;
    const auto target = random_target(samples, rng);
    const auto rms = [&](Bounds bounds) {
      o.bounds = bounds;
      return fit_bezier(samples, {target}, o).residuals[0].rms;
    };
    const double free = rms(Bounds::none), points = rms(Bounds::points), curve = rms(Bounds::curve);
    EXPECT_LE(free, curve + 1e-12) << n;
    EXPECT_LE(curve, points + 1e-9) << n;
    const Fit fit = fit_bezier(samples, {target}, o);
    double lowest = 10, highest = -10;
    for (int i = 0; i <= 5000; ++i) {
      const double value = fit.curves[0].value(i / 5000.0);
      lowest = std::min(lowest, value);
      highest = std::max(highest, value);
    }
    EXPECT_GE(lowest, o.least - 1e-8) << n;  // kept to 1e-9, and rounding
    EXPECT_LE(highest, o.most + 1e-8) << n;
    const VectorXd p = Eigen::Map<const VectorXd>(fit.curves[0].ordinates().data(), n);
    const MatrixXd a = written_out(samples, n);
    const VectorXd gradient = a.transpose() * (a * p - weighted(samples, target));
    for (int other = 0; other < 200; ++other) {
      const auto q = random_points(rng, n, o.least, o.most);  // within the bounds, and so its curve
      EXPECT_GT(gradient.dot(Eigen::Map<const VectorXd>(q.data(), n) - p), -1e-7) << n;
    }
    // Karush, Kuhn and Tucker: the pull is balanced by the bounds that are touched, each pushing inwards.
    const auto touched = touches(fit.curves[0], o.least, o.most);
    ASSERT_GT(touched.size(), 0U) << n;
    MatrixXd push(n, static_cast<Eigen::Index>(touched.size()));
    std::vector<double> basis(static_cast<std::size_t>(n));
    for (std::size_t k = 0; k < touched.size(); ++k) {
      transfer::bernstein_basis(touched[k].first, basis);
      push.col(static_cast<Eigen::Index>(k)) =
          (touched[k].second ? -1 : 1) * Eigen::Map<const VectorXd>(basis.data(), n);
    }
    const VectorXd multipliers = push.colPivHouseholderQr().solve(gradient);
    // A bound kept to 1e-9 leaves the place of the touch uncertain by the root of it.
    EXPECT_LT((push * multipliers - gradient).norm(), 2 * std::sqrt(1e-9) * gradient.norm()) << n;
    EXPECT_GE(multipliers.minCoeff(), 0) << n;
  }
}

// The problem is as large as its numbers: target and bounds times s make the curve times s. The curve may
// leave its bounds by 1e-9 of their extent, and the points, by which a curve of 12 points is reached with a
// condition of about 1e3, differ by as much more; what it misses hardly does.
TEST(Bounds, OfTheCurveScaleWithTheTarget) {
  const Samples samples = uniform_samples({0, 1}, 200);
  for (const int n : {6, 12}) {
    const auto rms = [&](double s, double most) {
      FitOptions o;
      o.points = n;
      o.bounds = Bounds::curve;
      o.most = most;
      std::vector<double> target;
      for (const double v : samples.v) target.push_back(s * stepped(v));
      const Fit fit = fit_bezier(samples, {target}, o);
      double out = 0;
      for (int i = 0; i <= 5000; ++i) {
        const double value = fit.curves[0].value(i / 5000.0);
        out = std::max({out, o.least - value, value - o.most});
      }
      EXPECT_EQ(fit.method, "exchange") << n << " " << s;
      EXPECT_LE(out / s, 1e-8) << n << " " << s;
      return fit.residuals[0].rms / s;
    };
    const double once = rms(1, 1.2);
    for (const double s : {1e-8, 1e-4, 1e4, 1e8}) EXPECT_NEAR(rms(s, 1.2 * s), once, 1e-7) << n << " " << s;
    const double wide = rms(1, 10);  // the lower bound alone is in the way
    EXPECT_NEAR(rms(1, 1e10), wide, 1e-7) << n;
  }
}

TEST(Bounds, OfTheCurveNeedAProblemOfFullRank) {
  Samples samples;
  samples.range = {0, 1};
  samples.v = {0.1, 0.6};
  samples.weight = {0.5, 0.5};
  FitOptions o;
  o.points = 5;
  o.bounds = Bounds::curve;
  o.most = 0.5;
  EXPECT_THROW((void)fit_bezier(samples, {{0, 3}}, o), Error);
}

TEST(Bounds, SmoothnessFlattensThePoints) {
  const Samples samples = uniform_samples({0, 1}, 300);
  std::vector<double> target;
  for (const double v : samples.v) target.push_back(stepped(v));
  const auto bend = [&](double smoothness) {
    FitOptions o;
    o.points = 10;
    o.smoothness = smoothness;
    const auto p = fit_bezier(samples, {target}, o).curves[0].ordinates();
    double sum = 0;
    for (std::size_t i = 0; i + 2 < p.size(); ++i) sum += std::pow(p[i] - 2 * p[i + 1] + p[i + 2], 2);
    return sum;
  };
  EXPECT_LT(bend(1e-3), bend(0));
  EXPECT_LT(bend(1), bend(1e-3));
  EXPECT_LT(bend(1e9), 1e-12);  // a line
}

}  // namespace
}  // namespace vol::fit
