#pragma once
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <vector>

// What is connected in a trilinear cell, found without the mesher's means: union-find over edges and saddles,
// the saddles' places and values by solving for them in quadruple precision.
namespace vol::isosurface::oracle {

__extension__ using Quad = __float128;

inline Quad root_of(Quad x) {
  if (x <= 0) return 0;
  Quad r = std::sqrt(static_cast<double>(x));
  for (int n = 0; n < 6; ++n) r = (r + x / r) / 2;
  return r;
}

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t root(std::size_t i) { return parent_[i] == i ? i : parent_[i] = root(parent_[i]); }
  void join(std::size_t a, std::size_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::size_t> parent_;
};

using Corners = std::array<Quad, 8>;  // relative to the isovalue

inline Quad trilinear(const Corners& v, const std::array<Quad, 3>& p) {
  Quad sum = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    Quad w = v[c];
    for (std::size_t a = 0; a < 3; ++a) w *= (c >> a & 1) != 0 ? p[a] : 1 - p[a];
    sum += w;
  }
  return sum;
}

inline Quad magnitude(Quad x) {
  return x < 0 ? -x : x;
}

/// Points of the open cell where the gradient vanishes, isolated ones only. Elimination: f = P(x) + Q(x) y +
/// R(x) z + S(x) y z with P .. S linear in x; f_y = f_z = 0 give z = -Q/S, y = -R/S, and f_x = 0 becomes a
/// quadratic in x.
inline std::vector<std::array<Quad, 3>> critical_points(const Corners& v) {
  const auto linear = [&](auto pick) {  // value at x = 0 and slope of a combination of the corners
    const Quad at0 = pick(0);
    return std::array<Quad, 2>{at0, pick(1) - at0};
  };
  const auto P = linear([&](std::size_t x) { return v[x]; });
  const auto Q = linear([&](std::size_t x) { return v[x + 2] - v[x]; });
  const auto R = linear([&](std::size_t x) { return v[x + 4] - v[x]; });
  const auto S = linear([&](std::size_t x) { return v[x + 6] - v[x + 4] - v[x + 2] + v[x]; });
  // f_x S^2 = P1 S^2 - Q1 R S - R1 Q S + S1 Q R = 0
  std::array<Quad, 3> poly{};
  const auto add = [&](Quad factor, const std::array<Quad, 2>& a, const std::array<Quad, 2>& b) {
    poly[0] += factor * a[0] * b[0];
    poly[1] += factor * (a[0] * b[1] + a[1] * b[0]);
    poly[2] += factor * a[1] * b[1];
  };
  add(P[1], S, S);
  add(-Q[1], R, S);
  add(-R[1], Q, S);
  add(S[1], Q, R);
  Quad scale = 0;
  for (const Quad x : v) scale = magnitude(x) > scale ? magnitude(x) : scale;
  const Quad tiny = scale * scale * scale * Quad(1e-26);
  std::vector<Quad> xs;
  if (magnitude(poly[2]) <= tiny) {
    if (magnitude(poly[1]) > tiny) xs.push_back(-poly[0] / poly[1]);
  } else {
    const Quad disc = poly[1] * poly[1] - 4 * poly[2] * poly[0];
    if (disc > tiny * tiny) {
      const Quad q = -(poly[1] + (poly[1] < 0 ? -1 : 1) * root_of(disc)) / 2;
      xs.push_back(q / poly[2]);
      if (magnitude(q) > 0) xs.push_back(poly[0] / q);
    }
  }
  std::vector<std::array<Quad, 3>> points;
  for (const Quad x : xs) {
    const Quad s = S[0] + S[1] * x;
    if (magnitude(s) <= scale * Quad(1e-20)) continue;
    const std::array<Quad, 3> p{x, -(R[0] + R[1] * x) / s, -(Q[0] + Q[1] * x) / s};
    bool open = true;
    for (const Quad u : p) open = open && u > 0 && u < 1;
    if (open) points.push_back(p);
  }
  return points;
}

struct Cell {
  std::array<int, 8> face_region;  ///< of the corners, connected by edges and face saddles
  std::array<int, 8> region;       ///< and by the saddles within
  int inside_face_regions = 0, outside_face_regions = 0;
  int inside_regions = 0, outside_regions = 0;
  double margin = 1e300;  ///< smallest distance of a saddle's value from the isovalue

  [[nodiscard]] int loops() const {
    const int all = inside_face_regions + outside_face_regions;
    return all - 1;
  }
  [[nodiscard]] int surfaces() const { return inside_regions + outside_regions - 1; }
};

/// A value within 1e-20 of the largest corner counts as equal: for small whole numbers nothing but 0 is.
inline Cell analyse(const std::array<double, 8>& value, double isovalue) {
  Corners v;
  Quad scale = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    v[c] = Quad(value[c]) - Quad(isovalue);
    scale = magnitude(v[c]) > scale ? magnitude(v[c]) : scale;
  }
  const auto is_inside = [&](Quad f) { return f >= -scale * Quad(1e-20); };
  Cell cell;
  UnionFind sets(8);
  for (std::size_t c = 0; c < 8; ++c) {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t d = c | std::size_t{1} << a;
      if (is_inside(v[c]) == is_inside(v[d])) sets.join(c, d);
    }
  }
  const auto note = [&](Quad f) { cell.margin = std::min(cell.margin, static_cast<double>(magnitude(f))); };
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t u = std::size_t{1} << ((a + 1) % 3);
      const std::size_t w = std::size_t{1} << ((a + 2) % 3);
      const std::size_t base = side << a;
      const std::size_t c[4] = {base, base | u, base | u | w, base | w};
      const Quad sum = v[c[0]] - v[c[1]] + v[c[2]] - v[c[3]];
      if (is_inside(v[c[0]]) == is_inside(v[c[1]]) || is_inside(v[c[1]]) == is_inside(v[c[2]]) ||
          is_inside(v[c[2]]) == is_inside(v[c[3]]) || sum == 0) {
        continue;
      }
      const Quad saddle = (v[c[0]] * v[c[2]] - v[c[1]] * v[c[3]]) / sum;
      note(saddle);
      const std::size_t first = is_inside(saddle) == is_inside(v[c[0]]) ? 0 : 1;
      sets.join(c[first], c[first + 2]);
    }
  }
  const auto number = [&](std::array<int, 8>& region, int& inside, int& outside) {
    inside = outside = 0;
    for (std::size_t c = 0; c < 8; ++c) {
      region[c] = static_cast<int>(sets.root(c));
      if (sets.root(c) == c) ++(is_inside(v[c]) ? inside : outside);
    }
  };
  number(cell.face_region, cell.inside_face_regions, cell.outside_face_regions);
  for (const auto& p : critical_points(v)) {
    const Quad f = trilinear(v, p);
    note(f);
    const bool inside = is_inside(f);
    // Across the saddle f is bilinear in each axis plane, f = f(p) + f_xy dx dy: towards the cell's edges in
    // two quadrants it stays on the saddle's side, and an end of such an edge is on it.
    std::vector<std::size_t> joined;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t q = 0; q < 4; ++q) {
        const std::size_t lower = (q & 1) << ((a + 1) % 3) | (q >> 1) << ((a + 2) % 3);
        const std::size_t upper = lower | std::size_t{1} << a;
        std::array<Quad, 3> edge = p;
        edge[(a + 1) % 3] = Quad(q & 1);
        edge[(a + 2) % 3] = Quad(q >> 1);
        const Quad g = trilinear(v, edge);
        if (inside ? !(g > f) : !(g < f)) continue;
        for (const std::size_t c : {lower, upper}) {
          if (is_inside(v[c]) == inside) joined.push_back(c);
        }
      }
    }
    for (const std::size_t c : joined) sets.join(c, joined[0]);
  }
  number(cell.region, cell.inside_regions, cell.outside_regions);
  return cell;
}

/// Regions of a lattice of n^3 points of the cell, connected along lattice lines, on which f is linear: never
/// fewer than the cell has.
inline std::array<int, 2> subdivided_regions(const std::array<double, 8>& value, double isovalue, int n) {
  std::vector<char> inside(static_cast<std::size_t>(n * n * n));
  const auto at = [n](int i, int j, int k) { return static_cast<std::size_t>(i + n * (j + n * k)); };
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const long double t[3] = {(long double)i / (n - 1), (long double)j / (n - 1),
                                  (long double)k / (n - 1)};
        long double sum = 0;
        for (std::size_t c = 0; c < 8; ++c) {
          long double w = value[c];
          for (std::size_t a = 0; a < 3; ++a) w *= (c >> a & 1) != 0 ? t[a] : 1 - t[a];
          sum += w;
        }
        inside[at(i, j, k)] = sum >= isovalue;
      }
    }
  }
  UnionFind sets(inside.size());
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const auto join = [&](int di, int dj, int dk) {
          if (i + di >= n || j + dj >= n || k + dk >= n) return;
          const std::size_t a = at(i, j, k);
          const std::size_t b = at(i + di, j + dj, k + dk);
          if (inside[a] == inside[b]) sets.join(a, b);
        };
        join(1, 0, 0);
        join(0, 1, 0);
        join(0, 0, 1);
      }
    }
  }
  std::array<int, 2> count{0, 0};
  for (std::size_t p = 0; p < inside.size(); ++p) {
    if (sets.root(p) == p) ++count[inside[p] != 0 ? 0 : 1];
  }
  return count;
}

}  // namespace vol::isosurface::oracle
