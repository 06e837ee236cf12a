#include <gtest/gtest.h>

#include "base/error.h"
#include "base/rng.h"
#include "transfer/transfer_function.h"

namespace vol::transfer {
namespace {

TransferFunction example() {
  return TransferFunction({{-1, {0.5, 0, 0.25}}, {3, {0, 1, 2}}}, {{0, 0.1}, {1, 0.9}, {1, 0.3}, {4, 0.2}});
}

TEST(TransferFunction, IsLinearBetweenPointsAndHoldsItsEnds) {
  const auto tf = example();
  EXPECT_DOUBLE_EQ(tf.opacity(0.25), 0.1 + 0.25 * 0.8);
  EXPECT_DOUBLE_EQ(tf.opacity(-50), 0.1);
  EXPECT_DOUBLE_EQ(tf.opacity(50), 0.2);
  EXPECT_TRUE(tf.colour(1).isApprox(Vec3(0.25, 0.5, 1.125)));
  EXPECT_TRUE(tf.colour(99).isApprox(Vec3(0, 1, 2)));
}

// The difference of two values may be beyond all doubles.
TEST(TransferFunction, IsLinearOverTheWholeRangeOfDoubles) {
  const TransferFunction tf({{-1.5e308, {0, 0, 0}}, {1.5e308, {1, 1, 1}}}, {{-1.5e308, 0}, {1.5e308, 1}});
  for (const double at : {-1.5e308, -1e308, 0.0, 1.0, 1.2e308, 1.5e308}) {
    EXPECT_DOUBLE_EQ(tf.opacity(at), 0.5 + at / 3e307 / 10) << at;
    EXPECT_DOUBLE_EQ(tf.colour(at)[1], tf.opacity(at)) << at;
  }
}

TEST(TransferFunction, AtAJumpTheSecondPointHolds) {
  EXPECT_DOUBLE_EQ(example().opacity(1), 0.3);
}

TEST(TransferFunction, RangesBoundEveryValueInside) {
  const auto tf = example();
  Rng rng(1);
  for (int trial = 0; trial < 500; ++trial) {
    double lo = rng.uniform(-2, 5), hi = rng.uniform(-2, 5);
    if (hi < lo) std::swap(lo, hi);
    const double v = rng.uniform(lo, hi);
    EXPECT_LE(tf.opacity(v), tf.max_opacity(lo, hi));
    EXPECT_GE(tf.opacity(v), tf.min_opacity(lo, hi));
  }
  EXPECT_DOUBLE_EQ(tf.max_opacity(0, 4), 0.9);
}

TEST(TransferFunction, RefusesWhatIsNotATransferFunction) {
  EXPECT_THROW(TransferFunction({}, {{0, 0}}), Error);
  EXPECT_THROW(TransferFunction({{0, {0, 0, 0}}}, {{1, 0}, {0, 0}}), Error);
  EXPECT_THROW(TransferFunction({{0, {0, 0, 0}}}, {{0, 1.5}}), Error);
  EXPECT_THROW(TransferFunction({{0, {0, -1, 0}}}, {{0, 0.5}}), Error);
}

}  // namespace
}  // namespace vol::transfer
