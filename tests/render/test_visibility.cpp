#include "render/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "base/rng.h"

namespace vol::render {
namespace {

/// Visible are macrocells that reach 2.
const transfer::TransferFunction kSteep({{0, {1, 1, 1}}}, {{1.5, 0}, {2.5, 1}});
constexpr index::Macrocells::Range kHidden{0, 1}, kVisible{2, 3};

index::Macrocells hidden_cells(const Dims& dims) {
  index::Macrocells cells;
  cells.dims = dims;
  cells.ranges = Buffer<index::Macrocells::Range>(cells.offset(0, 0, dims[2]));
  std::fill(cells.ranges.begin(), cells.ranges.end(), kHidden);
  cells.all = {0, 3};
  return cells;
}

TEST(Visibility, DistanceIsChebyshevsToTheNearestVisibleMacrocell) {
  Rng rng(3);
  index::Macrocells cells = hidden_cells({13, 9, 17});
  for (auto& range : cells.ranges) range = rng.uniform() < 0.004 ? kVisible : kHidden;
  const Visibility v = visibility(cells, kSteep);
  EXPECT_FALSE(v.all_visible);
  const auto each = [&](const auto& visit) {
    for (std::int64_t c = 0; c < 17; ++c)
      for (std::int64_t b = 0; b < 9; ++b)
        for (std::int64_t a = 0; a < 13; ++a) visit(a, b, c);
  };
  each([&](std::int64_t a, std::int64_t b, std::int64_t c) {
    std::int64_t least = 255;
    each([&](std::int64_t i, std::int64_t j, std::int64_t k) {
      if (cells(i, j, k).max > 2)
        least = std::min(least, std::max({std::abs(a - i), std::abs(b - j), std::abs(c - k)}));
    });
    EXPECT_EQ(v.distance[cells.offset(a, b, c)], least);
  });
}

TEST(Visibility, DistanceAheadIsToTheNearestVisibleMacrocellOfTheOctant) {
  constexpr int kDims[3] = {13, 9, 17};
  for (const double share : {0.004, 0.2}) {
    Rng rng(5);
    index::Macrocells cells = hidden_cells({kDims[0], kDims[1], kDims[2]});
    for (auto& range : cells.ranges) range = rng.uniform() < share ? kVisible : kHidden;
    const Visibility v = visibility(cells, kSteep);
    const VisibilityAhead ahead(v);
    for (int octant = 0; octant < 8; ++octant) {
      const auto& distance = ahead.distance(octant);
      const auto way = [&](int from, int to, int axis) {
        return (octant >> axis & 1) != 0 ? from - to : to - from;
      };
      for (int n = 0; n < 13 * 9 * 17; ++n) {
        const int a = n % 13, b = n / 13 % 9, c = n / (13 * 9);
        int least = 255;
        for (int m = 0; m < 13 * 9 * 17; ++m) {
          const int i = m % 13, j = m / 13 % 9, k = m / (13 * 9);
          const int x = way(a, i, 0), y = way(b, j, 1), z = way(c, k, 2);
          if (std::min({x, y, z}) >= 0 && cells(i, j, k).max > 2)
            least = std::min(least, std::max({x, y, z}));
        }
        ASSERT_EQ(distance[cells.offset(a, b, c)], least) << "octant " << octant << ", macrocell " << n;
      }
    }
  }
}

TEST(Visibility, DistanceAheadEndsAt255AndDoesNotWrap) {
  index::Macrocells cells = hidden_cells({2, 700, 3});
  cells.ranges[cells.offset(1, 300, 1)] = kVisible;
  const Visibility v = visibility(cells, kSteep);
  const VisibilityAhead ahead(v);
  for (std::int64_t m = 0; m < 700; ++m) {
    EXPECT_EQ(ahead.distance(0)[cells.offset(0, m, 0)],
              m <= 300 ? std::min<std::int64_t>(255, std::max<std::int64_t>(300 - m, 1)) : 255)
        << m;
    EXPECT_EQ(ahead.distance(7)[cells.offset(1, m, 2)],
              m >= 300 ? std::min<std::int64_t>(255, std::max<std::int64_t>(m - 300, 1)) : 255)
        << m;
  }
}

TEST(Visibility, DistanceEndsAt255AndDoesNotWrap) {
  const Dims long_in[] = {{700, 3, 2}, {3, 700, 2}, {2, 3, 700}};
  for (int axis = 0; axis < 3; ++axis) {
    index::Macrocells cells = hidden_cells(long_in[axis]);
    Visibility v = visibility(cells, kSteep);
    for (const std::uint8_t distance : v.distance) ASSERT_EQ(distance, 255) << "nothing is visible";
    std::int64_t at[3] = {0, 0, 0};
    at[axis] = 300;
    cells.ranges[cells.offset(at[0], at[1], at[2])] = kVisible;
    v = visibility(cells, kSteep);
    for (std::int64_t m = 0; m < 700; ++m) {
      at[axis] = m;
      ASSERT_EQ(v.distance[cells.offset(at[0], at[1], at[2])], std::min<std::int64_t>(255, std::abs(m - 300)))
          << "axis " << axis << ", macrocell " << m;
    }
  }
}

TEST(Visibility, InvisibleValuesAreClosedIntervalsWithoutTheJumps) {
  const double inf = std::numeric_limits<double>::infinity();
  const transfer::TransferFunction transfer(
      {{0, {1, 1, 1}}}, {{1, 0}, {1, 0.5}, {2, 0}, {3, 0}, {4, 1}, {5, 0}, {6, 0.1}, {7, 0}});
  const auto found = invisible_values(transfer);
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0].min, -inf);
  EXPECT_LT(found[0].max, 1);
  EXPECT_EQ(found[1].min, 2);
  EXPECT_EQ(found[1].max, 3);
  EXPECT_EQ(found[2].min, 5);
  EXPECT_EQ(found[2].max, 5);
  EXPECT_EQ(found[3].min, 7);
  EXPECT_EQ(found[3].max, inf);
}

}  // namespace
}  // namespace vol::render
