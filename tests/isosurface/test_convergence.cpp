#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "grids.h"

namespace vol::isosurface {
namespace {

/// Observed orders of area and volume as the grid is refined from n to 2 n samples an edge.
struct Orders {
  double area, volume;
};
Orders observed_orders(const auto& field, double area, double volume, int euler, int components) {
  double error_area[2];
  double error_volume[2];
  for (const int level : {0, 1}) {
    const std::int64_t n = 48 << level;
    // The box stays; spacing unlike on each axis, nothing symmetric.
    const auto g = oblique({n + 1, n + n / 8 + 1, n - n / 8 + 1},
                           Vec3(24.0, 25.0, 26.0).cwiseQuotient(vec(n, n + n / 8, n - n / 8)), 1);
    const auto mesh = marching_cubes(sampled(g, field), 0, {.normals = false}).mesh;
    const auto t = mesh::topology(mesh);
    EXPECT_TRUE(t.is_manifold() && t.boundary_edges == 0) << describe(t);
    EXPECT_EQ(t.euler, euler);
    EXPECT_EQ(t.components, components);
    const auto e = mesh::extent(mesh);
    error_area[level] = std::abs(e.area / area - 1);
    error_volume[level] = std::abs(e.volume / volume - 1);
  }
  return {std::log2(error_area[0] / error_area[1]), std::log2(error_volume[0] / error_volume[1])};
}

constexpr double kPi = std::numbers::pi;
const Vec3 kCentre(30.13, -4.21, 7.07);

// Chords of a curved surface are off by order 2 in the spacing, and so are area and volume: 2 within 0.1,
// what the position of the surface in the grid adds at 48 samples.
TEST(MarchingCubes, SphereConvergesAtOrderTwo) {
  const double r = 9.3;
  const auto o = observed_orders([&](const Vec3& p) { return r - (p - kCentre).norm(); }, 4 * kPi * r * r,
                                 4 * kPi * r * r * r / 3, 2, 1);
  EXPECT_NEAR(o.area, 2, 0.1);
  EXPECT_NEAR(o.volume, 2, 0.1);
}

TEST(MarchingCubes, TorusConvergesAtOrderTwo) {
  const double ring = 6.9;
  const double tube = 2.9;
  const auto o = observed_orders(
      [&](const Vec3& p) {
        const Vec3 q = p - kCentre;
        return tube - std::hypot(std::hypot(q[0], q[1]) - ring, q[2]);
      },
      4 * kPi * kPi * ring * tube, 2 * kPi * kPi * ring * tube * tube, 0, 1);
  EXPECT_NEAR(o.area, 2, 0.1);
  EXPECT_NEAR(o.volume, 2, 0.1);
}

TEST(MarchingCubes, ShellConvergesAtOrderTwo) {
  const double outer = 9.1;
  const double inner = 6.2;
  const auto o = observed_orders(
      [&](const Vec3& p) {
        const double r = (p - kCentre).norm();
        return std::min(outer - r, r - inner);
      },
      4 * kPi * (outer * outer + inner * inner), 4 * kPi * (std::pow(outer, 3) - std::pow(inner, 3)) / 3, 4,
      2);
  EXPECT_NEAR(o.area, 2, 0.1);
  EXPECT_NEAR(o.volume, 2, 0.1);
}

}  // namespace
}  // namespace vol::isosurface
