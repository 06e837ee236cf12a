#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "volume/statistics.h"

namespace vol::volume {
namespace {

Volume filled(const Dims& dims, double (*f)(std::int64_t n)) {
  GridGeometry g;
  g.dims = dims;
  Volume v = allocate(VoxelType::f64, g);
  auto& voxels = std::get<Grid<double>>(v.grid).voxels;
  for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = f(static_cast<std::int64_t>(n));
  return v;
}

// 0 ... N-1: mean (N-1)/2, variance (N^2-1)/12.
TEST(Statistics, OfARamp) {
  const auto s = statistics(filled({101, 83, 67}, [](std::int64_t n) { return static_cast<double>(n); }));
  const double count = 101.0 * 83 * 67;
  EXPECT_EQ(s.range.max, count - 1);
  EXPECT_NEAR(s.mean, (count - 1) / 2, 1e-15 * count);
  EXPECT_NEAR(s.standard_deviation, std::sqrt((count * count - 1) / 12), 1e-14 * count);
  EXPECT_EQ(s.zeros, 1);
}

TEST(Statistics, SmallSignalOnALargeOffsetAndHugeValues) {
  // 1e9 and 1e9 + 1 by turns: deviation 1/2. A sum of squares would have lost it: 1e18 has an ulp of 128.
  const auto offset =
      statistics(filled({6, 5, 3}, [](std::int64_t n) { return 1e9 + static_cast<double>(n % 2); }));
  EXPECT_NEAR(offset.standard_deviation, 0.5, 1e-15);
  EXPECT_EQ(offset.mean, 1e9 + 0.5);
  const auto huge = statistics(filled({2, 5, 3}, [](std::int64_t n) { return n % 2 == 0 ? -1e308 : 1e308; }));
  EXPECT_EQ(huge.mean, 0);
  EXPECT_NEAR(huge.standard_deviation, 1e308, 1e294);
  const auto constant = statistics(filled({4, 1, 1}, [](std::int64_t) { return 0.1; }));
  EXPECT_EQ(constant.mean, 0.1);
  EXPECT_EQ(constant.standard_deviation, 0);
}

TEST(Histogram, CountsEveryVoxelOnce) {
  const auto ramp = filled({10, 5, 2}, [](std::int64_t n) { return static_cast<double>(n); });
  // 0 ... 99 in bins of 24.75: [0, 24.75) holds 25 values, and so on; the last is closed and holds 99.
  EXPECT_EQ(histogram(ramp, {0, 99}, 4), (std::vector<std::int64_t>{25, 25, 25, 25}));
  EXPECT_EQ(histogram(ramp, {0, 99}, 3), (std::vector<std::int64_t>{33, 33, 34}));
  const auto constant = filled({4, 3, 1}, [](std::int64_t) { return 7.0; });
  EXPECT_EQ(histogram(constant, {7, 7}, 3), (std::vector<std::int64_t>{12, 0, 0}));
  EXPECT_THROW((void)histogram(ramp, {0, 99}, 0), Error);
}

}  // namespace
}  // namespace vol::volume
