#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "render/bernstein.h"
#include "render/gauss.h"

namespace vol::render {
namespace {

Bernstein random_polynomial(Rng& rng, int degree) {
  Bernstein p;
  p.degree = degree;
  for (int k = 0; k <= degree; ++k) p.b[k] = rng.uniform(-1, 1);
  return p;
}

// At most 9 steps of de Casteljau on either side, each the mean of two numbers below 1, rounded by half an
// ulp, 5.5e-17.
TEST(Bernstein, HalvesAreTheSamePolynomial) {
  Rng rng(1);
  for (const int degree : {0, 1, 3, 9}) {
    const Bernstein p = random_polynomial(rng, degree);
    Bernstein left, right;
    p.halve(left, right);
    for (double u = 0; u <= 1; u += 0.0625) {
      EXPECT_NEAR(left(u), p(0.5 * u), 1e-15);
      EXPECT_NEAR(right(u), p(0.5 + 0.5 * u), 1e-15);
    }
    EXPECT_NEAR(p.integral(), 0.5 * (left.integral() + right.integral()), 1e-15);
  }
}

// The same, each step a mean of two numbers with weights u and 1 - u: three roundings.
TEST(Bernstein, PartsAreTheSamePolynomial) {
  Rng rng(4);
  for (const int degree : {0, 1, 6, 9}) {
    const Bernstein p = random_polynomial(rng, degree);
    for (const double cut : {0.0, 0.3, 0.5, 0.98, 1.0}) {
      Bernstein left, right;
      p.split(cut, left, right);
      for (double u = 0; u <= 1; u += 0.0625) {
        EXPECT_NEAR(left(u), p(cut * u), 3e-15);
        EXPECT_NEAR(right(u), p(cut + (1 - cut) * u), 3e-15);
      }
    }
  }
}

TEST(Bernstein, CrossingsAreAllSignChanges) {
  Rng rng(2);
  for (int trial = 0; trial < 300; ++trial) {
    const Bernstein p = random_polynomial(rng, trial % 2 ? 3 : 9);
    const double value = rng.uniform(-0.3, 0.3);
    std::vector<double> roots;
    append_crossings(p, value, roots);
    EXPECT_TRUE(std::is_sorted(roots.begin(), roots.end()));
    // Slope at most 2 degree max|b| <= 18, so that a root known to 1e-15 has a residual below 2e-14.
    for (const double u : roots) EXPECT_NEAR(p(u), value, 4e-14) << trial;
    int seen = 0;
    constexpr int kScan = 2000;
    for (int i = 0; i < kScan; ++i) {
      seen += (p(double(i) / kScan) > value) != (p(double(i + 1) / kScan) > value);
    }
    EXPECT_GE(static_cast<int>(roots.size()), seen) << trial;
    // As many modulo 2 as the ends say, unless a double root was cut twice.
    EXPECT_EQ(roots.size() % 2 == 1, (p(0) > value) != (p(1) > value)) << trial;
  }
}

TEST(Bernstein, MaximumIsNoLessThanAnyValueAndIsTaken) {
  Rng rng(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Bernstein p = random_polynomial(rng, trial % 2 ? 3 : 9);
    double maximum = 0, where = 0;
    ASSERT_TRUE(find_maximum(p, -10, 1e-12, maximum, where));
    // Control polygon and curve part by the square of the width: 20 halvings reach 1e-12, each of 9 steps
    // that round by 5.5e-17.
    EXPECT_NEAR(p(where), maximum, 1e-14);
    for (int i = 0; i <= 1000; ++i) EXPECT_LE(p(i / 1000.0), maximum + 1.1e-12);
    EXPECT_FALSE(find_maximum(p, maximum + 1e-9, 1e-12, maximum, where));
  }
}

TEST(Gauss, CollocationIntegratesPolynomialsOfItsDegree) {
  const auto& g = gauss_collocation();
  constexpr int kN = GaussCollocation::kNodes;
  for (int power = 0; power < kN; ++power) {
    double total = 0;
    for (int j = 0; j < kN; ++j) total += g.w[j] * std::pow(g.x[j], power);
    EXPECT_NEAR(total, 1.0 / (power + 1), 1e-15);
    for (int i = 0; i < kN; ++i) {
      double partial = 0;
      for (int j = 0; j < kN; ++j) partial += g.up_to[i][j] * std::pow(g.x[j], power);
      EXPECT_NEAR(partial, std::pow(g.x[i], power + 1) / (power + 1), 4e-15);
    }
  }
  double total = 0;  // degree 2n - 1 too
  for (int j = 0; j < kN; ++j) total += g.w[j] * std::pow(g.x[j], 2 * kN - 1);
  EXPECT_NEAR(total, 0.5 / kN, 1e-15);
}

TEST(Gauss, HighestCoefficientsAreThoseOfLegendre) {
  const auto& g = gauss_collocation();
  constexpr int kN = GaussCollocation::kNodes;
  double last = 0, before = 0;
  for (int j = 0; j < kN; ++j) {
    const double z = 2 * g.x[j] - 1;
    last += g.coefficient_last[j] * 3 * std::legendre(kN - 1, z);
    before += g.coefficient_before[j] * (5 * std::legendre(kN - 2, z) + std::legendre(2, z));
  }
  EXPECT_NEAR(last, 3, 1e-13);
  EXPECT_NEAR(before, 5, 1e-13);
}

TEST(Gauss, KronrodResolvesALogarithmicEnd) {
  EXPECT_NEAR(gauss_kronrod([](double x) { return std::log(x); }, 0, 1, 1e-13), -1, 1e-12);
  EXPECT_NEAR(gauss_kronrod([](double x) { return std::exp(x); }, 0, 1, 1e-13), std::expm1(1), 1e-14);
}

}  // namespace
}  // namespace vol::render
