// Pictures by sheets within an error, against rays throughout.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "curvilinear/larger_error.h"
#include "curvilinear/merged_cells.h"
#include "curvilinear/phantom.h"
#include "curvilinear/sheets_within_error.h"
#include "random_block.h"

namespace vol::curvilinear {
namespace {

using Values = std::vector<std::vector<double>>;

render::Scene soft() {
  render::Scene scene;
  scene.view.azimuth = 33;
  scene.view.elevation = 21;
  scene.transfer = transfer::TransferFunction({{0, Vec3(0, 0, 1)}, {1, Vec3(1, 0.5, 0)}}, {{0, 0}, {1, 0.9}});
  scene.reference_length = 0.5;
  return scene;
}

struct Found {
  WithinErrorResult result;
  double largest = 0;  ///< error
  int beyond = 0;      ///< pixels off by more than the bound
};
Found drawn(const Grid& grid, const render::Scene& scene, int size, double bound) {
  Values values;
  for (const Block& block : grid.blocks) values.push_back(block.arrays[0].values);
  const SolidRays rays(grid, values, CellKind::tricubic, 1);
  render::RenderOptions exact;
  exact.width = exact.height = size;
  exact.tolerance = 1e-7;
  const image::Image truth = cast_solids(rays, scene, exact).image;
  Found found{draw_within_error(rays, values, scene, size, size, {}, bound)};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      double off = 0;
      for (int c = 0; c < 4; ++c)
        off =
            std::max(off, std::abs(static_cast<double>(found.result.image.at(x, y, c)) - truth.at(x, y, c)));
      found.largest = std::max(found.largest, off);
      found.beyond += off > bound;
    }
  }
  return found;
}

// By phantoms and bounds, opaque and not. Estimates are no bounds: two of a picture's 9216 pixels, and no
// more, may be off by more, and none by three times it.
TEST(WithinError, IsKeptAgainstRays) {
  for (const char* name : {"half-torus", "twisted-box", "c-grid"}) {
    // The C-grid's own size has more cells than the picture has pixels, and would be left to rays.
    const Dims dims = std::string(name) == "c-grid" ? Dims{25, 9, 5} : Dims{0, 0, 0};
    const Grid grid = make_phantom(name, dims, "marschner-lobb", 1);
    for (const double bound : {0.1, 0.02, 0.004}) {
      const Found found = drawn(grid, soft(), 96, bound);
      SCOPED_TRACE(std::string(name) + ' ' + std::to_string(bound) + ": largest " +
                   std::to_string(found.largest) + ", throttle " + std::to_string(found.result.throttle) +
                   ", redrawn " + std::to_string(found.result.counts.redrawn));
      EXPECT_LE(found.result.error_estimate, bound);
      EXPECT_LE(found.beyond, 2);
      EXPECT_LE(found.largest, 3 * bound);
      EXPECT_LE(found.result.largest_checked, bound);
      // By sheets, not by rays throughout, which would keep any bound; and the check is of those. At the
      // finest bound so small a picture is mostly edges, which are for rays.
      if (bound < 0.02) continue;
      EXPECT_GT(found.result.throttle, 0);
      EXPECT_GT(found.result.counts.sheets.sheets, 0);
      // The picture, two of off values and a coarser one at least.
      EXPECT_GT(found.result.counts.samples, 3 * found.result.counts.sheets.samples);
      EXPECT_LT(found.result.counts.rays, 96 * 96);
      EXPECT_GE(found.result.last_checked, kChecked);
    }
  }
}

// The default ramp is opaque where the field is at its highest: rays that graze it are found.
TEST(WithinError, IsKeptWhereAGrazedRegionIsOpaque) {
  render::Scene scene = soft();
  scene.transfer = transfer::TransferFunction({{0, Vec3(0, 0, 1)}, {1, Vec3(1, 0, 0)}}, {{0, 0}, {1, 1}});
  const Found found = drawn(make_phantom("twisted-box", {9, 9, 17}, "marschner-lobb", 1), scene, 128, 0.02);
  EXPECT_LE(found.beyond, 2) << found.largest;
  EXPECT_GT(found.result.counts.redrawn, 0);
  EXPECT_GT(found.result.throttle, 0);
}

// A fine grid of a smooth field: many cells are drawn as one. One whose cells are smaller than pixels and
// unlike each other is left to rays; and so is a bound that float sheets cannot keep.
TEST(WithinError, DrawsFineGridsTogetherAndTheRestByRays) {
  const Grid fine = make_phantom("half-torus", {65, 17, 17}, "ramp", 1);
  const Found merged = drawn(fine, soft(), 96, 0.02);
  EXPECT_LT(merged.result.counts.sheets.cells, fine.blocks[0].cell_count() / 50);
  EXPECT_LE(merged.beyond, 2) << merged.largest;
  EXPECT_GT(merged.result.throttle, 0);
  const Found small = drawn(make_phantom("delta-wing", {20, 30, 20}, "noise", 1), soft(), 24, 0.02);
  EXPECT_EQ(small.result.throttle, 0);
  EXPECT_EQ(small.result.counts.sheets.cells, 0);  // of the pictures that were given up nothing is left
  EXPECT_EQ(small.result.counts.rays, 24 * 24);
  EXPECT_GT(small.result.counts.ray_samples, 0);
  EXPECT_EQ(small.beyond, 0);
  const Found fineness = drawn(make_phantom("sheared-box", {3, 3, 3}, "ramp", 1), soft(), 24, 1e-5);
  EXPECT_EQ(fineness.result.throttle, 0);
  EXPECT_EQ(fineness.beyond, 0);
}

// Blocks that overlap count once along rays; as sheets each absorbs by itself, at any throttle, so that no
// estimate shows it. The check does, and what is then left by sheets is right.
TEST(WithinError, WhatEstimatesMissTheCheckFinds) {
  Grid grid = make_phantom("sheared-box", {3, 3, 3}, "ramp", 1);
  grid.blocks.push_back(grid.blocks[0]);
  const Found found = drawn(grid, soft(), 64, 0.02);
  EXPECT_GT(found.result.counts.missed, 0);
  EXPECT_GT(found.result.counts.checked, found.result.counts.missed);
  EXPECT_LE(found.result.largest_checked, 0.02);
  EXPECT_LE(found.result.error_estimate, 0.02);
  EXPECT_LE(found.beyond, 2) << found.largest;
}

TEST(WithinError, RefusesValuesThatNoErrorCanBeToldOf) {
  const Grid grid = make_phantom("sheared-box", {3, 3, 3}, "ramp", 1);
  const Values good{grid.blocks[0].arrays[0].values};
  const SolidRays rays(grid, good, CellKind::tricubic, 1);
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Values values = good;
    values[0][13] = wrong;
    EXPECT_THROW((void)draw_within_error(rays, values, soft(), 8, 8, {}, 0.1), Error);
  }
  Values few = good;
  few[0].pop_back();
  EXPECT_THROW((void)draw_within_error(rays, few, soft(), 8, 8, {}, 0.1), Error);
  EXPECT_THROW((void)draw_within_error(rays, {}, soft(), 8, 8, {}, 0.1), Error);
}

TEST(WithinError, WhatIsNoNumberIsNoSmallError) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(larger_error(1.0F, 2.0F), 2);
  EXPECT_EQ(larger_error(2.0F, 1.0F), 2);
  EXPECT_EQ(larger_error(2.0F, inf), inf);
  EXPECT_EQ(larger_error(1.0F, nan), inf);
  EXPECT_EQ(larger_error(nan, 1.0F), inf);
  EXPECT_EQ(larger_error(inf, nan), inf);
}

TEST(WithinError, IsTheSameOnAnyNumberOfThreadsAndSaysWhatCannotBe) {
  const Grid grid = make_phantom("twisted-box", {5, 5, 5}, "marschner-lobb", 1);
  set_thread_count(1);
  const Found one = drawn(grid, soft(), 48, 0.02);
  set_thread_count(0);
  const Found many = drawn(grid, soft(), 48, 0.02);
  EXPECT_TRUE(std::equal(one.result.image.pixels.begin(), one.result.image.pixels.end(),
                         many.result.image.pixels.begin()));
  EXPECT_GT(drawn(grid, soft(), 8, 1e-12).result.error_estimate, 1e-12);
  EXPECT_THROW((void)drawn(grid, soft(), 8, 0), Error);
}

// Groups miss their cells by no more than they say, in position and value, everywhere; and something is
// merged.
TEST(MergedCells, MissByNoMoreThanTheTolerance) {
  Block block = random_block({14, 9, 12}, 7, 0.02);
  for (std::size_t n = 0; n < block.points.size(); ++n)
    block.arrays[0].values[n] = std::sin(0.3 * block.points[n].x()) + 0.1 * block.points[n].y();
  constexpr MergeTolerance kAllowed{0.05, 0.02};
  for (const auto kind : {CellKind::tricubic, CellKind::trilinear}) {
    const MergedCells merged(block, block.arrays[0].values, kind, 1, [&](const Vec3&) { return kAllowed; });
    const Solids solids(block, block.arrays[0].values, kind, 1);
    Rng random(3);
    int groups = 0;
    for (std::int64_t n = 0; n < block.cell_count(); ++n) {
      const Dims cells = block.cells();
      const Dims cell{n % cells[0], n / cells[0] % cells[1], n / (cells[0] * cells[1])};
      const int level = merged.level(cell);
      if (level == 0) continue;
      ++groups;
      const std::int64_t mask = (std::int64_t{1} << level) - 1;
      const Dims first{cell[0] & ~mask, cell[1] & ~mask, cell[2] & ~mask};
      EXPECT_EQ(merged.level(first), level);
      const Solid group = merged.solid(level, first), own = solids(cell);
      for (int k = 0; k < 5; ++k) {
        const Vec3 u(random.uniform(), random.uniform(), random.uniform());
        const Vec3 at =
            (u + Vec3(static_cast<double>(cell[0] - first[0]), static_cast<double>(cell[1] - first[1]),
                      static_cast<double>(cell[2] - first[2]))) /
            static_cast<double>(mask + 1);
        const Point4 off = group(at) - own(u);
        EXPECT_LE(off.head<3>().norm(), kAllowed.position + 1e-12);
        EXPECT_LE(std::abs(off[3]), kAllowed.value + 1e-12);
      }
    }
    EXPECT_GT(groups, 100);
  }
}

// Of values that are no numbers nobody knows what a group misses.
TEST(MergedCells, LeaveValuesThatAreNoNumbersAlone) {
  const Block block = random_block({9, 9, 9}, 7, 0);
  std::vector<double> values(block.points.size(), 0);
  values[block.offset(3, 3, 3)] = std::nan("");
  const MergedCells merged(block, values, CellKind::trilinear, 1, [](const Vec3&) {
    return MergeTolerance{1e-9, 1e-9};
  });
  EXPECT_EQ(merged.level({2, 2, 2}), 0);
  EXPECT_EQ(merged.level({3, 3, 3}), 0);
  EXPECT_GT(merged.level({6, 6, 6}), 0);
}

// No group holds a missing cell.
TEST(MergedCells, LeaveMissingCellsAlone) {
  Block block = random_block({9, 9, 9}, 7, 0);
  block.hidden.assign(9 * 9 * 9, 0);
  block.hidden[block.offset(4, 4, 4)] = 1;
  const std::vector<double> zeros(block.points.size(), 0);
  const MergedCells merged(block, zeros, CellKind::tricubic, 1, [](const Vec3&) {
    return MergeTolerance{1e-9, 1e-9};
  });
  EXPECT_EQ(merged.level({4, 4, 4}), 0);
  EXPECT_EQ(merged.level({2, 3, 2}), 0);
  EXPECT_EQ(merged.level({1, 1, 1}), 1);
}

}  // namespace
}  // namespace vol::curvilinear
