#include "isosurface/cell_case.h"

#include <cstdlib>
#include <limits>
#include <numeric>

namespace vol::isosurface {
namespace {

constexpr std::uint16_t kNoCase = 0xffff;
constexpr std::array<std::array<int, 4>, 6> kFaceCorners{face_corners(0), face_corners(1), face_corners(2),
                                                         face_corners(3), face_corners(4), face_corners(5)};

/// The faces that an edge lies in, bit f each.
unsigned faces_of(int edge) {
  const int a = edge / 4;
  return 1u << (2 * ((a + 1) % 3) + (edge & 1)) | 1u << (2 * ((a + 2) % 3) + ((edge >> 1) & 1));
}

bool is_inside(int corners, int c) {
  return (corners >> c & 1) != 0;
}

Vec3 edge_midpoint(int edge) {
  Vec3 p;
  const auto ends = edge_corners(edge);
  for (int a = 0; a < 3; ++a) p[a] = 0.5 * ((ends[0] >> a & 1) + (ends[1] >> a & 1));
  return p;
}

/// Smallest triangulation of a loop (by the length of its chords between edge midpoints) that has no chord in
/// a face; false where there is none. Dynamic programming over sub-polygons (Klincsek 1980).
class LoopTriangulation {
 public:
  LoopTriangulation(const std::uint8_t* loop, int size) : loop_(loop), size_(size) {
    for (int length = 2; length < size; ++length) {
      for (int i = 0; i + length < size; ++i) solve(i, i + length);
    }
  }
  [[nodiscard]] bool exists() const { return cost_[0][size_ - 1] < kForbidden; }
  void append_to(CellCase& cell) const { append(cell, 0, size_ - 1); }

 private:
  static constexpr double kForbidden = 1e9;

  [[nodiscard]] double chord(int i, int j) const {
    if (j - i == 1 || (i == 0 && j == size_ - 1)) return 0;  // a side
    if ((faces_of(loop_[i]) & faces_of(loop_[j])) != 0) return kForbidden;
    return (edge_midpoint(loop_[i]) - edge_midpoint(loop_[j])).norm();
  }
  void solve(int i, int j) {
    double best = kForbidden;
    for (int m = i + 1; m < j; ++m) {
      const double cost = cost_[i][m] + cost_[m][j];
      if (cost < best) {
        best = cost;
        apex_[i][j] = m;
      }
    }
    cost_[i][j] = std::min(kForbidden, best + chord(i, j));
  }
  void append(CellCase& cell, int i, int j) const {
    if (j - i < 2) return;
    const int m = apex_[i][j];
    cell.triangles[cell.triangle_count++] = {loop_[i], loop_[m], loop_[j]};
    append(cell, i, m);
    append(cell, m, j);
  }

  const std::uint8_t* loop_;
  int size_;
  double cost_[12][12] = {};
  int apex_[12][12] = {};
};

void triangulate(CellCase& cell, CellCase::Loop& loop) {
  loop.first_triangle = cell.triangle_count;
  const std::uint8_t* edges = cell.edges.data() + loop.first;
  const LoopTriangulation plane(edges, loop.size);
  if (plane.exists()) {
    plane.append_to(cell);
  } else {
    loop.centre = static_cast<std::int8_t>(cell.centre_count++);
    for (int i = 0; i < loop.size; ++i) {
      cell.triangles[cell.triangle_count++] = {edges[i], edges[(i + 1) % loop.size],
                                               static_cast<std::uint8_t>(12 + loop.centre)};
    }
  }
  loop.triangle_count = static_cast<std::uint8_t>(cell.triangle_count - loop.first_triangle);
}

/// Union-find over the corners.
struct Corners {
  std::array<int, 8> parent;
  Corners() { std::iota(parent.begin(), parent.end(), 0); }
  [[nodiscard]] int root(int c) const { return parent[c] == c ? c : root(parent[c]); }
  void join(int a, int b) { parent[root(a)] = root(b); }
};

/// The segments of the faces: next[e] is the edge at which the segment that begins on edge e ends, -1 for
/// edges that are not cut. Counterclockwise about a face (seen from outside) a segment begins where the way
/// leads from outside to inside and ends where it leads out again; the inside lies on its right.
std::array<int, 12> face_segments(int corners, int joined, unsigned ambiguous, Corners& regions) {
  std::array<int, 12> next;
  next.fill(-1);
  for (int f = 0; f < 6; ++f) {
    const auto c = face_corners(f);
    const bool split_outside = (ambiguous >> f & 1) != 0 && (joined >> f & 1) != 0;
    for (int i = 0; i < 4; ++i) {
      if (is_inside(corners, c[i]) || !is_inside(corners, c[(i + 1) % 4])) continue;
      // Out to in between corners i and i + 1. Where the inside is joined the segment goes back about the
      // outside corner i, else it goes on about the inside ones.
      int end = i + 1;
      if (split_outside) {
        end = i + 3;
      } else {
        while (is_inside(corners, c[(end + 1) % 4])) ++end;
      }
      next[edge_between(c[i], c[(i + 1) % 4])] = edge_between(c[end % 4], c[(end + 1) % 4]);
    }
    if ((ambiguous >> f & 1) != 0) {
      const int first = is_inside(corners, c[0]) == split_outside ? 0 : 1;
      regions.join(c[first], c[first + 2]);
    }
  }
  return next;
}

CellCase make_case(int corners, int joined, unsigned ambiguous) {
  CellCase cell;
  Corners regions;
  for (int e = 0; e < 12; ++e) {
    const auto ends = edge_corners(e);
    if (is_inside(corners, ends[0]) == is_inside(corners, ends[1])) regions.join(ends[0], ends[1]);
  }
  auto next = face_segments(corners, joined, ambiguous, regions);
  for (int c = 0; c < 8; ++c) cell.region[c] = static_cast<std::uint8_t>(regions.root(c));
  std::uint8_t used = 0;
  for (int start = 0; start < 12; ++start) {
    if (next[start] < 0) continue;
    CellCase::Loop& loop = cell.loops[cell.loop_count++];
    loop.first = used;
    for (int e = start; next[e] >= 0;) {
      cell.edges[used++] = static_cast<std::uint8_t>(e);
      const int to = next[e];
      next[e] = -1;
      e = to;
    }
    loop.size = static_cast<std::uint8_t>(used - loop.first);
    const auto ends = edge_corners(start);
    const int in = is_inside(corners, ends[0]) ? 0 : 1;
    loop.inside = cell.region[ends[in]];
    loop.outside = cell.region[ends[1 - in]];
    triangulate(cell, loop);
  }
  return cell;
}

}  // namespace

int edge_between(int corner, int other) {
  const int lower = corner & other;
  const int difference = corner ^ other;
  const int a = difference == 1 ? 0 : difference == 2 ? 1 : 2;
  return 4 * a + (lower >> ((a + 1) % 3) & 1) + 2 * (lower >> ((a + 2) % 3) & 1);
}

CellCases::CellCases() : number_(std::size_t{256} * 64, kNoCase) {
  for (int corners = 0; corners < 256; ++corners) {
    for (int f = 0; f < 6; ++f) {
      const auto c = face_corners(f);
      const bool in = is_inside(corners, c[0]);
      if (in != is_inside(corners, c[1]) && in == is_inside(corners, c[2]) &&
          in != is_inside(corners, c[3])) {
        ambiguous_[corners] = static_cast<std::uint8_t>(ambiguous_[corners] | 1u << f);
      }
    }
    for (int e = 0; e < 12; ++e) {
      const auto ends = edge_corners(e);
      if (is_inside(corners, ends[0]) != is_inside(corners, ends[1])) {
        cut_[corners] = static_cast<std::uint16_t>(cut_[corners] | 1u << e);
      }
    }
    const unsigned faces = ambiguous_[corners];
    for (unsigned joined = 0; joined < 64; ++joined) {
      if ((joined & ~faces) != 0) continue;
      number_[static_cast<std::size_t>(corners) * 64 + joined] = static_cast<std::uint16_t>(cases_.size());
      cases_.push_back(make_case(corners, static_cast<int>(joined), faces));
    }
    decided_[corners] = faces == 0 && cases_.back().loop_count <= 1;
  }
}

const CellCases& CellCases::all() {
  static const CellCases cases;
  return cases;
}

TubeLoops tube_loops(const CellCase& cell, int corners, const Tube& tube) {
  if (tube.kind == TubeKind::none) return {};
  const bool inside = tube.kind == TubeKind::inside;
  // From the saddle the field keeps its side of the isovalue along three quadrants of planes toward each end
  // of the diagonal, up to a point of each of that corner's edges: one end of such an edge is on that side.
  const auto region_at = [&](int corner) {
    for (int a = 0; a < 3; ++a) {
      for (const int c : {corner, corner ^ 1 << a}) {
        if (is_inside(corners, c) == inside) return int{cell.region[c]};
      }
    }
    return -1;
  };
  const int first = region_at(tube.diagonal);
  const int second = region_at(7 - tube.diagonal);
  if (first < 0 || second < 0 || first == second) return {};
  // Loops and regions of the cell's surface are the edges and nodes of a tree: there is one such pair at
  // most.
  for (int i = 0; i < cell.loop_count; ++i) {
    for (int j = 0; j < cell.loop_count; ++j) {
      const auto& a = cell.loops[i];
      const auto& b = cell.loops[j];
      if ((inside ? a.inside : a.outside) == first && (inside ? b.inside : b.outside) == second &&
          (inside ? a.outside == b.outside : a.inside == b.inside)) {
        return {i, j};
      }
    }
  }
  return {};
}

CellDecision decide(const CellValues& cell, bool beyond_border) {
  const CellCases& cases = CellCases::all();
  CellDecision result;
  for (int c = 0; c < 8; ++c) result.corners |= int{cell.value[c] >= cell.isovalue} << c;
  unsigned joined = 0;
  for (unsigned faces = cases.ambiguous_faces(result.corners); faces != 0; faces &= faces - 1) {
    const int f = __builtin_ctz(faces);
    const auto& c = kFaceCorners[static_cast<std::size_t>(f)];
    const auto value = [&](std::size_t i) { return cell.value[static_cast<std::size_t>(c[i])]; };
    const bool first = is_inside(result.corners, c[0]);
    if (first ? face_joins_inside(value(0), value(1), value(2), value(3), cell.isovalue)
              : face_joins_inside(value(1), value(2), value(3), value(0), cell.isovalue)) {
      joined |= 1u << f;
    }
  }
  result.number = cases.number(result.corners, static_cast<int>(joined));
  const CellCase& found = cases[result.number];
  if (found.loop_count > 1 && !beyond_border) {
    const Tube tube = interior_tube(cell);
    if (tube_loops(found, result.corners, tube).any()) result.tube = tube;
  }
  return result;
}

}  // namespace vol::isosurface
