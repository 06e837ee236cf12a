#include <gtest/gtest.h>

#include <limits>

#include "base/rng.h"
#include "curvilinear/phantom.h"
#include "curvilinear/solid_path.h"

namespace vol::curvilinear {
namespace {

Vec3 random_vector(Rng& random) {
  return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

/// A grid whose points are jittered: 1.5 of the spacing folds many of its solids.
Grid jittered(double jitter) {
  Grid grid = make_phantom("sheared-box", {5, 4, 6}, "constant", 1);
  Rng random(4);
  for (Vec3& p : grid.blocks[0].points) p += 0.25 * jitter * random_vector(random);
  return grid;
}

// A field whose values are a linear function of the points' positions is that function in every solid, since
// positions and values go through the same operator (beta is any): along a ray it is linear in t, whatever
// the parameters do, at collapsed edges and in folds as well, where a wrong preimage would show as a wrong
// value. To 1e-11 of values of size 5: positions of size 3 are met to 1e-15 and less well by the map's
// condition.
TEST(SolidPath, LinearFunctionsOfThePositionAreLinearAlongRays) {
  struct Case {
    const char* name;
    Grid grid;
    double beta;
  };
  std::vector<Case> cases;
  cases.push_back({"twisted box", make_phantom("twisted-box", {3, 4, 5}, "constant", 1), 1});
  cases.push_back({"c-grid", make_phantom("c-grid", {9, 4, 5}, "constant", 1), 1});
  cases.push_back({"spherical shell", make_phantom("spherical-shell", {3, 7, 9}, "constant", 1), 1});
  cases.push_back({"delta wing", make_phantom("delta-wing", {5, 6, 9}, "constant", 1), 0.7});
  cases.push_back({"bent", jittered(0.5), 1});
  cases.push_back({"folded", jittered(1.5), 1});
  Rng random(5);
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const auto f = [](const Vec3& p) { return 1.3 + p.dot(Vec3(0.9, -0.8, 0.4)); };
    std::vector<std::vector<double>> values(1);
    for (const Vec3& p : c.grid.blocks[0].points) values[0].push_back(f(p));
    for (const auto kind : {CellKind::tricubic, CellKind::trilinear}) {
      const SolidRays rays(c.grid, values, kind, c.beta);
      const Box3& box = rays.faces().bounds();
      RayScratch scratch;
      std::vector<RaySegment> segments;
      int pieces = 0, evaluations = 0;
      double worst = 0;
      for (int n = 0; n < 100; ++n) {
        const Vec3 target = box.centre() + 0.4 * box.size().cwiseProduct(random_vector(random));
        const Vec3 direction = random_vector(random).normalized();
        const camera::Ray ray{target - 5 * direction, direction};
        rays.segments(ray, -std::numeric_limits<double>::infinity(), scratch, segments);
        for (const RaySegment& s : segments) {
          const Solid solid = rays.solid(s.in);
          SolidPath path(solid, ray, s.in, rays.handedness(0));
          double reached = s.t0;
          EXPECT_TRUE(path.pieces(s.t0, s.t1, 1e-12, [&](const render::RayPiece& piece) {
            EXPECT_EQ(piece.t0, reached);
            reached = piece.t1;
            ++pieces;
            for (const double u : {0.0, 0.21, 0.5, 0.87, 1.0}) {
              const double t = piece.t0 + u * (piece.t1 - piece.t0);
              worst = std::max(worst, std::abs(piece.p(u) - f(ray.origin + t * ray.direction)));
            }
            return true;
          }));
          EXPECT_EQ(reached, s.t1);
          evaluations += static_cast<int>(path.evaluations());
        }
      }
      EXPECT_LT(worst, 1e-11);
      EXPECT_GT(pieces, 100);
      RecordProperty("evaluations", evaluations);
    }
  }
}

// The gradient is that of the linear function, by the map's Jacobian: to 1e-9 where the map is far from
// singular.
TEST(SolidPath, GradientOfALinearFunction) {
  const Grid grid = make_phantom("twisted-box", {3, 4, 5}, "constant", 1);
  const Vec3 slope(0.9, -0.8, 0.4);
  std::vector<std::vector<double>> values(1);
  for (const Vec3& p : grid.blocks[0].points) values[0].push_back(p.dot(slope));
  const SolidRays rays(grid, values, CellKind::tricubic, 1);
  RayScratch scratch;
  std::vector<RaySegment> segments;
  const camera::Ray ray{{0.1, 0.2, 5}, Vec3(0.05, -0.1, -1).normalized()};
  rays.segments(ray, 0, scratch, segments);
  EXPECT_GE(segments.size(), 4u);
  for (const RaySegment& s : segments) {
    const Solid solid = rays.solid(s.in);
    SolidPath path(solid, ray, s.in, rays.handedness(0));
    EXPECT_LT((path.gradient(0.3 * s.t0 + 0.7 * s.t1) - slope).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace vol::curvilinear
