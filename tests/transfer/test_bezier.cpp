#include <gtest/gtest.h>

#include "base/error.h"
#include "base/rng.h"
#include "transfer/bezier.h"
#include "transfer/profile.h"

namespace vol::transfer {
namespace {

std::vector<double> random_points(Rng& rng, int n) {
  std::vector<double> points;
  for (int i = 0; i < n; ++i) points.push_back(rng.uniform(-1, 2));
  return points;
}

/// sum_i C(n-1, i) (1-t)^(n-1-i) t^i P_i as it is written, and its derivative by the products' rule, in long
/// double.
ValueAndSlope written_out(const std::vector<double>& p, double t) {
  const int degree = static_cast<int>(p.size()) - 1;
  long double value = 0, slope = 0, binomial = 1;
  const auto power = [](long double base, int k) {
    return k < 0 ? 0.0L : std::pow(base, static_cast<long double>(k));
  };
  for (int i = 0; i <= degree; ++i) {
    const long double term = binomial * p[static_cast<std::size_t>(i)];
    value += term * power(1 - static_cast<long double>(t), degree - i) * power(t, i);
    slope += term * (i * power(1 - static_cast<long double>(t), degree - i) * power(t, i - 1) -
                     (degree - i) * power(1 - static_cast<long double>(t), degree - i - 1) * power(t, i));
    binomial = binomial * (degree - i) / (i + 1);
  }
  return {static_cast<double>(value), static_cast<double>(slope)};
}

TEST(Bezier, IsTheSumOfBernsteinPolynomials) {
  Rng rng(1);
  for (int n = 1; n <= kMostControlPoints; ++n) {
    for (int trial = 0; trial < 20; ++trial) {
      const auto p = random_points(rng, n);
      const double t = trial == 0 ? 0 : trial == 1 ? 1 : rng.uniform();
      const auto truth = written_out(p, t);
      // Every mean rounds once, of values up to 2; the slope is n - 1 times a difference of such.
      EXPECT_NEAR(BezierCurve(p).value(t), truth.value, 2 * n * 2.3e-16);
      EXPECT_NEAR(BezierCurve(p).at(t).slope, truth.slope, 8 * n * n * 2.3e-16);
      std::vector<double> basis(static_cast<std::size_t>(n));
      bernstein_basis(t, basis);
      double sum = 0, one = 0;
      for (std::size_t i = 0; i < basis.size(); ++i) {
        sum += basis[i] * p[i];
        one += basis[i];
      }
      EXPECT_NEAR(sum, truth.value, 4 * n * 2.3e-16);
      EXPECT_NEAR(one, 1, n * 2.3e-16);
    }
  }
  EXPECT_EQ(BezierCurve({3, 1, 5}).value(-7), 3);  // clamped
  EXPECT_EQ(BezierCurve({3, 1, 5}).value(7), 5);
}

TEST(Bezier, ElevatedItIsTheSameCurve) {
  Rng rng(2);
  for (const int n : {1, 2, 5, 13}) {
    const auto p = random_points(rng, n);
    const auto q = elevated(p, kMostControlPoints);
    ASSERT_EQ(q.size(), static_cast<std::size_t>(kMostControlPoints));
    for (int i = 0; i <= 50; ++i)
      EXPECT_NEAR(BezierCurve(q).value(i / 50.0), BezierCurve(p).value(i / 50.0), 1e-14);
  }
}

TEST(Bezier, WithAbscissaeItIsAGraph) {
  Rng rng(3);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + static_cast<int>(rng.below(12));
    std::vector<double> x{0};
    for (int i = 1; i < n; ++i)
      x.push_back(x.back() + (trial % 2 ? rng.uniform(0.01, 1) : rng.uniform(1e-6, 1)));
    for (double& value : x) value /= x.back();
    const BezierCurve curve(random_points(rng, n), x);
    const double t = rng.uniform(), v = de_casteljau(x, t).value;
    EXPECT_NEAR(de_casteljau(x, curve.parameter(v)).value, v, 1e-15);
    const double h = 1e-6;
    if (v > 0.05 && v < 0.95) {
      EXPECT_NEAR(curve.at(v).slope, (curve.value(v + h) - curve.value(v - h)) / (2 * h),
                  1e-4 * (1 + std::abs(curve.at(v).slope)) * (1 + std::abs(curve.at(v).slope)));
    }
  }
  // Even abscissae are none.
  const std::vector<double> p = random_points(rng, 5);
  for (int i = 0; i <= 20; ++i) {
    EXPECT_NEAR(BezierCurve(p, {0, 0.25, 0.5, 0.75, 1}).value(i / 20.0), BezierCurve(p).value(i / 20.0),
                1e-14);
  }
}

TEST(Bezier, WhatIsNoCurveIsRefused) {
  const double nan = std::nan("");
  EXPECT_THROW(BezierCurve({}), Error);
  EXPECT_THROW(BezierCurve(std::vector<double>(22, 1.0)), Error);
  EXPECT_THROW(BezierCurve({1, nan}), Error);
  EXPECT_THROW(BezierCurve({1, 1e31}), Error);
  EXPECT_THROW(BezierCurve({1, 2}, {0, 1, 2}), Error);
  EXPECT_THROW(BezierCurve({1, 2, 3}, {0, 0, 1}), Error);
  EXPECT_THROW(BezierCurve({1, 2, 3}, {0, nan, 1}), Error);
  EXPECT_THROW(BezierCurve({1, 2, 3}, {0, 0.5, 0.9}), Error);
  EXPECT_THROW((BezierTransfer{0, 1, {}}.validate()), Error);
  EXPECT_THROW((BezierTransfer{1, 1, {{"", Vec3::Ones(), BezierCurve({1})}}}.validate()), Error);
  EXPECT_THROW((BezierTransfer{0, 1, {{"", Vec3(0, -1, 0), BezierCurve({1})}}}.validate()), Error);
  EXPECT_THROW((BezierTransfer{0, 1, {{"", Vec3(0, 1e31, 0), BezierCurve({1})}}}.validate()), Error);
  BezierTransfer many{0, 1, std::vector<BezierBand>(64, {"", Vec3::Ones(), BezierCurve({1})})};
  EXPECT_NO_THROW(many.validate());
  many.bands.push_back(many.bands.front());
  EXPECT_THROW(many.validate(), Error);
  for (const char* name : {"Z\xc3\xa4hne", "\xe2\x82\xac", "\xf0\x9f\xa6\xb7", "\xef\xbf\xbf"}) {
    EXPECT_NO_THROW((BezierTransfer{0, 1, {{name, Vec3::Ones(), BezierCurve({1})}}}.validate())) << name;
  }
  // Latin-1, half a letter, a longer form than needed, half a pair of UTF-16, beyond U+10FFFF.
  for (const char* name :
       {"Z\xe4hne", "\xff", "\xe2\x82", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80"}) {
    EXPECT_THROW((BezierTransfer{0, 1, {{name, Vec3::Ones(), BezierCurve({1})}}}.validate()), Error) << name;
  }
  EXPECT_THROW(Profile({}), Error);
  EXPECT_THROW(Profile({{0, nan}}), Error);
  EXPECT_THROW(Profile({{1, 0}, {0, 0}}), Error);
}

TEST(BezierTransfer, WeighsTheScaledValue) {
  const BezierTransfer bezier{
      100, 300, {{"a", Vec3(1, 0, 0.5), BezierCurve({0, 1})}, {"b", Vec3(0, 1, 0.5), BezierCurve({2})}}};
  EXPECT_DOUBLE_EQ(bezier.weighted(150, 0), 0.25 * 0.25);
  EXPECT_DOUBLE_EQ(bezier.weighted(150, 1), 0.25 * 2);
  EXPECT_DOUBLE_EQ(bezier.weighted(150, 2), 0.25 * (0.125 + 1));
  EXPECT_EQ(bezier.weighted(50, 1), 0);
  EXPECT_DOUBLE_EQ(bezier.weighted(1e9, 0), 1);
  EXPECT_FALSE(bezier.grey());
}

// As opacity the curves are cut at 0 and 1 and added; the lines keep within the tolerance but at the kinks of
// the cuts.
TEST(BezierTransfer, AsOpacityItStaysWithinTheTolerance) {
  Rng rng(9);
  for (int trial = 0; trial < 10; ++trial) {
    const BezierTransfer bezier{-5,
                                15,
                                {{"", Vec3(1, 0.2, 0), BezierCurve(random_points(rng, 9))},
                                 {"", Vec3(0, 0.6, 1), BezierCurve(random_points(rng, 4))}}};
    const TransferFunction transfer = as_transfer_function(bezier, 1e-4);
    EXPECT_LE(transfer.opacities().size(), 4097u);
    double steepest = 0;
    for (const auto& band : bezier.bands) {
      for (int i = 0; i <= 100; ++i) steepest = std::max(steepest, std::abs(band.curve.at(i / 100.0).slope));
    }
    for (int i = 0; i <= 3000; ++i) {
      const double v = i / 3000.0, a = std::max(0.0, bezier.bands[0].curve.value(v)),
                   b = std::max(0.0, bezier.bands[1].curve.value(v));
      // Quarters are looked at, not all of a piece: twice the tolerance; at a kink a piece's width times the
      // slope.
      EXPECT_NEAR(transfer.opacity(-5 + 20 * v), std::min(1.0, a + b), 2e-4 + 2 * steepest / 4096)
          << trial << " " << v;
    }
    const double v = 0.37, a = std::max(0.0, bezier.bands[0].curve.value(v)),
                 b = std::max(0.0, bezier.bands[1].curve.value(v));
    if (a + b > 0.1) {
      const Vec3 mean = (a * bezier.bands[0].colour + b * bezier.bands[1].colour) / (a + b);
      EXPECT_LT((transfer.colour(-5 + 20 * v) - mean).cwiseAbs().maxCoeff(), 0.01);
    }
  }
}

}  // namespace
}  // namespace vol::transfer
