#include <gtest/gtest.h>

#include "base/checked.h"
#include "base/compensated_sum.h"
#include "base/error.h"

namespace vol {
namespace {

TEST(Error, NamesItsContextOnce) {
  const Error cause("a.nrrd: data end early");
  EXPECT_STREQ(Error("a.nrrd", cause).what(), "a.nrrd: data end early");
  EXPECT_STREQ(Error("b.nrrd", cause).what(), "b.nrrd: a.nrrd: data end early");
  EXPECT_STREQ(Error("a", cause).what(), "a: a.nrrd: data end early");
}

TEST(CheckedCount, MultipliesBeyond32Bits) { EXPECT_EQ(checked_count({1291, 1291, 1291}), 2151685171); }

TEST(CheckedCount, RefusesOverflowAndEmptyAxes) {
  EXPECT_THROW((void)checked_count({std::int64_t{1} << 21, std::int64_t{1} << 21, std::int64_t{1} << 21}), Error);
  EXPECT_THROW((void)checked_count({0, 4, 4}), Error);
  EXPECT_THROW((void)checked_count({4, -4, -4}), Error);
}

// The classic case that plain and Kahan summation both get wrong: 1 + 1e100 + 1 - 1e100 is 2.
TEST(CompensatedSum, KeepsSmallTermsBesideLargeOnes) {
  CompensatedSum sum;
  for (const double x : {1.0, 1e100, 1.0, -1e100}) sum.add(x);
  EXPECT_EQ(sum.value(), 2.0);
}

TEST(CompensatedSum, InfinityStaysInfinity) {
  CompensatedSum sum;
  sum.add(std::numeric_limits<double>::infinity());
  sum.add(1.0);
  EXPECT_TRUE(std::isinf(sum.value()));
}

}  // namespace
}  // namespace vol
