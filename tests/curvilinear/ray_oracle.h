#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "camera/camera.h"
#include "curvilinear/face.h"
#include "curvilinear/solid.h"

namespace vol::curvilinear {

/// Intersections of a line with a bicubic patch in extended precision, by nothing but halving to a fixed
/// depth and Newton from the middle of what is left: the oracle of append_hits(). Knows nothing of
/// neighbours.
class RayOracle {
 public:
  using Real = long double;
  struct Point {
    Real u, v, t;
    int sign;  ///< of d . (du x dv)
  };
  using Real3 = std::array<Real, 3>;
  using Net = std::array<Real3, 16>;

  explicit RayOracle(const camera::Ray& ray) {
    for (int a = 0; a < 3; ++a) {
      origin_[a] = ray.origin[a];
      along_[a] = ray.direction[a];
    }
    // Any two directions across the ray, by another rule than the library's.
    const Real3 helper = std::abs(along_[2]) < 0.9L ? Real3{0, 0, 1} : Real3{1, 0, 0};
    x_ = cross(helper, along_);
    y_ = cross(along_, x_);
  }

  [[nodiscard]] std::vector<Point> hits(const std::array<Vec3, 16>& patch) const {
    Net net;
    for (std::size_t n = 0; n < 16; ++n) {
      Real3 p;
      for (int a = 0; a < 3; ++a) p[a] = Real(patch[n][a]) - origin_[a];
      net[n] = {dot(x_, p), dot(y_, p), dot(along_, p)};
    }
    std::vector<Point> found;
    search(net, net, 0, 0, 0, found);
    return found;
  }

 private:
  static constexpr int kDepth = 7;

  static Real dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  static Real3 cross(const Real3& a, const Real3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static Real3 mean(const Real3& a, const Real3& b) {
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
  }
  static void split(const Net& c, std::size_t step, std::size_t curve, Net& l, Net& r) {
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t at = k * curve;
      const Real3 ab = mean(c[at], c[at + step]), bc = mean(c[at + step], c[at + 2 * step]),
                  cd = mean(c[at + 2 * step], c[at + 3 * step]);
      const Real3 abc = mean(ab, bc), bcd = mean(bc, cd), m = mean(abc, bcd);
      l[at] = c[at], l[at + step] = ab, l[at + 2 * step] = abc, l[at + 3 * step] = m;
      r[at] = m, r[at + step] = bcd, r[at + 2 * step] = cd, r[at + 3 * step] = c[at + 3 * step];
    }
  }
  static void evaluate(const Net& c, Real u, Real v, Real3& p, Real3& pu, Real3& pv) {
    const auto basis = [](Real x, Real(&b)[4], Real(&d)[4]) {
      const Real y = 1 - x;
      b[0] = y * y * y, b[1] = 3 * x * y * y, b[2] = 3 * x * x * y, b[3] = x * x * x;
      d[0] = -3 * y * y, d[1] = 3 * y * y - 6 * x * y, d[2] = 6 * x * y - 3 * x * x, d[3] = 3 * x * x;
    };
    Real bu[4], du[4], bv[4], dv[4];
    basis(u, bu, du);
    basis(v, bv, dv);
    p = pu = pv = {0, 0, 0};
    for (std::size_t s = 0; s < 4; ++s) {
      for (std::size_t r = 0; r < 4; ++r) {
        for (std::size_t a = 0; a < 3; ++a) {
          p[a] += bu[r] * bv[s] * c[r + 4 * s][a];
          pu[a] += du[r] * bv[s] * c[r + 4 * s][a];
          pv[a] += bu[r] * dv[s] * c[r + 4 * s][a];
        }
      }
    }
  }
  void search(const Net& whole, const Net& c, Real u0, Real v0, int depth, std::vector<Point>& found) const {
    for (std::size_t a = 0; a < 2; ++a) {
      Real least = c[0][a], most = c[0][a];
      for (const auto& p : c) {
        least = std::min(least, p[a]);
        most = std::max(most, p[a]);
      }
      if (least > 0 || most < 0) return;
    }
    if (depth < kDepth) {
      Net lower, upper, l, r;
      split(c, 4, 1, lower, upper);
      const Real half = std::ldexp(Real(1), -depth - 1);
      for (const Net* n : {&lower, &upper}) {
        split(*n, 1, 4, l, r);
        const Real v = v0 + (n == &upper ? half : 0);
        search(whole, l, u0, v, depth + 1, found);
        search(whole, r, u0 + half, v, depth + 1, found);
      }
      return;
    }
    const Real width = std::ldexp(Real(1), -depth);
    Real u = u0 + width / 2, v = v0 + width / 2;
    Real3 p, pu, pv;
    for (int step = 0; step < 60; ++step) {
      evaluate(whole, u, v, p, pu, pv);
      const Real det = pu[0] * pv[1] - pu[1] * pv[0];
      if (det == 0) return;
      const Real du = (pv[0] * p[1] - p[0] * pv[1]) / det, dv = (p[0] * pu[1] - pu[0] * p[1]) / det;
      u += du;
      v += dv;
      if (!(std::abs(u - u0) < 8 * width && std::abs(v - v0) < 8 * width)) return;
      if (std::max(std::abs(du), std::abs(dv)) < 1e-17L) break;
      if (step == 59) return;
    }
    if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1)) return;
    for (const Point& q : found) {
      if (std::max(std::abs(q.u - u), std::abs(q.v - v)) < 1e-12L) return;
    }
    evaluate(whole, u, v, p, pu, pv);
    found.push_back({u, v, p[2], pu[0] * pv[1] - pu[1] * pv[0] > 0 ? 1 : -1});
  }

  Real3 origin_, along_, x_, y_;
};

template <class F>
void each_cell(const Block& block, const F& f) {
  const Dims n = block.cells();
  for (std::int64_t k = 0; k < n[2]; ++k) {
    for (std::int64_t j = 0; j < n[1]; ++j) {
      for (std::int64_t i = 0; i < n[0]; ++i) f(Dims{i, j, k});
    }
  }
}

/// The face as the solid has it.
inline FacePatch face_of(const Solid& solid, int axis, bool high) {
  const int stride[3] = {1, 4, 16};
  FacePatch patch;
  for (int n = 0; n < 16; ++n) {
    const int at =
        (high ? 3 : 0) * stride[axis] + n % 4 * stride[(axis + 1) % 3] + n / 4 * stride[(axis + 2) % 3];
    patch[static_cast<std::size_t>(n)] = solid.b[static_cast<std::size_t>(at)].head<3>();
  }
  return patch;
}

/// Length within the cells, each by the oracle's passages through its own faces; the degree of each cell must
/// close. Counts cells where it does not: a passage within rounding of an edge.
inline double length_by_cells(const Grid& grid, CellKind kind, const camera::Ray& ray, int& open) {
  const RayOracle oracle(ray);
  const Block& block = grid.blocks[0];
  const Solids solids(block, {}, kind, 1);
  const int hand = handedness(block);
  long double length = 0;
  each_cell(block, [&](const Dims& cell) {
    if (block.is_missing(cell)) return;
    const Solid solid = solids(cell);
    int degree = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool high : {false, true}) {
        for (const auto& p : oracle.hits(face_of(solid, axis, high))) {
          const int leaving = hand * p.sign * (high ? 1 : -1);
          length += leaving * p.t;
          degree += leaving;
        }
      }
    }
    open += degree != 0;
  });
  return static_cast<double>(length);
}

}  // namespace vol::curvilinear
