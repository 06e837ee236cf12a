#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "features/self_organising_map.h"

namespace vol::features {
namespace {

/// A sheet of 1.5 by 1, bent into three dimensions: two-dimensional, but in no plane.
Samples bent_sheet(int n, std::uint64_t seed) {
  Rng rng(seed);
  Samples x(n, 3);
  for (int i = 0; i < n; ++i) {
    const double u = rng.uniform(-0.75, 0.75), v = rng.uniform(-0.5, 0.5);
    x.row(i) << u, v, 0.3 * u * u;
  }
  return x;
}

class MapGrids : public testing::TestWithParam<MapGrid> {};

// The measure: the share of samples whose two nearest units are no neighbours stays under 5 %.
TEST_P(MapGrids, KeepsTheTopologyOfASheet) {
  for (const auto& [columns, rows] : {std::pair{6, 4}, {9, 6}, {4, 6}}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const auto map =
          train_map(bent_sheet(4000, seed), {.columns = columns, .rows = rows, .grid = GetParam()});
      EXPECT_LT(map.topographic_error, 0.05) << columns << "x" << rows << " seed " << seed;
      std::int64_t hits = 0;
      for (const auto h : map.hits) {
        EXPECT_GT(h, 0);
        hits += h;
      }
      EXPECT_EQ(hits, 4000);
      // A regular tiling by so many cells of the area 1.5 has a root mean square distance of sqrt(area / 6
      // units) for squares; pulled by their neighbours the units cover less.
      EXPECT_LT(map.quantisation_error, 1.5 * std::sqrt(1.5 / (6.0 * columns * rows)));
    }
  }
}
INSTANTIATE_TEST_SUITE_P(SelfOrganisingMap, MapGrids,
                         testing::Values(MapGrid::rectangular, MapGrid::hexagonal));

// What the measure is worth: units in the wrong places on the grid are found out.
TEST(SelfOrganisingMap, TopographicErrorSeesATornMap) {
  const Samples x = bent_sheet(2000, 5);
  const auto map = train_map(x, {.columns = 6, .rows = 4});
  int neighbours = 0;
  for (int a = 0; a < 24; ++a) {
    for (int b = 0; b < 24; ++b) neighbours += a != b && map.are_neighbours(a, b);
  }
  EXPECT_EQ(neighbours, 2 * (5 * 4 + 6 * 3 + 2 * 5 * 3));  // edges along both axes, and both diagonals
  auto hexagonal = map;
  hexagonal.options.grid = MapGrid::hexagonal;
  neighbours = 0;
  for (int a = 0; a < 24; ++a) {
    for (int b = 0; b < 24; ++b) neighbours += a != b && hexagonal.are_neighbours(a, b);
  }
  EXPECT_EQ(neighbours, 2 * (5 * 4 + 11 * 3));  // along a row 5; between two rows 11
}

TEST(SelfOrganisingMap, SameMapForAnyNumberOfThreads) {
  const Samples x = bent_sheet(20000, 7);
  set_thread_count(1);
  const auto one = train_map(x, {});
  set_thread_count(3);
  const auto three = train_map(x, {});
  set_thread_count(0);
  EXPECT_TRUE(one.units == three.units);
  EXPECT_EQ(one.hits, three.hits);
}

TEST(SelfOrganisingMap, DegenerateInputs) {
  const auto same = train_map(Samples::Constant(10, 2, 3.0), {});
  // A weighted mean of equal numbers, rounded.
  EXPECT_LT(same.quantisation_error, 1e-14);
  EXPECT_LT((same.units - Samples::Constant(24, 2, 3.0)).cwiseAbs().maxCoeff(), 1e-14);
  const auto one = train_map(bent_sheet(10, 1), {.columns = 1, .rows = 1});
  EXPECT_LT((one.units.row(0) - bent_sheet(10, 1).colwise().mean()).norm(), 1e-15);
  EXPECT_EQ(one.topographic_error, 0);
  const auto empty = train_map(Samples(5, 0), {});  // no component has variance
  EXPECT_EQ(empty.hits[0], 5);
  EXPECT_THROW((void)train_map(Samples(0, 2), {}), Error);
  EXPECT_THROW((void)train_map(bent_sheet(10, 1), {.columns = 0}), Error);
  EXPECT_THROW((void)train_map(bent_sheet(10, 1), {.columns = 70000, .rows = 70000}), Error);
}

}  // namespace
}  // namespace vol::features
