#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/rng.h"
#include "transfer/opacity.h"

namespace vol::transfer {
namespace {

// n segments of length h/n have together the opacity of one of length h: transmittances multiply.
TEST(CorrectedOpacity, SegmentsCompose) {
  Rng rng(3);
  for (int trial = 0; trial < 1000; ++trial) {
    const double a = rng.uniform(), h = rng.uniform(1e-3, 3), length = rng.uniform(0.1, 2);
    const int n = 1 + static_cast<int>(rng.below(20));
    double transmittance = 1;
    for (int i = 0; i < n; ++i) transmittance *= 1 - corrected_opacity(a, h / n, length);
    EXPECT_NEAR(1 - transmittance, corrected_opacity(a, h, length), 4e-16 * (n + 2));
  }
}

TEST(CorrectedOpacity, KeepsTheDigitsOfTinyOpacities) {
  const double a = std::numeric_limits<double>::min() * 4;
  EXPECT_DOUBLE_EQ(corrected_opacity(a, 0.5, 1.0), 0.5 * a);
}

TEST(CorrectedOpacity, OpaqueStaysOpaqueAndClearStaysClear) {
  EXPECT_EQ(corrected_opacity(1, 1e-9, 1), 1);
  EXPECT_EQ(corrected_opacity(0, 1e9, 1), 0);
}

// Against the composite midpoint rule on many intervals (error about h^2/24 * |f'|, here below 1e-9).
TEST(MeanRampDepth, IsTheMeanOfTheExtinctionOfARamp) {
  Rng rng(11);
  for (int trial = 0; trial < 200; ++trial) {
    const double a0 = 0.95 * rng.uniform(), a1 = trial % 2 ? 0.95 * rng.uniform() : a0 + 1e-3 * rng.uniform(-1, 1);
    if (a1 < 0) continue;
    constexpr int kIntervals = 20000;
    double sum = 0;
    for (int i = 0; i < kIntervals; ++i) sum -= std::log1p(-(a0 + (a1 - a0) * (i + 0.5) / kIntervals));
    EXPECT_NEAR(mean_ramp_depth(a0, a1), sum / kIntervals, 2e-8) << a0 << " " << a1;
  }
}

// With an opaque end the closed form is 1 - log of the other end's transparency: from 0 to 1 it is exactly 1.
TEST(MeanRampDepth, OpaqueEndIsFinite) {
  EXPECT_DOUBLE_EQ(mean_ramp_depth(0, 1), 1);
  EXPECT_DOUBLE_EQ(mean_ramp_depth(1, 0.5), 1 - std::log(0.5));
  EXPECT_TRUE(std::isinf(mean_ramp_depth(1, 1)));
  EXPECT_EQ(mean_ramp_depth(0, 0), 0);
}

// Ends of 20 and 21 half ulps from 1: their midpoint is no double, 1 minus it is. Three roundings of a depth of 34.
TEST(MeanRampDepth, KeepsTheDigitsOfTransparenciesNearZero) {
  const long double u0 = 20 * 0x1p-53L, u1 = 21 * 0x1p-53L;
  const long double mean = 1 + (u1 * std::log(u1) - u0 * std::log(u0)) / (u0 - u1);
  EXPECT_NEAR(mean_ramp_depth(1 - 20 * 0x1p-53, 1 - 21 * 0x1p-53), static_cast<double>(mean), 2e-14);
}

}  // namespace
}  // namespace vol::transfer
