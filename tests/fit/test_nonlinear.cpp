#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.h"
#include "curves.h"
#include "fit/cost_functions.h"

namespace vol::fit {
namespace {

using namespace fit_test;

/// By how much derivatives are off at most, in parts of the largest of their block: Ceres' own check, against
/// Ridders' differences.
double wrong_by(const ceres::CostFunction& cost, const std::vector<std::vector<double>>& blocks) {
  const std::vector<const ceres::Manifold*> manifolds(blocks.size(), nullptr);
  ceres::NumericDiffOptions options;
  options.ridders_relative_initial_step_size = 1e-3;
  const ceres::GradientChecker checker(&cost, &manifolds, options);
  std::vector<const double*> parameters;
  for (const auto& block : blocks) parameters.push_back(block.data());
  ceres::GradientChecker::ProbeResults results;
  (void)checker.Probe(parameters.data(), 1e-7, &results);
  EXPECT_TRUE(results.return_value) << results.error_log;
  double worst = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const double largest = results.numeric_jacobians[b].cwiseAbs().maxCoeff(),
                 off = (results.jacobians[b] - results.numeric_jacobians[b]).cwiseAbs().maxCoeff();
    worst = std::max(worst, off / (largest + 1e-5));
  }
  return worst;
}

/// Those far below a block's largest, 1e-9 and less, are lost in the rounding of the residuals' differences.
constexpr double kRight = 1e-7;

void check(const ceres::CostFunction& cost, const std::vector<std::vector<double>>& blocks) {
  EXPECT_LE(wrong_by(cost, blocks), kRight)
      << blocks.size() << " blocks, of " << blocks[0].size() << " points";
}

/// Another cost with one of its derivatives wrong.
class WrongCost final : public ceres::CostFunction {
 public:
  WrongCost(const ceres::CostFunction& right, std::size_t block, std::size_t entry, double factor)
      : right_(right), block_(block), entry_(entry), factor_(factor) {
    set_num_residuals(right.num_residuals());
    *mutable_parameter_block_sizes() = right.parameter_block_sizes();
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    if (!right_.Evaluate(parameters, residuals, jacobians)) return false;
    if (jacobians && jacobians[block_]) jacobians[block_][entry_] *= factor_;
    return true;
  }

 private:
  const ceres::CostFunction& right_;
  std::size_t block_, entry_;
  double factor_;
};

TEST(Derivatives, AreThoseOfTheResiduals) {
  Rng rng(41);
  const Samples samples = uniform_samples({0, 1}, 23);
  std::vector<double> target;
  for (const double v : samples.v) target.push_back(stepped(v));
  const Samples apart{{0.02, 0.35, 0.5, 0.65, 0.98}, {0.2, 0.2, 0.2, 0.2, 0.2}, {0, 1}};
  for (const auto quantity : {Quantity::weight, Quantity::emission}) {
    for (const int n : {2, 3, 6, 12, 21}) {
      FitOptions o;
      o.points = n;
      o.quantity = quantity;
      const auto points = random_points(rng, n, -1, 2);
      check(CurveCost(samples, target, o, Unknowns::points, 0, 23, true), {points});
      check(CurveCost(samples, target, o, Unknowns::points, 7, 1, false), {points});
      // Samples below, within and above the range; none near an end, where there is a kink that differences
      // see.
      check(CurveCost(apart, target, o, Unknowns::range, 0, 5, true), {points, {0.2, 0.6}});
      check(CurveCost(samples, target, o, Unknowns::range, 0, 23, true), {points, {-0.21, 1.7}});
      check(CurveCost(samples, target, o, Unknowns::abscissae, 0, 23, true),
            {points, random_points(rng, n - 1, 0.8, 1.4)});
      if (n > 2) check(SmoothnessCost(n, 0.7), {points});
    }
  }
}

// The check sees what it is for: one derivative in each block that is off by a thousandth of itself.
TEST(Derivatives, AWrongOneIsCaught) {
  Rng rng(59);
  const Samples samples = uniform_samples({0, 1}, 23);
  const std::vector<double> target(23, 0.4);
  FitOptions o;
  o.points = 6;
  const auto points = random_points(rng, 6, 0.5, 2);
  for (const auto unknowns : {Unknowns::range, Unknowns::abscissae}) {
    const CurveCost right(samples, target, o, unknowns, 0, 23, true);
    const std::vector<std::vector<double>> blocks{points, unknowns == Unknowns::range
                                                              ? std::vector<double>{-0.21, 1.7}
                                                              : random_points(rng, 5, 0.8, 1.4)};
    check(right, blocks);
    for (std::size_t block = 0; block < 2; ++block) {
      const std::size_t entry = 11 * blocks[block].size();  // the first of the middle sample
      EXPECT_GT(wrong_by(WrongCost(right, block, entry, 1.001), blocks), kRight) << block;
    }
  }
}

// A curve over a part of the samples, constant outside, is its own best fit; the range it was drawn with is
// found.
TEST(FreeRange, IsFound) {
  Rng rng(43);
  const Samples samples = uniform_samples({100, 300}, 500);
  for (int trial = 0; trial < 5; ++trial) {
    const double lo = rng.uniform(110, 160), hi = rng.uniform(220, 290);
    const transfer::BezierCurve curve({0, 1.8, 0.1, 1.5, 0.9});
    const auto target = samples.targets([&](double f) { return curve.value((f - lo) / (hi - lo)); });
    FitOptions o;
    o.points = 5;
    const double fixed = fit_bezier(samples, {target}, o).residuals[0].rms;
    o.free_range = true;
    const Fit fit = fit_bezier(samples, {target}, o);
    EXPECT_NEAR(fit.range.min, lo, 1e-4) << trial;
    EXPECT_NEAR(fit.range.max, hi, 1e-4) << trial;
    EXPECT_LT(fit.residuals[0].rms, 1e-6);
    EXPECT_GT(fixed, 0.01);  // or the range would not matter
  }
}

TEST(Parametric, NeverWorseThanEvenPointsAndExactForItsOwnKind) {
  const Samples samples = uniform_samples({0, 1}, 400);
  FitOptions o;
  std::vector<double> step;
  for (const double v : samples.v) step.push_back(stepped(v));
  for (const int n : {2, 4, 7, 10}) {
    o.points = n;
    o.parametric = false;
    const double even = fit_bezier(samples, {step}, o).residuals[0].rms;
    o.parametric = true;
    const Fit fit = fit_bezier(samples, {step}, o);
    EXPECT_LE(fit.residuals[0].rms, even + 1e-9) << n;
    EXPECT_TRUE(fit.curves[0].parametric());
  }
  const transfer::BezierCurve curve({0, 0, 2, 0.5, 1}, {0, 0.4, 0.5, 0.55, 1});
  std::vector<double> target;
  for (const double v : samples.v) target.push_back(curve.value(v));
  o.points = 5;
  o.parametric = false;
  EXPECT_GT(fit_bezier(samples, {target}, o).residuals[0].rms, 1e-2);
  o.parametric = true;
  EXPECT_LT(fit_bezier(samples, {target}, o).residuals[0].rms, 1e-6);
}

// With bounds in the way: of the points found, none has a slope left but at a bound and outward. The turns
// end where one changes the cost, below 0.1 here, by less than 1e-9 of itself: with curvatures of at most 1
// that leaves slopes of sqrt(2 1e-10) = 1.4e-5, and all points together have less.
TEST(Loss, BoundedFitsSatisfyTheOptimalityConditions) {
  Rng rng(53);
  const Samples samples = uniform_samples({0, 1}, 200);
  for (int trial = 0; trial < 6; ++trial) {
    FitOptions o;
    o.points = 3 + 2 * trial;
    o.most = 1.1;
    o.loss = trial % 2 ? Loss::huber : Loss::cauchy;
    std::vector<double> target;
    for (const double v : samples.v) target.push_back(stepped(v) + 0.02 * rng.normal());
    const auto p = fit_bezier(samples, {target}, o).curves[0].ordinates();
    const transfer::BezierCurve curve(p);
    std::vector<double> gradient(p.size(), 0), basis(p.size());
    for (std::size_t j = 0; j < target.size(); ++j) {
      const double r = curve.value(samples.v[j]) - target[j], a = o.loss_scale;
      const double slope = o.loss == Loss::huber ? std::clamp(r, -a, a) : r / (1 + r * r / (a * a));
      transfer::bernstein_basis(samples.v[j], basis);
      for (std::size_t i = 0; i < p.size(); ++i) gradient[i] += samples.weight[j] * slope * basis[i];
    }
    for (std::size_t i = 0; i < p.size(); ++i) {
      EXPECT_LT(p[i] > o.least ? gradient[i] : 0, 1e-5) << o.points << " " << i;
      EXPECT_GT(p[i] < o.most ? gradient[i] : 0, -1e-5) << o.points << " " << i;
    }
  }
}

// A scale that nothing but rounding is below, and one whose square is 0, are refused; a small one is none of
// them.
TEST(Loss, ScalesBelowRoundingAreRefused) {
  const Samples samples = uniform_samples({0, 1}, 40);
  std::vector<double> target, far;
  for (const double v : samples.v) {
    target.push_back(stepped(v));
    far.push_back(1e20 * stepped(v));
  }
  for (const auto loss : {Loss::huber, Loss::cauchy}) {
    FitOptions o;
    o.loss = loss;
    for (const double scale : {1e-200, 1e-13, 1e200, 0.0, std::nan("")}) {
      o.loss_scale = scale;
      EXPECT_THROW((void)fit_bezier(samples, {target}, o), Error) << scale;
    }
    o.loss_scale = 1e-200;
    EXPECT_THROW((void)fit_bezier(samples, {std::vector<double>(40, 0.0)}, o), Error);
    o.loss_scale = 1e-6;
    EXPECT_THROW((void)fit_bezier(samples, {far}, o), Error);
    const Fit fit = fit_bezier(samples, {target}, o);
    EXPECT_TRUE(std::isfinite(fit.residuals[0].rms));
    EXPECT_LT(fit.residuals[0].rms, 2);
  }
}

// What Ceres cannot solve is an error of ours, and nothing that its logging writes itself.
TEST(Ceres, FailsInSilence) {
  const Samples samples = uniform_samples({0, 1}, 20);
  const std::vector<std::vector<double>> targets{
      std::vector<double>(20, std::nan(""))};  // fit_bezier() refuses it
  FitOptions o;
  o.points = 3;
  Nonlinear state{{Eigen::VectorXd::Zero(3)}, {}, 0, 0};
  testing::internal::CaptureStderr();
  std::string said;
  try {
    improve(samples, targets, o, state);
  } catch (const Error& error) {
    said = error.what();
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_NE(said.find("the fit fails"), std::string::npos) << said;
}

// Some samples far off: the squares follow them, the robust losses hardly do.
TEST(Loss, OutliersCountLess) {
  Rng rng(47);
  const Samples samples = uniform_samples({0, 1}, 300);
  const std::vector<double> points{0.2, 1.5, 0.3, 1, 0.6};
  const transfer::BezierCurve curve(points);
  auto target = on_curve(samples, points);
  for (std::size_t j = 0; j < target.size(); j += 10) target[j] += 5;
  FitOptions o;
  o.points = 5;
  o.loss_scale = 0.05;
  const auto off = [&](Loss loss) {
    o.loss = loss;
    const auto fitted = fit_bezier(samples, {target}, o).curves[0];
    double most = 0;
    for (const double v : samples.v) most = std::max(most, std::abs(fitted.value(v) - curve.value(v)));
    return most;
  };
  const double squares = off(Loss::none), huber = off(Loss::huber), cauchy = off(Loss::cauchy);
  EXPECT_GT(squares, 0.2);
  EXPECT_LT(huber, 0.1 * squares);
  EXPECT_LT(cauchy, 0.02 * squares);
}

}  // namespace
}  // namespace vol::fit
