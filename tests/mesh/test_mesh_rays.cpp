#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.h"
#include "base/rng.h"
#include "mesh/mesh_rays.h"

namespace vol::mesh {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vec3 at(const TriangleMesh& mesh, std::uint32_t v) {
  return Eigen::Map<const Vec3>(mesh.positions[v].data());
}

/// A ball of triangles: an octahedron, each triangle split in four `times` times, vertices moved a little.
TriangleMesh lumpy_ball(int times, Rng& rng) {
  TriangleMesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (const std::uint32_t x : {0u, 1u}) {
    for (const std::uint32_t y : {2u, 3u}) {
      for (const std::uint32_t z : {4u, 5u}) {
        const bool odd = ((x + y + z) & 1u) != 0;
        mesh.triangles.push_back(odd ? std::array{x, z, y} : std::array{x, y, z});
      }
    }
  }
  for (int n = 0; n < times; ++n) {
    std::vector<std::array<std::uint32_t, 3>> edges;  // low, high, middle
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      for (const auto& e : edges) {
        if (e[0] == std::min(a, b) && e[1] == std::max(a, b)) return e[2];
      }
      const Vec3 p = (at(mesh, a) + at(mesh, b)).normalized() * rng.uniform(0.95, 1.05);
      mesh.positions.push_back({p[0], p[1], p[2]});
      const auto v = static_cast<std::uint32_t>(mesh.positions.size() - 1);
      edges.push_back({std::min(a, b), std::max(a, b), v});
      return v;
    };
    Buffer<std::array<std::uint32_t, 3>> finer;
    for (const auto& t : mesh.triangles) {
      const std::uint32_t m[3] = {middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])};
      finer.push_back({t[0], m[0], m[2]});
      finer.push_back({m[0], t[1], m[1]});
      finer.push_back({m[2], m[1], t[2]});
      finer.push_back({m[0], m[1], m[2]});
    }
    mesh.triangles = finer;
  }
  return mesh;
}

std::vector<MeshRays::Hit> all_hits(const MeshRays& rays, const Vec3& origin, const Vec3& direction) {
  std::vector<MeshRays::Hit> hits;
  rays.for_hits(origin, direction, -kInfinity, kInfinity, [&](const MeshRays::Hit& hit) {
    hits.push_back(hit);
    return kInfinity;
  });
  std::sort(hits.begin(), hits.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return hits;
}

/// Hits whose triangle faces the ray less those whose triangle faces away.
int balance(const MeshRays& rays, const Vec3& direction, const std::vector<MeshRays::Hit>& hits) {
  int sum = 0;
  for (const auto& hit : hits) {
    const auto& t = rays.mesh().triangles[hit.triangle];
    const Vec3 a = at(rays.mesh(), t[0]);
    const Vec3 normal = (at(rays.mesh(), t[1]) - a).cross(at(rays.mesh(), t[2]) - a);
    sum += normal.dot(direction) < 0 ? 1 : -1;
  }
  return sum;
}

/// As many ways in as out, and never past.
void expect_closed(const TriangleMesh& mesh, const Vec3& centre, Rng& rng) {
  const MeshRays rays(mesh);
  int through = 0;
  for (const auto& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) {
      const Vec3 v = at(mesh, t[static_cast<std::size_t>(c)]);
      const Vec3 next = at(mesh, t[static_cast<std::size_t>((c + 1) % 3)]);
      for (const Vec3& target : {v, Vec3(0.5 * (v + next)), Vec3(0.25 * v + 0.75 * next)}) {
        Vec3 d(rng.normal(), rng.normal(), rng.normal());
        if (rng.below(4) == 0) d = Vec3::Unit(static_cast<Eigen::Index>(rng.below(3)));
        d.normalize();
        const Vec3 origin = target - 4 * d;
        const auto hits = all_hits(rays, origin, d);
        EXPECT_EQ(balance(rays, d, hits), 0);
        EXPECT_EQ(hits.size() % 2, 0u);
        // Well within the outline the ray cannot pass by.
        const Vec3 from_centre = target - centre;
        if ((from_centre - from_centre.dot(d) * d).norm() < 0.8) {
          ++through;
          EXPECT_GE(hits.size(), 2u);
        }
      }
    }
  }
  EXPECT_GT(through, 1000);
}

// Through the vertices and the middles of edges of a closed mesh, along axes, edges and anyhow. A direction
// in a triangle's plane has no sign there; none of these is.
TEST(MeshRays, ClosedMeshesAreLeftAsOftenAsEntered) {
  Rng rng(11);
  expect_closed(lumpy_ball(3, rng), Vec3::Zero(), rng);
}

// And far from the world's origin, where coordinates are coarse, with a vertex beyond all that nothing has.
TEST(MeshRays, ClosedMeshesAreSoFarFromTheOrigin) {
  Rng rng(13);
  TriangleMesh mesh = lumpy_ball(3, rng);
  const Vec3 centre(1e8, -3e6, 5e9);
  for (auto& p : mesh.positions) {
    for (std::size_t a = 0; a < 3; ++a) p[a] += centre[static_cast<Eigen::Index>(a)];
  }
  mesh.positions.push_back({9e99, 0, 0});
  expect_closed(mesh, centre, rng);
}

// The tree spares a ray most triangles; vertices that no triangle has, and one triangle far away, change
// nothing.
TEST(MeshRays, OneFarVertexDoesNotUndoTheTree) {
  Rng rng(14);
  const TriangleMesh near = lumpy_ball(4, rng);  // 2048 triangles
  TriangleMesh unused = near;
  unused.positions.push_back({9e99, -9e99, 0});
  TriangleMesh used = near;
  const auto first = static_cast<std::uint32_t>(near.positions.size());
  for (int c = 0; c < 3; ++c) used.positions.push_back({9e99, c * 1e90, c == 1 ? 1e90 : 0.0});
  used.triangles.push_back({first, first + 1, first + 2});
  const MeshRays plain(near), with_unused(unused), with_used(used);
  std::int64_t tried[3] = {};
  constexpr int kRays = 200;
  for (int r = 0; r < kRays; ++r) {
    const Vec3 d = Vec3(rng.normal(), rng.normal(), rng.normal()).normalized();
    const Vec3 origin = 0.5 * Vec3(rng.normal(), rng.normal(), rng.normal()) - 5 * d;
    tried[0] += plain.tried(origin, d);
    tried[1] += with_unused.tried(origin, d);
    tried[2] += with_used.tried(origin, d);
    const auto hits = all_hits(plain, origin, d);
    for (const MeshRays* other : {&with_unused, &with_used}) {
      const auto same = all_hits(*other, origin, d);
      ASSERT_EQ(same.size(), hits.size());
      for (std::size_t n = 0; n < hits.size(); ++n) EXPECT_EQ(same[n].t, hits[n].t);
    }
  }
  EXPECT_LT(tried[0], kRays * 2048 / 10);
  EXPECT_EQ(tried[1], tried[0]);
  EXPECT_LT(tried[2], 2 * tried[0]);  // other splits, of the same triangles
}

// On whole-number coordinates, where rays meet vertices and edges exactly: one hit on a plane of squares, at
// its depth, wherever the ray goes.
TEST(MeshRays, SharedEdgesAndVerticesAreMetOnce) {
  TriangleMesh mesh;
  constexpr int kEdge = 6;
  for (int y = 0; y <= kEdge; ++y) {
    for (int x = 0; x <= kEdge; ++x) mesh.positions.push_back({double(x), double(y), 0.5 * x});
  }
  for (std::uint32_t y = 0; y < kEdge; ++y) {
    for (std::uint32_t x = 0; x < kEdge; ++x) {
      const std::uint32_t a = x + (kEdge + 1) * y, b = a + kEdge + 1;
      mesh.triangles.push_back((x + y) % 2 == 0 ? std::array{a, a + 1, b} : std::array{a, b + 1, b});
      mesh.triangles.push_back((x + y) % 2 == 0 ? std::array{a + 1, b + 1, b} : std::array{a, a + 1, b + 1});
    }
  }
  const MeshRays rays(mesh);
  for (const double step : {1.0, 0.5, 0.25}) {
    for (double y = step; y < kEdge; y += step) {
      for (double x = step; x < kEdge; x += step) {
        for (const double side : {-1.0, 1.0}) {
          const auto hits = all_hits(rays, Vec3(x, y, 8 * side), Vec3(0, 0, -side));
          ASSERT_EQ(hits.size(), 1u) << x << ' ' << y;
          EXPECT_EQ(hits[0].t, 8 - side * 0.5 * x);  // dyadic throughout: exact
        }
      }
    }
  }
}

/// Where the line through a triangle's plane passes within it, in long double and without a box (Moeller and
/// Trumbore 1997); `sure` unless it is closer to an edge than rounding tells.
std::optional<double> met(const TriangleMesh& mesh, std::uint32_t triangle, const Vec3& origin,
                          const Vec3& direction, bool& sure) {
  using V = Eigen::Matrix<long double, 3, 1>;
  const auto& t = mesh.triangles[triangle];
  const V a = at(mesh, t[0]).cast<long double>();
  const V e1 = at(mesh, t[1]).cast<long double>() - a;
  const V e2 = at(mesh, t[2]).cast<long double>() - a;
  const V d = direction.cast<long double>();
  const V s = origin.cast<long double>() - a;
  const V p = d.cross(e2);
  const V q = s.cross(e1);
  const long double det = e1.dot(p);
  const long double weight[3] = {s.dot(p) / det, d.dot(q) / det, 1 - (s.dot(p) + d.dot(q)) / det};
  const long double least = std::min({weight[0], weight[1], weight[2]});
  sure = std::abs(least) > 1e-9L;  // doubles of 1e1 over edges of 1e-1 at slopes of 1e-4
  if (!(least >= 0)) return std::nullopt;
  return static_cast<double>(e2.dot(q) / det);
}

// The tree leaves nothing out and adds nothing: as each triangle says for itself, where no box is asked.
TEST(MeshRays, TreeFindsWhatEachTriangleSays) {
  Rng rng(12);
  TriangleMesh mesh;
  for (std::uint32_t n = 0; n < 300; ++n) {
    const Vec3 centre(rng.normal(), 5 * rng.normal(), rng.normal());
    for (int c = 0; c < 3; ++c) {
      mesh.positions.push_back({centre[0] + 0.5 * rng.normal(), centre[1] + 0.5 * rng.normal(),
                                rng.below(3) == 0 ? 1 : centre[2] + 0.5 * rng.normal()});
    }
    mesh.triangles.push_back({3 * n, 3 * n + 1, 3 * n + 2});
  }
  const MeshRays rays(mesh);
  std::size_t total = 0;
  int unsure = 0;
  for (int r = 0; r < 400; ++r) {
    const Vec3 origin(rng.normal(), 5 * rng.normal(), rng.normal());
    Vec3 d(rng.normal(), rng.normal(), rng.normal());
    if (rng.below(3) == 0) d[static_cast<Eigen::Index>(rng.below(3))] = 0;
    d.normalize();
    const auto hits = all_hits(rays, origin, d);
    total += hits.size();
    std::vector<double> alone;
    for (std::uint32_t n = 0; n < 300; ++n) {
      bool sure = true;
      const auto t = met(mesh, n, origin, d, sure);
      unsure += !sure;
      if (t) alone.push_back(*t);
    }
    if (unsure > 0) break;
    std::sort(alone.begin(), alone.end());
    ASSERT_EQ(hits.size(), alone.size());
    for (std::size_t n = 0; n < hits.size(); ++n) {
      EXPECT_NEAR(hits[n].t, alone[n], 1e-11);  // as the positions below
      // The corners' mean by their weights is the point on the ray; coordinates are below 20, 1e-13 some 50
      // ulp; triangles seen under a slope of 1e-2 magnify that by as much.
      const auto& t = mesh.triangles[hits[n].triangle];
      Vec3 p = Vec3::Zero();
      for (std::size_t c = 0; c < 3; ++c) p += hits[n].weight[c] * at(mesh, t[c]);
      EXPECT_LT((p - origin - hits[n].t * d).norm(), 1e-11);
    }
    if (hits.size() > 1) {  // and with a narrower range what lies in it
      std::size_t within = 0;
      rays.for_hits(origin, d, hits[0].t, hits[1].t, [&](const MeshRays::Hit&) {
        ++within;
        return hits[1].t;
      });
      EXPECT_EQ(within, 2u);
    }
  }
  EXPECT_EQ(unsure, 0);
  EXPECT_GT(total, 400u);
}

TEST(MeshRays, NormalsAreInterpolatedOrTheTriangles) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const auto hit = all_hits(MeshRays(mesh), Vec3(0.25, 0.5, 3), Vec3(0, 0, -1)).at(0);
  EXPECT_EQ(hit.t, 3);
  EXPECT_EQ(hit.weight, (std::array<double, 3>{0.25, 0.25, 0.5}));
  EXPECT_EQ(MeshRays(mesh).normal(hit), Vec3(0, 0, 1));
  mesh.normals = {{1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Vec3 expected = Vec3(0.5, 0.5, 0).normalized();
  EXPECT_LT((MeshRays(mesh).normal(hit) - expected).norm(), 1e-15);
  mesh.normals = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  EXPECT_EQ(MeshRays(mesh).normal(hit), Vec3(0, 0, 1));
}

TEST(MeshRays, WhatIsNoMeshIsRefused) {
  TriangleMesh mesh;
  EXPECT_TRUE(all_hits(MeshRays(mesh), Vec3::Zero(), Vec3(0, 0, 1)).empty());
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 3}};
  EXPECT_THROW(MeshRays{mesh}, Error);
  mesh.triangles = {{0, 1, 2}, {1, 1, 2}};  // the second without area
  EXPECT_EQ(all_hits(MeshRays(mesh), Vec3(0.1, 0.1, 1), Vec3(0, 0, -1)).size(), 1u);
  mesh.normals = {{0, 0, 1}};  // of the first vertex alone
  EXPECT_THROW(MeshRays{mesh}, Error);
  mesh.normals.clear();
  mesh.positions[1][2] = std::nan("");
  EXPECT_THROW(MeshRays{mesh}, Error);
}

}  // namespace
}  // namespace vol::mesh
