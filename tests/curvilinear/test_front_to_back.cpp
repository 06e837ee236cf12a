#include "curvilinear/front_to_back.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/rng.h"
#include "curvilinear/cell_order.h"

namespace vol::curvilinear {
namespace {

using Places = std::vector<std::uint32_t>;

TEST(FrontToBack, KeepsTheRelationAndElseTheNumbers) {
  const FrontToBack found = front_to_back(5, {{4, 1}, {1, 0}, {3, 0}});
  EXPECT_EQ(found.order, (Places{2, 3, 4, 1, 0}));
  EXPECT_TRUE(found.circles.empty());
}

TEST(FrontToBack, CirclesAreStretchesOfTheOrder) {
  // 5 before the circle 3 -> 1 -> 4 -> 3, that before 0; 2 beside, and a circle of two behind 0.
  const FrontToBack found =
      front_to_back(8, {{5, 4}, {3, 1}, {1, 4}, {4, 3}, {4, 0}, {0, 6}, {6, 7}, {7, 6}});
  EXPECT_EQ(found.order, (Places{2, 5, 1, 4, 3, 0, 6, 7}));
  ASSERT_EQ(found.circles.size(), 2U);
  EXPECT_EQ(found.circles[0].begin, 2U);
  EXPECT_EQ(found.circles[0].end, 5U);
  EXPECT_EQ(found.circles[1].begin, 6U);
  EXPECT_EQ(found.circles[1].end, 8U);
}

// Components by who reaches whom, closed over all pairs; everything once, and in order but within circles.
TEST(FrontToBack, RandomRelations) {
  Rng random(31);
  for (int trial = 0; trial < 300; ++trial) {
    const auto count = static_cast<std::uint32_t>(1 + random.below(14));
    std::vector<Before> before;
    for (auto n = random.below(2 * count); n > 0; --n) {
      const auto a = static_cast<std::uint32_t>(random.below(count)),
                 b = static_cast<std::uint32_t>(random.below(count));
      if (a != b) before.emplace_back(a, b);
    }
    std::vector<std::vector<bool>> reaches(count, std::vector<bool>(count, false));
    for (const auto& [a, b] : before) reaches[a][b] = true;
    for (std::uint32_t k = 0; k < count; ++k) {
      for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = 0; j < count; ++j)
          reaches[i][j] = reaches[i][j] || (reaches[i][k] && reaches[k][j]);
      }
    }
    const FrontToBack found = front_to_back(count, before);
    ASSERT_EQ(found.order.size(), count);
    std::vector<std::size_t> at(count, count);
    for (std::size_t n = 0; n < count; ++n) at[found.order[n]] = n;
    EXPECT_EQ(std::count(at.begin(), at.end(), std::size_t{count}), 0) << "not everything once";
    std::vector<int> circle(count, -1);
    for (std::size_t c = 0; c < found.circles.size(); ++c) {
      for (std::size_t n = found.circles[c].begin; n < found.circles[c].end; ++n)
        circle[found.order[n]] = static_cast<int>(c);
    }
    for (std::uint32_t a = 0; a < count; ++a) {
      EXPECT_EQ(circle[a] >= 0, reaches[a][a]);
      for (std::uint32_t b = 0; b < count; ++b) {
        const bool together = circle[a] >= 0 && circle[a] == circle[b];
        if (a != b) {
          EXPECT_EQ(together, reaches[a][b] && reaches[b][a]);
        }
        if (reaches[a][b] && !together) {
          EXPECT_LT(at[a], at[b]);
        }
      }
    }
  }
}

// A long cell whose far end is nearer to the eye than anything of the one in front of it: Bethel's figure 5.
TEST(CellOrder, FacesSayWhatDepthCannot) {
  std::vector<VisibleCell> cells(2);
  cells[0] = {1.0, 0, 0, 0, 1};  // behind
  cells[1] = {2.0, 0, 1, 0, 1};
  cells[0].before_next[0] = -1;  // light meets cell 1 first
  sort_by_depth(cells);
  EXPECT_EQ(cells[0].number, 0);
  EXPECT_EQ(front_to_back(2, before_by_faces(cells, {{2, 1, 1}})).order, (Places{1, 0}));
}

TEST(CellOrder, FourCellsEachBeforeTheNextOneRound) {
  std::vector<VisibleCell> cells;
  for (std::int64_t n = 0; n < 4; ++n) cells.push_back({1.0 + static_cast<double>(n), 0, n, 0, 1});
  cells[0].before_next = {1, -1, 0};  // 0 before 1, 2 before 0
  cells[1].before_next = {0, 1, 0};   // 1 before 3
  cells[2].before_next = {-1, 0, 0};  // 3 before 2
  const FrontToBack found = front_to_back(4, before_by_faces(cells, {{2, 2, 1}}));
  EXPECT_EQ(found.order, (Places{0, 1, 3, 2}));
  EXPECT_EQ(found.circles.size(), 1U);
}

// A group of eight beside single cells: these say who is in front, each by its own face.
TEST(CellOrder, GroupsAskTheirSmallerNeighbours) {
  std::vector<VisibleCell> cells(3);
  cells[0] = {1, 0, 0, 0, 1};  // cells 0 and 1 along each axis of 4 x 2 x 2
  cells[0].level = 1;
  cells[0].before_next = {1, 1, 1};
  cells[1] = {2, 0, 2, 0, 1};  // (2, 0, 0)
  cells[1].before_previous = {1, 0, 0};
  cells[2] = {3, 0, 14, 0, 1};  // (2, 1, 1)
  cells[2].before_previous = {-1, 0, 0};
  EXPECT_EQ(before_by_faces(cells, {{4, 2, 2}}), (std::vector<Before>{{1, 0}, {0, 2}}));
}

}  // namespace
}  // namespace vol::curvilinear
