#include <gtest/gtest.h>

#include "base/error.h"
#include "curves.h"

namespace vol::fit {
namespace {

using namespace fit_test;

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

/// Of the matrix itself, not of the fit's triangle.
double condition_of(const Eigen::MatrixXd& a) {
  const Eigen::VectorXd singular = Eigen::BDCSVD<Eigen::MatrixXd>(a).singularValues();
  return singular[0] / singular[singular.size() - 1];
}

// A curve that is itself Bezier of N points comes back. The matrix has a condition of about sqrt(C(2N-1,
// N-1)), 2e4 for N = 16 and 5e5 for 21, which times eps, 2e-16, and the roundings of a few hundred sums makes
// 1e-10 and 1e-9.
TEST(Recovery, ControlPointsOfABezierCurveComeBack) {
  Rng rng(7);
  const Samples samples = uniform_samples({-3, 40}, 1024);
  for (int n = 1; n <= transfer::kMostControlPoints; ++n) {
    for (const auto quantity : {Quantity::weight, Quantity::emission}) {
      const auto points = random_points(rng, n);
      auto target = on_curve(samples, points);
      if (quantity == Quantity::emission) {
        for (std::size_t j = 0; j < target.size(); ++j) target[j] *= samples.v[j];
      }
      FitOptions o;
      o.points = n;
      o.quantity = quantity;
      const Fit fit = fit_bezier(samples, {target}, o);
      EXPECT_LT(largest_difference(fit.curves[0].ordinates(), points), n <= 16 ? 1e-10 : 1e-9) << n;
      EXPECT_EQ(fit.rank, n);
      EXPECT_LT(fit.residuals[0].largest, 1e-12) << n;
    }
  }
}

// Weights of a histogram may be so uneven that the points themselves are lost; the curve is not, where it
// counts.
TEST(Recovery, WithAHistogramTheWeightedCurveComesBack) {
  Rng rng(11);
  for (const int n : {1, 2, 6, 11, 16, 21}) {
    Samples samples = uniform_samples({0, 1}, 700);
    double sum = 0;
    for (std::size_t j = 0; j < samples.v.size(); ++j) {
      // Air, two tissues and a little of everything, over six orders of magnitude.
      const auto peak = [&](double at, double width) {
        return std::exp(-std::pow((samples.v[j] - at) / width, 2));
      };
      samples.weight[j] = 1e6 * peak(0.02, 0.02) + 1e4 * peak(0.3, 0.05) + 1e3 * peak(0.45, 0.1) + 1;
      sum += samples.weight[j];
    }
    for (double& w : samples.weight) w /= sum;
    const auto points = random_points(rng, n);
    FitOptions o;
    o.points = n;
    const auto target = on_curve(samples, points);
    const Fit fit = fit_bezier(samples, {target}, o);
    EXPECT_LE(largest_difference(fit.curves[0].ordinates(), points),
              100 * condition_of(written_out(samples, n)) * 2.3e-16 + 1e-14)
        << n;
    EXPECT_LT(fit.residuals[0].rms, 1e-12) << n;
  }
}

// Against Eigen's SVD of the matrix written out: another basis evaluation, another decomposition.
TEST(Recovery, UnconstrainedFitsAreTheWeightedLeastSquaresSolution) {
  Rng rng(5);
  for (const int n : {1, 3, 8, 14}) {
    Samples samples = uniform_samples({0, 10}, 200);
    for (double& w : samples.weight) w *= rng.uniform(0.1, 1.9);
    std::vector<double> target;
    for (const double v : samples.v) target.push_back(stepped(v));
    FitOptions o;
    o.points = n;
    o.bounds = Bounds::none;
    const Fit fit = fit_bezier(samples, {target}, o);
    const Eigen::MatrixXd a = written_out(samples, n);
    const Eigen::BDCSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Eigen::VectorXd truth = svd.solve(weighted(samples, target));
    const double condition = condition_of(a);
    EXPECT_NEAR(fit.condition / condition, 1, 1e-6) << n;
    // Sensitivity of a least squares solution with a residual: up to condition^2 eps.
    const double tolerance = 1e-12 + 10 * condition * condition * 2.3e-16;
    for (int i = 0; i < n; ++i)
      EXPECT_NEAR(fit.curves[0].ordinates()[static_cast<std::size_t>(i)], truth[i], tolerance);
  }
}

// More points than values that occur: the shortest of all solutions.
TEST(Recovery, ADeficientRankGivesTheShortestSolution) {
  Samples samples;
  samples.range = {0, 1};
  samples.v = {0.2, 0.5, 0.9};
  samples.weight = {0.5, 0.25, 0.25};
  const std::vector<double> target{1, 0.5, 0.7};
  FitOptions o;
  o.points = 6;
  o.bounds = Bounds::none;
  const Fit fit = fit_bezier(samples, {target}, o);
  EXPECT_EQ(fit.rank, 3);
  EXPECT_LT(fit.residuals[0].largest, 1e-13);
  const Eigen::MatrixXd a = written_out(samples, 6);
  const Eigen::VectorXd shortest =
      a.completeOrthogonalDecomposition().pseudoInverse() * weighted(samples, target);
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(fit.curves[0].ordinates()[static_cast<std::size_t>(i)], shortest[i], 1e-12);
}

// A curve of few points is a curve of more, so the fewest that suffice are found; and none where none does.
TEST(Recovery, TheFewestPointsThatSuffice) {
  Rng rng(3);
  const Samples samples = uniform_samples({0, 1}, 300);
  FitOptions o;
  o.points = 21;
  for (const int n : {1, 4, 9}) {
    const auto target = on_curve(samples, random_points(rng, n));
    EXPECT_EQ(fit_within(samples, {target}, o, 1e-10).curves[0].ordinates().size(),
              static_cast<std::size_t>(n));
  }
  std::vector<double> step;
  for (const double v : samples.v) step.push_back(stepped(v));
  EXPECT_THROW((void)fit_within(samples, {step}, o, 1e-3), Error);
  double last = 10;
  for (o.points = 1; o.points <= 21; ++o.points) {
    const double rms = fit_bezier(samples, {step}, o).residuals[0].rms;
    EXPECT_LE(rms, last + 1e-12) << o.points;  // spaces within spaces, bounds and all
    last = rms;
  }
}

TEST(Recovery, SeveralCurvesAreFittedEachAsAlone) {
  const Samples samples = uniform_samples({0, 1}, 100);
  std::vector<double> first, second;
  for (const double v : samples.v) {
    first.push_back(stepped(v));
    second.push_back(v > 0.8);
  }
  const FitOptions o;
  const Fit both = fit_bezier(samples, {first, second}, o);
  EXPECT_EQ(both.curves[0].ordinates(), fit_bezier(samples, {first}, o).curves[0].ordinates());
  EXPECT_EQ(both.curves[1].ordinates(), fit_bezier(samples, {second}, o).curves[0].ordinates());
}

TEST(Recovery, WhatCannotBeFittedIsRefused) {
  const Samples samples = uniform_samples({0, 1}, 10);
  const std::vector<double> target(10, 1.0);
  FitOptions o;
  o.points = 22;
  EXPECT_THROW((void)fit_bezier(samples, {target}, o), Error);
  o.points = 0;
  EXPECT_THROW((void)fit_bezier(samples, {target}, o), Error);
  o.points = 4;
  EXPECT_THROW((void)fit_bezier({}, {{}}, o), Error);
  EXPECT_THROW((void)fit_bezier(samples, {std::vector<double>(10, std::nan(""))}, o), Error);
  o.least = 2;
  EXPECT_THROW((void)fit_bezier(samples, {target}, o), Error);
  o.least = 0;
  o.smoothness = std::nan("");
  EXPECT_THROW((void)fit_bezier(samples, {target}, o), Error);
  o.smoothness = 0;
  o.free_range = o.parametric = true;
  EXPECT_THROW((void)fit_bezier(samples, {target}, o), Error);
}

// Also where no number of points is tried.
TEST(Recovery, TheFewestPointsAreRefusedForWhatIsWrong) {
  const Samples samples = uniform_samples({0, 1}, 10);
  FitOptions o;
  o.parametric = true;
  o.points = 1;
  try {
    (void)fit_within(samples, {std::vector<double>(10, 1.0)}, o, 1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("abscissae"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vol::fit
