#include "isosurface/cell_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace vol::isosurface {
namespace {

constexpr int kRing = 6;

/// The cell's field relative to the isovalue, scaled to the size of 1.
class CellField {
 public:
  explicit CellField(const CellValues& cell) {
    // Halves, so that the difference of two doubles is one.
    double largest = 0;
    for (int c = 0; c < 8; ++c) {
      value_[c] = 0.5 * cell.value[c] - 0.5 * cell.isovalue;
      largest = std::max(largest, std::abs(value_[c]));
    }
    finite_ = largest <= std::numeric_limits<double>::max();
    if (finite_ && largest > 0) {
      for (double& v : value_) v /= largest;
    }
  }
  [[nodiscard]] bool finite() const { return finite_; }
  [[nodiscard]] double corner(int c) const { return value_[c]; }
  [[nodiscard]] double operator()(const Vec3& p) const {
    const double y0 = mix(mix(value_[0], value_[1], p[0]), mix(value_[2], value_[3], p[0]), p[1]);
    const double y1 = mix(mix(value_[4], value_[5], p[0]), mix(value_[6], value_[7], p[0]), p[1]);
    return mix(y0, y1, p[2]);
  }
  [[nodiscard]] Vec3 gradient(const Vec3& p) const {
    Vec3 g;
    for (int a = 0; a < 3; ++a) {
      Vec3 low = p;
      Vec3 high = p;
      low[a] = 0;
      high[a] = 1;
      g[a] = (*this)(high) - (*this)(low);
    }
    return g;
  }

 private:
  static double mix(double a, double b, double t) { return (1 - t) * a + t * b; }
  double value_[8];
  bool finite_;
};

Vec3 corner_position(int c) {
  return {double(c & 1), double(c >> 1 & 1), double(c >> 2)};
}

Vec3 edge_point(const CellValues& cell, int edge) {
  const auto ends = edge_corners(edge);
  Vec3 p = corner_position(ends[0]);
  p[edge / 4] = crossing(cell.value[ends[0]], cell.value[ends[1]], cell.isovalue);
  return p;
}

/// The zero between two points of which one is inside.
Vec3 bisect(const CellField& f, Vec3 a, Vec3 b) {
  const bool inside = f(a) >= 0;
  for (int n = 0; n < 60; ++n) {
    const Vec3 middle = 0.5 * (a + b);
    ((f(middle) >= 0) == inside ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

/// A point of the isosurface in the open cell, near p: by Newton's method along the gradient, or, where that
/// leaves the cell, toward the nearest corner on the other side.
Vec3 project(const CellField& f, const Vec3& p) {
  constexpr double kMargin = 1.0 / 64;
  Vec3 q = p;
  for (int n = 0; n < 16; ++n) {
    const double value = f(q);
    if (std::abs(value) <= 1e-14) return q;
    const Vec3 g = f.gradient(q);
    q -= g * (value / std::max(g.squaredNorm(), 1e-30));
    if (!((q.array() > kMargin).all() && (q.array() < 1 - kMargin).all())) break;
  }
  const bool inside = f(p) >= 0;
  int nearest = -1;
  for (int c = 0; c < 8; ++c) {
    if ((f.corner(c) >= 0) == inside) continue;
    if (nearest < 0 || (corner_position(c) - p).norm() < (corner_position(nearest) - p).norm()) nearest = c;
  }
  return nearest < 0 ? p : bisect(f, p, corner_position(nearest));
}

/// The ring about a tube's saddle, counterclockwise as seen from the diagonal's first corner: looking along
/// the diagonal.
std::array<Vec3, kRing> ring_of(const CellField& f, const CellValues& cell, const Tube& tube) {
  const auto s = saddle_position(cell, tube.kind);
  const Vec3 saddle(s[0], s[1], s[2]);
  // From corner 0's diagonal the edges 100-110, 110-010, 010-011, 011-001, 001-101, 101-100 go round
  // counterclockwise seen from corner 7, clockwise seen from corner 0; a reflection reverses them.
  constexpr int kPath[kRing] = {1, 3, 2, 6, 4, 5};
  std::array<Vec3, kRing> ring;
  for (int i = 0; i < kRing; ++i) {
    const int from = kPath[i] ^ tube.diagonal;
    const int to = kPath[(i + 1) % kRing] ^ tube.diagonal;
    const int axis = (from ^ to) == 1 ? 0 : (from ^ to) == 2 ? 1 : 2;
    Vec3 target = corner_position(from);
    target[axis] = saddle[axis];
    // In the plane of the saddle and the edge f - f(s) is the product of the two distances: along the line to
    // the edge it grows with their square. Where rounding denies the sides, the tube is as thin as rounding.
    const double at_saddle = f(saddle);
    const double at_target = f(target);
    const double share = at_saddle / (at_saddle - at_target);
    ring[i] = share > 0 && share <= 1 ? Vec3(saddle + std::sqrt(share) * (target - saddle)) : saddle;
  }
  const int d = tube.diagonal;
  const bool reflected = ((d & 1) + (d >> 1 & 1) + (d >> 2)) % 2 == 1;
  if (!reflected) std::reverse(ring.begin(), ring.end());
  return ring;
}

struct Corner {
  std::uint8_t code;
  Vec3 position;
};

void add(CellSurface& surface, const Corner& a, const Corner& b, const Corner& c) {
  surface.triangles[static_cast<std::size_t>(surface.triangle_count++)] = {a.code, b.code, c.code};
}

/// A band between two cycles that go round alike, triangles in the sense of `rim`: a corner of the rim and
/// one of the ring after the other, evenly, from where the edges across are shortest.
void add_band(CellSurface& surface, const std::vector<Corner>& rim, const std::vector<Corner>& ring) {
  const int m = static_cast<int>(rim.size());
  const int n = static_cast<int>(ring.size());
  const auto walk = [&](int offset, const auto& step) {
    for (int i = 0, j = 0; i < m || j < n;) {
      // The next edge across is the one whose share of the round comes first.
      const bool along_rim = j == n || (i < m && (2 * i + 1) * n <= (2 * j + 1) * m);
      const Corner& a = rim[i % m];
      const Corner& b = ring[(j + offset) % n];
      if (along_rim) {
        step(a, b, rim[++i % m]);
      } else {
        step(a, b, ring[(++j + offset) % n]);
      }
    }
  };
  int best = 0;
  double shortest = std::numeric_limits<double>::infinity();
  for (int offset = 0; offset < n; ++offset) {
    double length = 0;
    walk(offset, [&](const Corner& a, const Corner& b, const Corner&) {
      length += (a.position - b.position).squaredNorm();
    });
    if (length < shortest) {
      shortest = length;
      best = offset;
    }
  }
  // The same order for both: a to its successor on the rim, or on the ring its successor to b.
  walk(best, [&](const Corner& a, const Corner& b, const Corner& next) { add(surface, a, next, b); });
}

std::vector<Corner> rim_of(const CellCase& cell, int loop, const CellValues& values) {
  std::vector<Corner> rim;
  const auto& l = cell.loops[static_cast<std::size_t>(loop)];
  for (int i = 0; i < l.size; ++i) {
    const std::uint8_t e = cell.edges[static_cast<std::size_t>(l.first + i)];
    rim.push_back({e, edge_point(values, e)});
  }
  return rim;
}

void add_tube(const CellValues& values, const CellCase& cell, const CellDecision& decision,
              const TubeLoops& loops, const CellField& field, CellSurface& surface) {
  std::vector<Corner> ring;
  for (const Vec3& p : ring_of(field, values, decision.tube)) {
    ring.push_back({static_cast<std::uint8_t>(12 + surface.point_count), p});
    surface.points[static_cast<std::size_t>(surface.point_count++)] = p;
  }
  // A loop about an inside region goes round it clockwise as seen from outside the cell, one about an outside
  // region counterclockwise. The ring goes counterclockwise as seen from the first corner.
  if (decision.tube.kind == TubeKind::inside) std::reverse(ring.begin(), ring.end());
  add_band(surface, rim_of(cell, loops.first, values), ring);
  std::reverse(ring.begin(), ring.end());
  add_band(surface, rim_of(cell, loops.second, values), ring);
}

void add_disk(const CellValues& values, const CellCase& cell, const CellCase::Loop& loop,
              const CellField& field, CellSurface& surface) {
  int centre = 0;
  if (loop.centre >= 0) {
    Vec3 mean = Vec3::Zero();
    for (int i = 0; i < loop.size; ++i) mean += edge_point(values, cell.edges[loop.first + i]);
    mean /= double(loop.size);
    centre = 12 + surface.point_count;
    surface.points[static_cast<std::size_t>(surface.point_count++)] =
        field.finite() ? project(field, mean) : mean;
  }
  for (int t = 0; t < loop.triangle_count; ++t) {
    auto triangle = cell.triangles[loop.first_triangle + t];
    for (auto& code : triangle) {
      if (code >= 12) code = static_cast<std::uint8_t>(centre);
    }
    surface.triangles[static_cast<std::size_t>(surface.triangle_count++)] = triangle;
  }
}

}  // namespace

double crossing(double first, double second, double isovalue) {
  if (std::isinf(first)) return 1;
  if (std::isinf(second)) return 0;
  double t = (isovalue - first) / (second - first);
  if (!(std::abs(second - first) <= std::numeric_limits<double>::max())) {
    t = (0.5 * isovalue - 0.5 * first) / (0.5 * second - 0.5 * first);
  }
  return std::clamp(t, 0.0, 1.0);
}

CellSize surface_size(const CellCase& cell, const CellDecision& decision) {
  const TubeLoops loops = tube_loops(cell, decision.corners, decision.tube);
  CellSize size{cell.triangle_count, cell.centre_count};
  if (!loops.any()) return size;
  for (const int i : {loops.first, loops.second}) {
    const auto& loop = cell.loops[static_cast<std::size_t>(i)];
    size.triangles += loop.size + kRing - loop.triangle_count;
    size.points -= loop.centre >= 0 ? 1 : 0;
  }
  size.points += kRing;
  return size;
}

void make_surface(const CellValues& values, const CellDecision& decision, CellSurface& surface) {
  surface.triangle_count = surface.point_count = 0;
  const CellCase& cell = CellCases::all()[decision.number];
  const TubeLoops loops = tube_loops(cell, decision.corners, decision.tube);
  const CellField field(values);
  for (int i = 0; i < cell.loop_count; ++i) {
    if (i == loops.first || i == loops.second) continue;
    add_disk(values, cell, cell.loops[static_cast<std::size_t>(i)], field, surface);
  }
  if (loops.any()) add_tube(values, cell, decision, loops, field, surface);
}

}  // namespace vol::isosurface
