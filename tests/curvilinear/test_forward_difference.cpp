#include <gtest/gtest.h>

#include <limits>

#include "base/error.h"
#include "curvilinear/forward_difference.h"
#include "drift.h"
#include "random_block.h"

namespace vol::curvilinear {
namespace {

std::vector<Solid> random_solids() {
  std::vector<Solid> all;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const Block block = random_block({5, 4, 4}, seed);
    all.push_back(Solids(block, block.arrays[0].values, CellKind::tricubic, 1)({1, 1, 1}));
  }
  return all;
}

template <class T>
double worst_drift(int steps, int axes, SetUp set_up) {
  double worst = 0;
  for (const Solid& solid : random_solids()) {
    worst = std::max(worst, drift<T>(solid, steps, axes, set_up, local_origin(solid)));
  }
  return worst;
}

TEST(ForwardDifference, MeetsEveryPointOfASmallLattice) {
  const Solid solid = random_solids()[0];
  const Point4 origin = local_origin(solid);
  for (const Vec3& first : {Vec3(0, 0, 0), Vec3(0.5, 0.5, 0.5), Vec3(0, 0.5, 1)}) {
    const Lattice lattice{{7, 1, 4}, {8, 3, 5}, first};
    ForwardDifferences<double> f(solid, origin, lattice);
    auto g = ForwardDifferences<double>::from_samples(solid, origin, lattice);
    int met = 0;
    for (int w = 0; w < 5; ++w) {
      for (auto* each : {&f, &g}) {
        // Coordinates and coefficients below 100, with points beyond the cell. From samples 8^3 roundings of
        // a third difference, which 7 and 4 steps take 7^3 / 6 and 4^3 / 6 times.
        const long double tolerance = each == &f ? 1e-11L : 1e-9L;
        each->each_row([&](int v, Differences<double>& row) {
          for (int u = 0; u < 8; ++u) {
            const auto right = direct_point(solid, origin, lattice, {u, v, w});
            EXPECT_LT((row.value().cast<long double>() - right).abs().maxCoeff(), tolerance);
            row.advance();
            ++met;
          }
        });
        each->next_plane();
      }
    }
    EXPECT_EQ(met, 2 * 8 * 3 * 5);
  }
}

// n additions of a rounding each to the value, n to the first difference of size 1/n which the value sums n
// times, and so on: n eps, times 3 axes, times what the differences of a cubic exceed the cell by (4).
TEST(ForwardDifference, FromControlPointsDriftGrowsAsNEps) {
  for (const int axes : {1, 3}) {
    for (const int n : {1, 4, 16, 64, 256, 1024, 4096}) {
      if (axes == 3 && n > 1024) continue;  // not more is looked at than walked over, and that is n^2
      const double law = 4.0 * axes * (n + 4);
      EXPECT_LT(worst_drift<float>(n, axes, SetUp::control_points),
                law * static_cast<double>(std::numeric_limits<float>::epsilon()))
          << n << " steps along " << axes;
      EXPECT_LT(worst_drift<double>(n, axes, SetUp::control_points),
                law * std::numeric_limits<double>::epsilon())
          << n << " steps along " << axes;
    }
  }
}

// A third difference has 8 roundings of size eps, and the value after n steps n^3 / 6 of it.
TEST(ForwardDifference, FromSamplesDriftGrowsAsNCubedEps) {
  for (const int n : {64, 256, 1024}) {
    const double cube = static_cast<double>(n) * n * n;
    const double f = worst_drift<float>(n, 1, SetUp::samples);
    const double d = worst_drift<double>(n, 1, SetUp::samples);
    const double eps[2] = {static_cast<double>(std::numeric_limits<float>::epsilon()),
                           std::numeric_limits<double>::epsilon()};
    EXPECT_LT(f, 8.0 / 6 * cube * eps[0]);
    EXPECT_LT(d, 8.0 / 6 * cube * eps[1]);
    // The roundings are random, of half an eps of half a cell, and all but cancel: a twentieth is usual.
    EXPECT_GT(f, 8.0 / 6 * cube * eps[0] / 100);
    EXPECT_GT(d, 8.0 / 6 * cube * eps[1] / 100);
  }
}

TEST(ForwardDifference, WhatIsUsedStaysUnderAHundredThousandthOfTheCell) {
  for (int n = 1; n <= kFloatSteps; ++n) {
    EXPECT_LT(worst_drift<float>(n, 3, SetUp::control_points), 1e-5) << n;
  }
  EXPECT_LT(worst_drift<double>(kMostSteps, 1, SetUp::control_points), 1e-10);
  EXPECT_LT(worst_drift<double>(1024, 3, SetUp::control_points), 1e-10);
}

// Why coordinates are the cell's own: far off, float has no digits left for a cell.
TEST(ForwardDifference, CoordinatesFarFromTheCellSpoilFloat) {
  const Solid solid = random_solids()[0];
  Point4 far = local_origin(solid);
  far.head<3>() += 1000 * solid.hull().size();
  EXPECT_GT(drift<float>(solid, 16, 3, SetUp::control_points, far), 1e-5);
  EXPECT_LT(drift<double>(solid, 16, 3, SetUp::control_points, far), 1e-10);
}

TEST(ForwardDifference, StepsOutOfRangeAreRefused) {
  const Solid solid = random_solids()[0];
  EXPECT_THROW(ForwardDifferences<float>(solid, Point4::Zero(), Lattice{{0, 1, 1}, {1, 1, 1}, Vec3::Zero()}),
               Error);
  EXPECT_THROW(ForwardDifferences<float>(solid, Point4::Zero(),
                                         Lattice{{1, kMostSteps + 1, 1}, {1, 1, 1}, Vec3::Zero()}),
               Error);
}

}  // namespace
}  // namespace vol::curvilinear
