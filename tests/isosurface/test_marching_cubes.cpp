#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "counts.h"
#include "grids.h"
#include "isosurface/marching_cubes.h"
#include "mesh/measures.h"
#include "mesh/weld.h"
#include "oracle.h"
#include "volume/grid_sampler.h"

namespace vol::isosurface {
namespace {

using volume::Grid;
using volume::Volume;

/// Components and Euler characteristic that the border of {f >= isovalue} has, all beyond the volume outside.
struct Truth {
  std::int64_t components = 0;
  std::int64_t euler = 0;
};

/// From the cells' regions: components of the two sets by union-find over all cells; the border of a set in
/// space has a component for each pair of regions that touch, and these pairs make a tree. chi of the set by
/// inclusion and exclusion of cells, faces, edges and corners; the border has twice that.
Truth truth_of(const Volume& volume, double isovalue) {
  return volume::visit(volume, [&](const auto& grid) {
    const Dims& d = grid.dims();
    const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      return static_cast<std::size_t>(i + d[0] * (j + d[1] * k));
    };
    const std::size_t beyond = grid.voxels.size();
    oracle::UnionFind sets(beyond + 1);
    const auto inside = [&](std::size_t n) { return static_cast<double>(grid.voxels[n]) >= isovalue; };
    std::int64_t chi = 0;
    for (std::int64_t k = 0; k < d[2]; ++k) {
      for (std::int64_t j = 0; j < d[1]; ++j) {
        for (std::int64_t i = 0; i < d[0]; ++i) {
          const std::size_t here = at(i, j, k);
          const bool border = i == 0 || j == 0 || k == 0 || i + 1 == d[0] || j + 1 == d[1] || k + 1 == d[2];
          if (border && !inside(here)) sets.join(here, beyond);
          if (i + 1 == d[0] || j + 1 == d[1] || k + 1 == d[2]) continue;
          std::array<double, 8> v;
          std::array<std::size_t, 8> n;
          for (std::size_t c = 0; c < 8; ++c) {
            n[c] = at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
            v[c] = static_cast<double>(grid.voxels[n[c]]);
          }
          const oracle::Cell cell = oracle::analyse(v, isovalue);
          for (std::size_t c = 0; c < 8; ++c) sets.join(n[c], n[static_cast<std::size_t>(cell.region[c])]);
          // A tube of the outside makes the inside a ring.
          chi += cell.inside_regions - (cell.outside_face_regions - cell.outside_regions);
        }
      }
    }
    // Shared faces once too often, then edges and corners: signs of inclusion and exclusion.
    for (int a = 0; a < 3; ++a) {
      const int u = (a + 1) % 3;
      const int w = (a + 2) % 3;
      std::int64_t step[3] = {1, d[0], d[0] * d[1]};
      Dims p;
      for (p[2] = 0; p[2] < d[2]; ++p[2]) {
        for (p[1] = 0; p[1] < d[1]; ++p[1]) {
          for (p[0] = 0; p[0] < d[0]; ++p[0]) {
            const std::size_t n = at(p[0], p[1], p[2]);
            const bool interior_a = p[a] > 0 && p[a] + 1 < d[a];
            if (interior_a && p[u] + 1 < d[u] && p[w] + 1 < d[w]) {  // a face within, normal to a
              const auto f = [&](int x, int y) {
                return static_cast<double>(
                    grid.voxels[n + static_cast<std::size_t>(x * step[u] + y * step[w])]);
              };
              std::array<double, 8> v;  // the face as a cell without change across
              for (std::size_t c = 0; c < 8; ++c) v[c] = f(int(c & 1), int(c >> 1 & 1));
              chi -= oracle::analyse(v, isovalue).inside_face_regions;
            }
            const bool interior_u = p[u] > 0 && p[u] + 1 < d[u];
            const bool interior_w = p[w] > 0 && p[w] + 1 < d[w];
            if (interior_u && interior_w && p[a] + 1 < d[a]) {  // an edge within, along a
              chi += inside(n) || inside(n + static_cast<std::size_t>(step[a]));
            }
            if (a == 0 && interior_a && interior_u && interior_w) chi -= inside(n);
          }
        }
      }
    }
    Truth truth;
    std::int64_t regions = 0;
    for (std::size_t n = 0; n <= beyond; ++n) regions += sets.root(n) == n;
    truth.components = regions - 1;
    truth.euler = 2 * chi;
    return truth;
  });
}

/// A random 5 x 5 x 5 volume of one of several kinds: few values with many ties, bytes, floats, checkered.
Volume random_volume(Rng& rng, std::int64_t n, double& isovalue) {
  const Dims dims{5, 5, 5};
  isovalue = 0;
  switch (n % 4) {
    case 0:
      return make_volume<std::int8_t>(dims, [&](auto...) { return static_cast<int>(rng.below(5)) - 2; });
    case 1:
      isovalue = static_cast<double>(rng.below(8));
      return make_volume<std::uint8_t>(dims, [&](auto...) { return rng.below(8); });
    case 2:
      return make_volume<float>(dims, [&](auto...) { return rng.uniform(-1, 1); });
    default:
      return make_volume<double>(dims, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        return ((i + j + k) % 2 != 0 ? 1 : -1) * rng.uniform(-0.3, 1);
      });
  }
}

TEST(MarchingCubes, RandomVolumesAreManifoldWithTheTopologyOfTheField) {
  Rng rng(30);
  int faults = 0;
  const std::int64_t volumes = count_from_environment("PRECIS_TEST_VOLUMES", 2000);
  for (std::int64_t n = 0; n < volumes; ++n) {
    double isovalue = 0;
    const Volume volume = random_volume(rng, n, isovalue);
    const auto closed =
        mesh::topology(marching_cubes(volume, isovalue, {.close = true, .normals = false}).mesh);
    const auto open =
        mesh::topology(marching_cubes(volume, isovalue, {.close = false, .normals = false}).mesh);
    const Truth truth = truth_of(volume, isovalue);
    const bool good = closed.is_manifold() && closed.boundary_edges == 0 && open.is_manifold() &&
                      closed.components == truth.components && closed.euler == truth.euler;
    if (!good && ++faults <= 5) {
      ADD_FAILURE() << "volume " << n << ": closed " << describe(closed) << "; open " << describe(open)
                    << "; truth " << truth.components << ", chi " << truth.euler;
    }
  }
  EXPECT_EQ(faults, 0);
}

// The rim of an open surface lies on the volume's border, all of it.
TEST(MarchingCubes, OpenRimsLieOnTheBorder) {
  Rng rng(31);
  for (int n = 0; n < 40; ++n) {
    double isovalue = 0;
    const Volume volume = random_volume(rng, n, isovalue);
    const auto mesh = marching_cubes(volume, isovalue, {}).mesh;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> ways;
    for (const auto& t : mesh.triangles) {
      for (std::size_t i = 0; i < 3; ++i) ++ways[{t[i], t[(i + 1) % 3]}];
    }
    for (const auto& [edge, count] : ways) {
      if (ways.count({edge.second, edge.first}) != 0) continue;
      bool on_border = false;
      for (std::size_t a = 0; a < 3; ++a) {
        for (const double side : {0.0, 4.0}) {
          on_border =
              on_border || (mesh.positions[edge.first][a] == side && mesh.positions[edge.second][a] == side);
        }
      }
      EXPECT_TRUE(on_border) << "volume " << n;
    }
  }
}

// Integers of any type, floats and their doubles hold the same field: the same mesh, vertex by vertex.
TEST(MarchingCubes, VoxelTypesGiveTheSameMesh) {
  const auto value = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return (i * i * 7 + j * 5 + k * k * 3) % 90;
  };
  const Dims dims{71, 6, 5};  // more than a word along x
  const auto truth = marching_cubes(make_volume<double>(dims, value), 41.25).mesh;
  const auto same = [&](const Volume& volume) {
    const auto mesh = marching_cubes(volume, 41.25).mesh;
    EXPECT_EQ(mesh.triangles, truth.triangles);
    EXPECT_EQ(mesh.positions, truth.positions);
    EXPECT_EQ(mesh.normals, truth.normals);
  };
  same(make_volume<std::int8_t>(dims, value));
  same(make_volume<std::uint8_t>(dims, value));
  same(make_volume<std::int16_t>(dims, value));
  same(make_volume<std::uint16_t>(dims, value));
  same(make_volume<std::int32_t>(dims, value));
  same(make_volume<std::uint32_t>(dims, value));
  same(make_volume<float>(dims, value));
  same(make_volume<volume::half>(dims, [&](auto... p) { return static_cast<float>(value(p...)); }));
}

// 33 bytes a row and a bit a sample, in words of 8 bytes, beside the voxels: no less is enough, and no more
// is asked for.
TEST(MarchingCubes, RowsThatDoNotFitAreRefused) {
  volume::Grid<float> grid;
  grid.geometry.dims = {3, 50, 70};
  grid.voxels = Buffer<float>(3 * 50 * 70, 0.0F);
  volume::Volume volume;
  volume.grid = std::move(grid);
  constexpr std::int64_t kNeeded = 50 * 70 * 33 + 3 * 50 * 70 * 4;
  EXPECT_NO_THROW((void)marching_cubes(volume, 0.5, {.memory_limit = kNeeded}));
  EXPECT_THROW((void)marching_cubes(volume, 0.5, {.memory_limit = kNeeded - 1}), Error);
  constexpr std::int64_t kClosed = 52 * 72 * 33 + 3 * 50 * 70 * 4;
  EXPECT_NO_THROW((void)marching_cubes(volume, 0.5, {.close = true, .memory_limit = kClosed}));
  EXPECT_THROW((void)marching_cubes(volume, 0.5, {.close = true, .memory_limit = kClosed - 1}), Error);
}

TEST(MarchingCubes, ThreadsDoNotCount) {
  Rng rng(32);
  const Volume volume = make_volume<float>({67, 70, 65}, [&](auto...) { return rng.uniform(); });
  set_thread_count(1);
  const auto one = marching_cubes(volume, 0.7).mesh;
  set_thread_count(2);
  const auto two = marching_cubes(volume, 0.7).mesh;
  set_thread_count(0);
  EXPECT_EQ(one.positions, two.positions);
  EXPECT_EQ(one.normals, two.normals);
  EXPECT_EQ(one.triangles, two.triangles);
}

// World coordinates, orientation and normals, for right- and left-handed axes. Normals by central differences
// are of order 2: at 25 samples across a sphere of radius 9 within a few degrees.
TEST(MarchingCubes, SphereInAnObliqueGridPointsOutward) {
  for (const double sign : {1.0, -1.0}) {
    const auto g = oblique({29, 37, 25}, {0.9, 0.7, 1.1}, sign);
    const Vec3 centre(30.1, -4.2, 7.1);
    const Volume volume = sampled(g, [&](const Vec3& p) { return 9 - (p - centre).norm(); });
    const auto mesh = marching_cubes(volume, 0).mesh;
    const auto t = mesh::topology(mesh);
    EXPECT_TRUE(t.is_manifold()) << describe(t);
    EXPECT_EQ(t.boundary_edges, 0);
    EXPECT_EQ(t.euler, 2);
    EXPECT_GT(mesh::extent(mesh).volume, 0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec3 out = (Eigen::Map<const Vec3>(mesh.positions[v].data()) - centre) / 9;
      const Vec3 normal = Eigen::Map<const Eigen::Vector3f>(mesh.normals[v].data()).cast<double>();
      EXPECT_NEAR(out.norm(), 1, 0.01);
      EXPECT_NEAR(normal.norm(), 1, 1e-6);
      EXPECT_GT(normal.dot(out), 0.99);
    }
  }
}

// Every vertex is on the trilinear field's isosurface: its value is off by rounding, 1e-6 spacing times the
// slope, 1 here, and much less.
TEST(MarchingCubes, VerticesAreOnTheFieldsIsosurface) {
  Rng rng(33);
  const auto g = oblique({29, 28, 27}, {0.5, 2, 1}, -1);
  Volume volume = make_volume<double>(g.dims, [&](auto...) { return rng.uniform(-1, 1); });
  volume.geometry() = g;
  const auto result = marching_cubes(volume, 0.1);
  EXPECT_GT(result.counts.tubes, 0);
  volume::visit(volume, [&]<class T>(const Grid<T>& grid) {
    const volume::GridSampler<T, volume::Reconstruction::trilinear> field(grid);
    for (const auto& p : result.mesh.positions) {
      EXPECT_NEAR(field.value(Eigen::Map<const Vec3>(p.data())), 0.1, 1e-12);
    }
  });
}

// All inside and closed: the volume's box itself, whose area and volume are known to rounding.
TEST(MarchingCubes, ClosedConstantVolumeIsItsBox) {
  Volume volume = make_volume<std::uint16_t>({5, 3, 2}, [](auto...) { return 7; });
  volume.geometry().spacing = {2, 1, 0.5};
  auto mesh = marching_cubes(volume, 7, {.close = true}).mesh;  // 7 >= 7 is inside
  const auto before = mesh::topology(mesh);
  EXPECT_TRUE(before.is_manifold());
  EXPECT_EQ(before.euler, 2);
  EXPECT_EQ(before.boundary_edges, 0);
  EXPECT_NEAR(mesh::extent(mesh).volume, 8 * 2 * 0.5, 1e-12);
  EXPECT_NEAR(mesh::extent(mesh).area, 2 * (8 * 2 + 8 * 0.5 + 2 * 0.5), 1e-12);
  const auto counts = mesh::weld(mesh);
  EXPECT_GT(counts.triangles_dropped, 0);
  const auto after = mesh::topology(mesh);
  EXPECT_TRUE(after.is_manifold()) << describe(after);
  EXPECT_EQ(after.euler, 2);
  EXPECT_NEAR(mesh::extent(mesh).area, 2 * (8 * 2 + 8 * 0.5 + 2 * 0.5), 1e-12);
  EXPECT_TRUE(marching_cubes(volume, 7.5, {.close = true}).mesh.triangles.empty());
}

// An axis of one sample is one spacing thick: a disk of one slice becomes a closed box of that height.
TEST(MarchingCubes, AxesOfOneSampleAreOneSpacingThick) {
  for (int axis = 0; axis < 3; ++axis) {
    Dims dims{4, 4, 4};
    dims[static_cast<std::size_t>(axis)] = 1;
    Volume volume = make_volume<float>(dims, [](auto...) { return 1; });
    volume.geometry().spacing[axis] = 0.25;
    const auto mesh = marching_cubes(volume, 0.5, {.close = true}).mesh;
    EXPECT_NEAR(mesh::extent(mesh).volume, 9 * 0.25, 1e-12);
    Vec3 low = Vec3::Constant(1e9);
    for (const auto& p : mesh.positions) low = low.cwiseMin(Eigen::Map<const Vec3>(p.data()));
    EXPECT_EQ(low[axis], -0.125);
  }
}

// Welding joins places and drops what has no area: the same area, no new boundary.
TEST(MarchingCubes, WeldedPlateausHaveNoCrack) {
  Rng rng(34);
  for (int n = 0; n < 60; ++n) {
    const Volume volume = make_volume<std::uint8_t>({9, 8, 7}, [&](auto...) { return rng.below(4); });
    auto mesh = marching_cubes(volume, 2, {.close = true}).mesh;
    const double area = mesh::extent(mesh).area;
    const double enclosed = mesh::extent(mesh).volume;
    const auto counts = mesh::weld(mesh);
    EXPECT_GT(counts.vertices_merged, 0);
    const auto t = mesh::topology(mesh);
    EXPECT_EQ(t.boundary_edges, 0) << n;
    EXPECT_NEAR(mesh::extent(mesh).area, area, 1e-9 * area);
    EXPECT_NEAR(mesh::extent(mesh).volume, enclosed, 1e-9 * area);
  }
}

TEST(MarchingCubes, ExtremesAreRightOrAnError) {
  const Volume volume = make_volume<float>({3, 3, 3}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i == 1 && j == 1 && k == 1 ? 3e38 : -3e38;
  });
  const auto mesh = marching_cubes(volume, 0).mesh;
  EXPECT_EQ(mesh::topology(mesh).euler, 2);
  for (const auto& n : mesh.normals) EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-6);
  for (const double scale : {1e-300, 1e300}) {
    const Volume extreme =
        make_volume<double>({4, 4, 4}, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
          return ((i + j + k) % 2 != 0 ? 1 : -1) * scale;
        });
    const auto surface = marching_cubes(extreme, 0);
    const auto t = mesh::topology(surface.mesh);
    EXPECT_TRUE(t.is_manifold()) << describe(t);
    for (const auto& p : surface.mesh.positions) EXPECT_TRUE(std::isfinite(p[0] + p[1] + p[2]));
  }
  EXPECT_TRUE(marching_cubes(volume, 1e300).mesh.triangles.empty());
  EXPECT_TRUE(marching_cubes(volume, -1e300).mesh.triangles.empty());
  EXPECT_THROW((void)marching_cubes(volume, std::nan("")), Error);
  EXPECT_THROW((void)marching_cubes(volume, std::numeric_limits<double>::infinity()), Error);
}

}  // namespace
}  // namespace vol::isosurface
