#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "base/error.h"
#include "curvilinear/flow.h"
#include "curvilinear/phantom.h"
#include "curvilinear/quality.h"

namespace vol::curvilinear {
namespace {

constexpr double kPi = std::numbers::pi;

/// The volume of a phantom's solid in closed form; 0 where it has none that is simple.
double volume_of(std::string_view name) {
  if (name == "half-torus") return kPi * 2;  // Pappus: radius 2, section 1
  if (name == "spherical-shell") return 4.0 / 3 * kPi * 7;
  if (name == "twisted-box") return 8;
  if (name == "c-grid") return 0.75 * kPi * (2.25 - 0.25 / 3);  // 3/4 turn: integral of 1.5^2 - (1-w)^2/4
  if (name == "sheared-box") {
    Mat3 edges;
    edges << 1.9, 0.8, -0.5, 0.3, 1.4, 0.6, -0.2, 0.1, 1.7;
    return edges.determinant();
  }
  return 0;
}

TEST(Phantom, IsRightHandedAndItsVolumeConverges) {
  for (const auto& phantom : phantom_names()) {
    double error[2] = {};
    for (const int n : {0, 1}) {
      const std::int64_t points = n == 0 ? 13 : 25;
      const Quality q = quality(make_phantom(phantom.name, {points, points, points}, "ramp", 1).blocks[0]);
      EXPECT_GT(q.volume, 0) << phantom.name;
      EXPECT_EQ(q.inverted, 0) << phantom.name;
      EXPECT_EQ(q.missing, 0);
      error[n] = std::abs(q.volume - volume_of(phantom.name));
    }
    if (volume_of(phantom.name) == 0) continue;
    if (phantom.name == "sheared-box") {
      EXPECT_LT(error[1], 1e-12);  // affine: exact
    } else {
      // Order 2: a factor of 4, from which higher orders take little at 12 cells.
      EXPECT_GT(error[0] / error[1], 3.5) << phantom.name << " " << error[0] << " " << error[1];
      EXPECT_LT(error[0] / error[1], 4.5) << phantom.name;
    }
  }
}

TEST(Phantom, CollapsesWhereItSaysItDoes) {
  // Poles: two edges of latitude of each of 2 x 4 layers by 8 of longitude; both layers of the cell row at a
  // pole.
  EXPECT_EQ(quality(make_phantom("spherical-shell", {5, 7, 9}, "ramp", 1).blocks[0]).collapsed, 2 * 4 * 8);
  // The last layer in k, at the inner radius: one row of cells along i.
  EXPECT_EQ(quality(make_phantom("c-grid", {9, 4, 5}, "ramp", 1).blocks[0]).collapsed, 8);
  EXPECT_EQ(quality(make_phantom("twisted-box", {9, 4, 5}, "ramp", 1).blocks[0]).collapsed, 0);
  EXPECT_EQ(quality(make_phantom("half-torus", {0, 0, 0}, "ramp", 1).blocks[0]).folded, 0);
}

TEST(Phantom, SeamsMeetToTheBit) {
  const Block block = make_phantom("spherical-shell", {3, 5, 9}, "ramp", 1).blocks[0];
  for (std::int64_t j = 0; j < 5; ++j)
    EXPECT_EQ(block.points[block.offset(1, j, 0)], block.points[block.offset(1, j, 8)]);
}

TEST(Quality, FindsAFoldedCell) {
  Grid grid = make_phantom("twisted-box", {5, 5, 5}, "ramp", 1);
  Block& block = grid.blocks[0];
  block.points[block.offset(2, 2, 2)] += Vec3(0.9, 0, 0);  // beyond its neighbour, half a cell further
  const Quality q = quality(block);
  EXPECT_GT(q.folded, 0);
  block.hidden.assign(block.points.size(), 0);
  block.hidden[block.offset(2, 2, 2)] = 1;
  EXPECT_EQ(quality(block).missing, 8);
}

/// A flow in closed form at the points of a curved grid.
Grid flow(const std::function<Vec3(const Vec3&)>& velocity, double density, double pressure) {
  Grid grid = make_phantom("half-torus", {33, 9, 9}, "ramp", 1);
  Block& block = grid.blocks[0];
  block.arrays.clear();
  for (const auto& name : kConserved) block.arrays.push_back({std::string(name), {}});
  for (const Vec3& p : block.points) {
    const Vec3 m = density * velocity(p);
    block.arrays[0].values.push_back(density);
    for (int a = 0; a < 3; ++a) block.arrays[static_cast<std::size_t>(a + 1)].values.push_back(m[a]);
    block.arrays[4].values.push_back(pressure / 0.4 + 0.5 * m.squaredNorm() / density);
  }
  return grid;
}

TEST(Flow, VariablesOfAUniformStream) {
  // The free stream of PLOT3D at Mach 2: density 1, speed of sound 1, so p = 1/1.4.
  const Grid grid = flow([](const Vec3&) { return Vec3(1.2, -1.6, 0); }, 1, 1 / 1.4);
  const auto at = [&](const char* name) { return make_variable(grid, name)[0][7]; };
  EXPECT_NEAR(at("mach"), 2, 1e-13);
  EXPECT_NEAR(at("pressure"), 1 / 1.4, 1e-13);
  EXPECT_NEAR(at("temperature"), 1, 1e-13);
  EXPECT_NEAR(at("entropy"), 0, 1e-13);
  EXPECT_NEAR(at("velocity-magnitude"), 2, 1e-13);
  EXPECT_NEAR(at("velocity.y"), -1.6, 1e-13);
  EXPECT_NEAR(at("vorticity-magnitude"), 0, 1e-10);
}

TEST(Flow, VorticityOfARotationIsTwiceItsRate) {
  const Vec3 rate(0.3, -0.4, 1.2);
  const Grid grid = flow([&](const Vec3& p) { return rate.cross(p); }, 1.7, 100);
  // The velocity is linear in the position, which the differences take the same way: exact to rounding.
  const auto vorticity = make_variable(grid, "vorticity-magnitude");
  for (const double w : vorticity[0]) EXPECT_NEAR(w, 2 * rate.norm(), 1e-10);
}

TEST(Flow, SaysWhatAFileCannotGive) {
  Grid grid = flow([](const Vec3&) { return Vec3(1, 0, 0); }, 1, 1);
  EXPECT_THROW((void)make_variable(grid, "helicity"), Error);
  grid.blocks[0].arrays[4].values.assign(grid.blocks[0].points.size(), 0);
  EXPECT_THROW((void)make_variable(grid, "pressure"), Error);
  EXPECT_NO_THROW((void)make_variable(grid, "velocity-magnitude"));
  grid.blocks[0].arrays[0].values[3] = 0;
  EXPECT_THROW((void)make_variable(grid, "velocity-magnitude"), Error);
}

TEST(Grid, ARegionHasItsCells) {
  const Block all = make_phantom("c-grid", {6, 4, 5}, "ramp", 1).blocks[0];
  const Block part = cropped(all, {1, 0, 2}, {4, 3, 3});
  EXPECT_EQ(part.dims, (Dims{4, 4, 2}));
  EXPECT_EQ(part.points[part.offset(3, 1, 1)], all.points[all.offset(4, 1, 3)]);
  EXPECT_EQ(part.arrays[0].values[part.offset(0, 3, 0)], all.arrays[0].values[all.offset(1, 3, 2)]);
  EXPECT_THROW((void)cropped(all, {0, 0, 0}, {6, 3, 4}), Error);
}

TEST(Grid, FlatAndBrokenOnesAreRefused) {
  Grid grid = make_phantom("twisted-box", {3, 3, 3}, "ramp", 1);
  EXPECT_NO_THROW(require_valid(grid));
  grid.blocks[0].points[4].y() = std::nan("");
  EXPECT_THROW(require_valid(grid), Error);
  EXPECT_THROW((void)make_phantom("twisted-box", {3, 1, 3}, "ramp", 1), Error);
  EXPECT_THROW((void)make_phantom("delta-wing", {4, 5, 3}, "ramp", 1), Error);  // half a turn has z = 0
}

}  // namespace
}  // namespace vol::curvilinear
