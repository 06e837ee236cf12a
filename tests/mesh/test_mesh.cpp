#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "mesh/measures.h"
#include "mesh/weld.h"

namespace vol::mesh {
namespace {

/// The unit cube by its 12 triangles, normals outward.
TriangleMesh cube() {
  TriangleMesh mesh;
  for (int c = 0; c < 8; ++c) mesh.positions.push_back({double(c & 1), double(c >> 1 & 1), double(c >> 2)});
  const std::uint32_t quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& q : quads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

TEST(Measures, CubeIsASphere) {
  const TriangleMesh mesh = cube();
  const Topology t = topology(mesh);
  EXPECT_EQ(t.vertices, 8);
  EXPECT_EQ(t.edges, 18);
  EXPECT_EQ(t.euler, 2);
  EXPECT_EQ(t.components, 1);
  EXPECT_EQ(t.boundary_edges, 0);
  EXPECT_TRUE(t.is_manifold());
  EXPECT_DOUBLE_EQ(extent(mesh).area, 6);
  EXPECT_DOUBLE_EQ(extent(mesh).volume, 1);
}

TEST(Measures, FaultsAreSeen) {
  TriangleMesh mesh = cube();
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  EXPECT_EQ(topology(mesh).misoriented_edges, 3);

  mesh = cube();
  mesh.triangles.pop_back();  // a hole of three edges
  EXPECT_EQ(topology(mesh).boundary_edges, 3);
  EXPECT_EQ(topology(mesh).boundary_loops, 1);
  EXPECT_EQ(topology(mesh).euler, 1);

  mesh = cube();
  mesh.positions.push_back({0.5, 0.5, 2});
  mesh.triangles.push_back({4, 5, 8});  // a fin on an edge of the cube
  EXPECT_EQ(topology(mesh).non_manifold_edges, 1);

  mesh = cube();
  TriangleMesh other = cube();
  append(mesh, other);
  EXPECT_EQ(topology(mesh).components, 2);
  for (auto& t : mesh.triangles) {
    for (auto& v : t) v = v == 8 ? 7 : v;  // two cubes that share a corner
  }
  const Topology t = topology(mesh);
  EXPECT_EQ(t.components, 1);
  EXPECT_EQ(t.non_manifold_vertices, 1);
  EXPECT_EQ(t.non_manifold_edges, 0);
}

TEST(Weld, SoupBecomesTheCube) {
  const TriangleMesh whole = cube();
  TriangleMesh soup;
  for (const auto& t : whole.triangles) {
    std::array<std::uint32_t, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = static_cast<std::uint32_t>(soup.positions.size());
      soup.positions.push_back(whole.positions[t[i]]);
      soup.normals.push_back({0, 0, float(i)});
    }
    soup.triangles.push_back(corners);
  }
  soup.positions[0] = {-0.0, 0, 0};     // the same place as 0
  soup.triangles.push_back({0, 3, 1});  // 0 and 3 are one place
  const WeldCounts counts = weld(soup);
  EXPECT_EQ(counts.vertices_merged, 36 - 8);
  EXPECT_EQ(counts.triangles_dropped, 1);
  EXPECT_EQ(soup.positions.size(), 8u);
  EXPECT_EQ(soup.normals.size(), 8u);
  EXPECT_TRUE(topology(soup).is_manifold());
  EXPECT_EQ(topology(soup).euler, 2);
  EXPECT_DOUBLE_EQ(extent(soup).volume, 1);
}

TEST(Weld, FlatTrianglesStayAndAreCounted) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(weld(mesh).flat_triangles, 1);
  EXPECT_EQ(mesh.triangles.size(), 2u);
}

// Sizes whose squares, but not whose products, are below the smallest double.
TEST(Measures, SmallMeshesHaveAreas) {
  TriangleMesh mesh = cube();
  for (auto& p : mesh.positions) {
    for (double& x : p) x *= 1e-90;
  }
  EXPECT_NEAR(extent(mesh).area / 6e-180, 1, 1e-12);
  EXPECT_NEAR(extent(mesh).volume / 1e-270, 1, 1e-12);
  EXPECT_EQ(weld(mesh).flat_triangles, 0);
}

TEST(RoundToFloat, RefusesWhatFloatsCannotTellApart) {
  const auto moved = [](double scale, double by) {
    TriangleMesh mesh = cube();
    for (auto& p : mesh.positions) {
      for (double& x : p) x = scale * x + by;
    }
    return mesh;
  };
  TriangleMesh mesh = moved(1, 0);
  EXPECT_NO_THROW(round_to_float(mesh, 1));
  mesh = moved(1, 8000);  // floats 2^-11 apart
  EXPECT_NO_THROW(round_to_float(mesh, 1));
  mesh = moved(1, -8000);
  EXPECT_THROW(round_to_float(mesh, 0.4), Error);
  mesh = moved(1, 1e9);
  EXPECT_THROW(round_to_float(mesh, 1), Error);
  mesh = moved(0.01, 5e6);
  EXPECT_THROW(round_to_float(mesh, 0.01), Error);
  mesh = moved(1e38, 3e38);
  EXPECT_THROW(round_to_float(mesh, 1e38), Error);
  EXPECT_NO_THROW(require_finite(mesh));
  mesh = moved(1e-60, 0);  // floats are 1e-45 apart there
  EXPECT_THROW(round_to_float(mesh, 1e-60), Error);
  mesh.positions[3][1] = std::nan("");
  EXPECT_THROW(round_to_float(mesh, 1), Error);
  EXPECT_THROW(require_finite(mesh), Error);
}

TEST(Append, MeshesMustBeAlike) {
  TriangleMesh mesh = cube();
  TriangleMesh with_normals = cube();
  with_normals.normals.resize(8);
  EXPECT_THROW(append(mesh, with_normals), Error);
}

}  // namespace
}  // namespace vol::mesh
