#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "base/rng.h"
#include "counts.h"
#include "isosurface/cell_surface.h"
#include "oracle.h"

namespace vol::isosurface {
namespace {

std::string text_of(const CellValues& cell) {
  std::string text;
  for (const double v : cell.value) text += std::to_string(v) + " ";
  return text + "at " + std::to_string(cell.isovalue);
}

struct Betti {
  int components = 0;
  int euler = 0;
  int loops = 0;
  std::string fault;  ///< of the complex, or of its rim
};

/// The cell's triangles as a complex: an oriented manifold whose rim is the case's loops, no edge of which
/// but the rim's lies in a face.
Betti betti_of(const CellSurface& surface) {
  Betti result;
  std::map<std::pair<int, int>, int> ways;
  std::set<int> vertices;
  for (int t = 0; t < surface.triangle_count; ++t) {
    const auto& c = surface.triangles[static_cast<std::size_t>(t)];
    for (std::size_t i = 0; i < 3; ++i) {
      vertices.insert(c[i]);
      if (++ways[{c[i], c[(i + 1) % 3]}] > 1) result.fault = "an edge runs twice the same way";
      if (c[i] == c[(i + 1) % 3]) result.fault = "a triangle has a corner twice";
    }
  }
  const auto faces = [](int e) -> std::set<int> {
    if (e >= 12) return {};
    const int a = e / 4;
    return {2 * ((a + 1) % 3) + (e & 1), 2 * ((a + 2) % 3) + (e >> 1 & 1)};
  };
  const auto share_face = [&](int a, int b) {
    for (const int f : faces(a)) {
      if (faces(b).count(f) != 0) return true;
    }
    return false;
  };
  int edges = 0;
  std::map<int, int> rim;
  for (const auto& [edge, n] : ways) {
    const bool paired = ways.count({edge.second, edge.first}) != 0;
    if (!paired || edge.first < edge.second) ++edges;
    if (!paired && !rim.emplace(edge.first, edge.second).second) result.fault = "two rims meet";
    if (paired && share_face(edge.first, edge.second)) result.fault = "an inner edge lies in a face";
    if (!paired && !share_face(edge.first, edge.second)) result.fault = "a rim's edge leaves the faces";
  }
  result.euler = static_cast<int>(vertices.size()) - edges + surface.triangle_count;
  oracle::UnionFind sets(24);
  for (const auto& [edge, n] : ways)
    sets.join(static_cast<std::size_t>(edge.first), static_cast<std::size_t>(edge.second));
  std::set<std::size_t> roots;
  for (const int v : vertices) roots.insert(sets.root(static_cast<std::size_t>(v)));
  result.components = static_cast<int>(roots.size());
  while (!rim.empty()) {
    ++result.loops;
    for (auto at = rim.begin(); at != rim.end();) {
      const int next = at->second;
      rim.erase(at);
      at = rim.find(next);
    }
  }
  return result;
}

/// "" where the mesher's surface of a cell has the oracle's Betti numbers.
std::string difference(const CellValues& cell, const oracle::Cell& truth) {
  const CellDecision decision = decide(cell);
  CellSurface surface;
  make_surface(cell, decision, surface);
  const Betti betti = betti_of(surface);
  if (!betti.fault.empty()) return betti.fault + ": " + text_of(cell);
  const CellSize size = surface_size(CellCases::all()[decision.number], decision);
  if (size.triangles != surface.triangle_count || size.points != surface.point_count)
    return "size: " + text_of(cell);
  // Loops, surfaces and regions of a ball make trees; every component has genus 0: chi = 2 - rims of each.
  const int euler = 2 * truth.surfaces() - truth.loops();
  if (betti.loops != truth.loops() || betti.components != truth.surfaces() || betti.euler != euler) {
    return "loops " + std::to_string(betti.loops) + " for " + std::to_string(truth.loops()) +
           ", components " + std::to_string(betti.components) + " for " + std::to_string(truth.surfaces()) +
           ", chi " + std::to_string(betti.euler) + " for " + std::to_string(euler) + ": " + text_of(cell);
  }
  for (int i = 0; i < surface.point_count; ++i) {
    const Vec3& p = surface.points[static_cast<std::size_t>(i)];
    if (!((p.array() >= 0).all() && (p.array() <= 1).all()))
      return "a point outside the cell: " + text_of(cell);
  }
  return "";
}

// All 5^8 cells of corners -2 .. 2: ties at corners, on faces and at the saddles within, among them the
// saddle exactly at the isovalue with both signs of the Hessian's determinant.
TEST(Cell, AllSmallWholeNumbersHaveTheTopologyOfTheField) {
  int faults = 0;
  int tubes = 0;
  for (int n = 0; n < 390625; ++n) {
    CellValues cell;
    for (int c = 0, rest = n; c < 8; ++c, rest /= 5) cell.value[static_cast<std::size_t>(c)] = rest % 5 - 2;
    const oracle::Cell truth = oracle::analyse(cell.value, 0);
    const std::string said = difference(cell, truth);
    tubes += truth.surfaces() < truth.loops();
    if (!said.empty() && ++faults <= 5) ADD_FAILURE() << said;
  }
  EXPECT_EQ(faults, 0);
  EXPECT_GT(tubes, 1000);  // or nothing was tested
}

// Continuous values, and values of few bits at an isovalue that is none of them; some near ties.
TEST(Cell, RandomCellsHaveTheTopologyOfTheField) {
  Rng rng(20);
  int faults = 0;
  int tubes = 0;
  const std::int64_t cells = count_from_environment("PRECIS_TEST_CELLS", 100000);
  for (std::int64_t n = 0; n < cells; ++n) {
    CellValues cell;
    const bool alternating = n % 2 == 1;  // the cases with most loops
    for (std::size_t c = 0; c < 8; ++c) {
      const double sign = (((c & 1) + (c >> 1 & 1) + (c >> 2)) % 2) != 0 ? 1 : -1;
      const double v = alternating ? sign * rng.uniform(-0.2, 1) : rng.uniform(-1, 1);
      cell.value[c] = n % 5 == 0 ? std::round(16 * v) : v;
    }
    cell.isovalue =
        n % 5 == 0 ? static_cast<double>(static_cast<int>(rng.below(9)) - 4) : 0.125 * rng.uniform(-1, 1);
    const oracle::Cell truth = oracle::analyse(cell.value, cell.isovalue);
    if (truth.margin > 0 && truth.margin < 1e-18)
      continue;  // neither a tie nor told by the oracle's tolerance
    const std::string said = difference(cell, truth);
    tubes += truth.surfaces() < truth.loops();
    if (!said.empty() && ++faults <= 5) ADD_FAILURE() << said;
  }
  EXPECT_EQ(faults, 0);
  EXPECT_GT(tubes, cells / 1000);
}

// A lattice on the cell connects along its lines only what is connected, so it never shows fewer regions than
// there are; a fine enough one shows no more. Saddles are kept 1e-3 of the range off the isovalue, so that a
// bridge is not thinner than the finest lattice: |f - f(s)| <= 3 h |f_xy| near the saddle.
TEST(Cell, SubdividedCellsHaveAsManyRegions) {
  Rng rng(21);
  int tubes = 0;
  int finer = 0;
  const std::int64_t cells = count_from_environment("PRECIS_TEST_SUBDIVIDED", 2000);
  for (std::int64_t n = 0; n < cells;) {
    CellValues cell;
    for (std::size_t c = 0; c < 8; ++c) {
      const double sign = (((c & 1) + (c >> 1 & 1) + (c >> 2)) % 2) != 0 ? 1 : -1;
      cell.value[c] = n % 2 == 1 ? sign * rng.uniform(-0.2, 1) : rng.uniform(-1, 1);
      // Two opposite corners inside, the saddle between them near the isovalue.
      if (n % 4 == 0) cell.value[c] = c == 0 || c == 7 ? rng.uniform(0.2, 1) : rng.uniform(-0.2, 0);
    }
    cell.isovalue = 0.125 * rng.uniform(-1, 1);
    if (oracle::analyse(cell.value, cell.isovalue).margin < 2e-3) continue;
    ++n;
    const CellDecision decision = decide(cell);
    CellSurface surface;
    make_surface(cell, decision, surface);
    const int expected = betti_of(surface).components + 1;
    tubes += decision.tube.kind != TubeKind::none;
    int lattice = 17;
    std::array<int, 2> regions = oracle::subdivided_regions(cell.value, cell.isovalue, lattice);
    while (regions[0] + regions[1] > expected && lattice < 129) {
      lattice = 2 * lattice - 1;
      regions = oracle::subdivided_regions(cell.value, cell.isovalue, lattice);
      ++finer;
    }
    ASSERT_EQ(regions[0] + regions[1], expected) << text_of(cell) << " lattice " << lattice;
  }
  EXPECT_GT(tubes, 10);
  RecordProperty("finer_lattices", finer);
}

// The mirror images and rotations of a cell are the same surface: decisions must not depend on axis order.
TEST(Cell, DecisionsDoNotDependOnTheAxes) {
  Rng rng(22);
  for (int n = 0; n < 20000; ++n) {
    CellValues cell;
    for (double& v : cell.value) v = n % 2 == 0 ? rng.uniform(-1, 1) : static_cast<double>(rng.below(5)) - 2;
    const CellDecision first = decide(cell);
    for (int flip = 0; flip < 8; ++flip) {
      for (int turn = 0; turn < 3; ++turn) {
        CellValues moved;
        for (int c = 0; c < 8; ++c) {
          const int to = ((c << turn | c >> (3 - turn)) & 7) ^ flip;
          moved.value[static_cast<std::size_t>(to)] = cell.value[static_cast<std::size_t>(c)];
        }
        const CellDecision second = decide(moved);
        ASSERT_EQ(first.tube.kind, second.tube.kind) << text_of(cell);
        ASSERT_EQ(CellCases::all()[first.number].loop_count, CellCases::all()[second.number].loop_count)
            << text_of(cell);
      }
    }
  }
}

// Ties that doubles cannot tell without care: a saddle that is 0 exactly, or off by one ulp of a corner.
TEST(Cell, FaceSaddlesAreDecidedExactly) {
  const double a = 1 + 0x1p-52;
  const double c = 1 - 0x1p-52;  // a c = 1 - 2^-104 < 1
  EXPECT_FALSE(face_joins_inside(a, -1, c, -1, 0));
  EXPECT_TRUE(face_joins_inside(1, -1, 1, -1, 0));
  EXPECT_TRUE(face_joins_inside(a, -1, 1, -1, 0));
  // Relative to the isovalue 1 - 2^-60 against 1 + 2^-60, which doubles cannot tell.
  EXPECT_FALSE(face_joins_inside(1, -1, 1, -1, 0x1p-60));
  EXPECT_TRUE(face_joins_inside(1, -1, 1, -1, -0x1p-60));
  // Beyond double's range for products.
  EXPECT_TRUE(face_joins_inside(1e200, -1e200, 1e200, -1e200, 0));
  EXPECT_FALSE(face_joins_inside(1e-200, -1e-200, 1e-200, std::nextafter(-1e-200, -1), 0));
  EXPECT_TRUE(face_joins_inside(5e-324, -5e-324, 5e-324, -5e-324, 0));
  EXPECT_FALSE(face_joins_inside(5e-324, -5e-324, 5e-324, -1e308, 0));
}

// The same cell times any power of two, plus an offset that keeps it exact, is the same surface.
TEST(Cell, DecisionsDoNotDependOnTheScale) {
  Rng rng(23);
  for (int n = 0; n < 3000; ++n) {
    CellValues cell;
    for (double& v : cell.value) v = static_cast<double>(rng.below(7)) - 3;
    const CellDecision first = decide(cell);
    for (const double scale : {0x1p-300, 0x1p-20, 0x1p40, 0x1p340, 3.0}) {
      CellValues moved = cell;
      for (double& v : moved.value) v *= scale;
      const CellDecision second = decide(moved);
      ASSERT_EQ(first.number, second.number);
      ASSERT_EQ(first.tube.kind, second.tube.kind) << text_of(cell) << " scale " << scale;
    }
    CellValues moved = cell;
    for (double& v : moved.value) v += 0x1p40;
    moved.isovalue += 0x1p40;
    ASSERT_EQ(first.number, decide(moved).number);
    ASSERT_EQ(first.tube.kind, decide(moved).tube.kind);
  }
}

// Inner points lie on the isosurface to rounding of values up to 1: 1e-12.
TEST(Cell, InnerPointsAreOnTheSurface) {
  Rng rng(24);
  int points = 0;
  for (int n = 0; n < 20000; ++n) {
    CellValues cell;
    for (std::size_t c = 0; c < 8; ++c) {
      const double sign = (((c & 1) + (c >> 1 & 1) + (c >> 2)) % 2) != 0 ? 1 : -1;
      cell.value[c] = n % 2 == 1 ? sign * rng.uniform(-0.2, 1) : rng.uniform(-1, 1);
    }
    CellSurface surface;
    make_surface(cell, decide(cell), surface);
    for (int i = 0; i < surface.point_count; ++i, ++points) {
      const Vec3& p = surface.points[static_cast<std::size_t>(i)];
      oracle::Corners v;
      for (std::size_t c = 0; c < 8; ++c) v[c] = cell.value[c];
      EXPECT_LT(std::abs(static_cast<double>(oracle::trilinear(v, {p[0], p[1], p[2]}))), 1e-12)
          << text_of(cell);
    }
  }
  EXPECT_GT(points, 1000);
}

}  // namespace
}  // namespace vol::isosurface
