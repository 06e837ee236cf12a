#include "curvilinear/ray_patch.h"

#include <algorithm>
#include <cmath>

#include "curvilinear/cubic_basis.h"

namespace vol::curvilinear {
namespace {

/// Halvings of a border curve; more than of a patch, so that the borders of its parts halve on alike.
constexpr int kCurveLevels = 60;
/// Halvings of a patch along a parameter, to the last digits of it.
constexpr int kPatchLevels = 52;
/// Of the patch's largest coordinate: what its control points are rounded by after some halvings.
constexpr double kRounding = 1e-15;
/// Parts of a patch beyond which only those with a winding are followed. Ordinary faces take 1 to 30.
constexpr int kMostParts = 1000;

/// -1: all negative; 1: none is; 0: else. `Above` says what counts as not negative.
template <int N, class Above>
int side(const double* c, int stride, const Above& above) {
  int n = 0;
  for (int k = 0; k < N; ++k) n += above(c[k * stride]);
  return n == N ? 1 : n == 0 ? -1 : 0;
}
constexpr auto kNotBelow = [](double y) { return y >= 0; };
constexpr auto kPositive = [](double x) { return x > 0; };

struct Curve {
  double x[4], y[4];
};

void halve(const double (&c)[4], double (&left)[4], double (&right)[4]) {
  const double ab = 0.5 * (c[0] + c[1]), bc = 0.5 * (c[1] + c[2]), cd = 0.5 * (c[2] + c[3]);
  const double abc = 0.5 * (ab + bc), bcd = 0.5 * (bc + cd);
  left[0] = c[0];
  left[1] = ab;
  left[2] = abc;
  left[3] = right[0] = 0.5 * (abc + bcd);
  right[1] = bcd;
  right[2] = cd;
  right[3] = c[3];
}

/// Crossings of y = 0, x > 0 upward less those downward. Each early answer is the one that halving on would
/// give: a mean of numbers on one side of 0 is on that side in floating point too.
int crossings(const Curve& c, int levels) {
  if (side<4>(c.y, 1, kNotBelow) != 0) return 0;
  const int right_of = side<4>(c.x, 1, kPositive);
  if (right_of < 0) return 0;
  if (right_of > 0 || levels == 0) {
    return c.x[0] > 0 ? static_cast<int>(c.y[3] >= 0) - static_cast<int>(c.y[0] >= 0) : 0;
  }
  Curve left, right;
  halve(c.x, left.x, right.x);
  halve(c.y, left.y, right.y);
  return crossings(left, levels - 1) + crossings(right, levels - 1);
}

int winding(const RayPatch& p, int level_u, int level_v) {
  const auto border = [&](int first, int stride, int levels) {
    Curve c;
    for (int k = 0; k < 4; ++k) {
      c.x[k] = p.x[first + k * stride];
      c.y[k] = p.y[first + k * stride];
    }
    return crossings(c, levels);
  };
  const int along_u = kCurveLevels - level_u, along_v = kCurveLevels - level_v;
  return border(0, 1, along_u) + border(3, 4, along_v) - border(12, 1, along_u) - border(0, 4, along_v);
}

/// Part of a patch: [u0, u0 + 2^-level_u] x [v0, v0 + 2^-level_v].
struct Part {
  RayPatch p;
  double u0 = 0, v0 = 0;
  int level_u = 0, level_v = 0;
};

/// Halves of 16 control values along one parameter: `step` apart within a curve, the four curves `curve`
/// apart.
void halve(const double (&c)[16], int step, int curve, double (&left)[16], double (&right)[16]) {
  for (int k = 0; k < 4; ++k) {
    const int at = k * curve;
    const double row[4] = {c[at], c[at + step], c[at + 2 * step], c[at + 3 * step]};
    double l[4], r[4];
    halve(row, l, r);
    for (int n = 0; n < 4; ++n) {
      left[at + n * step] = l[n];
      right[at + n * step] = r[n];
    }
  }
}

void halve(const Part& part, bool along_u, Part& left, Part& right) {
  const int step = along_u ? 1 : 4, curve = along_u ? 4 : 1;
  halve(part.p.x, step, curve, left.p.x, right.p.x);
  halve(part.p.y, step, curve, left.p.y, right.p.y);
  halve(part.p.z, step, curve, left.p.z, right.p.z);
  for (Part* half : {&left, &right}) {
    half->u0 = part.u0;
    half->v0 = part.v0;
    half->level_u = part.level_u + along_u;
    half->level_v = part.level_v + !along_u;
  }
  (along_u ? right.u0 : right.v0) += std::ldexp(1.0, -(along_u ? right.level_u : right.level_v));
}

/// Differences of neighbouring control points: along u and along v, 12 each.
struct Tangents {
  double ux[12], uy[12], vx[12], vy[12];
  double size_u = 0, size_v = 0;

  explicit Tangents(const RayPatch& p) {
    for (int s = 0; s < 4; ++s) {
      for (int r = 0; r < 3; ++r) {
        const int u = r + 4 * s, v = s + 4 * r, n = r + 3 * s;
        ux[n] = p.x[u + 1] - p.x[u];
        uy[n] = p.y[u + 1] - p.y[u];
        vx[n] = p.x[v + 4] - p.x[v];
        vy[n] = p.y[v + 4] - p.y[v];
      }
    }
    for (int n = 0; n < 12; ++n) {
      size_u = std::max({size_u, std::abs(ux[n]), std::abs(uy[n])});
      size_v = std::max({size_v, std::abs(vx[n]), std::abs(vy[n])});
    }
  }

  /// Sign of the Jacobian where every tangent along u and every one along v span it with that sign, so that
  /// any two points of the patch differ and it is one to one; 0 where this is not shown.
  [[nodiscard]] int orientation() const {
    double ax = 0, ay = 0, bx = 0, by = 0;
    for (int n = 0; n < 12; ++n) {
      ax += ux[n];
      ay += uy[n];
      bx += vx[n];
      by += vy[n];
    }
    const double det = ax * by - ay * bx;
    // Below, the rounding of the control points decides.
    if (!(std::abs(det) > 1e-12 * 144 * size_u * size_v)) return 0;
    // In the frame of the mean tangents a and b: u's tangents near (1, 0), v's near (0, 1).
    double least_u = 1, least_v = 1, most_u = 0, most_v = 0;
    for (int n = 0; n < 12; ++n) {
      least_u = std::min(least_u, (ux[n] * by - uy[n] * bx) / det);
      most_u = std::max(most_u, std::abs((ax * uy[n] - ay * ux[n]) / det));
      least_v = std::min(least_v, (ax * vy[n] - ay * vx[n]) / det);
      most_v = std::max(most_v, std::abs((vx[n] * by - vy[n] * bx) / det));
    }
    if (!(least_u > 0 && least_v > 0 && least_u * least_v > (1 + 1e-9) * most_u * most_v)) return 0;
    return det > 0 ? 1 : -1;
  }
};

/// Whether the patch is a straight line but for `rounding`: seen edge-on, all of it or what lies around a
/// fold.
bool is_line(const RayPatch& p, double rounding) {
  double length = 0, qx = 0, qy = 0;
  for (int n = 1; n < 16; ++n) {
    const double x = p.x[n] - p.x[0], y = p.y[n] - p.y[0];
    const double l = std::hypot(x, y);
    if (l > length) {
      length = l;
      qx = x;
      qy = y;
    }
  }
  double away = 0;
  for (int n = 1; n < 16; ++n)
    away = std::max(away, std::abs(qx * (p.y[n] - p.y[0]) - qy * (p.x[n] - p.x[0])));
  return away <= rounding * length;
}

double value(const double (&c)[16], const double (&u)[4], const double (&v)[4]) {
  double sum = 0;
  for (int s = 0; s < 4; ++s) {
    const double* row = c + 4 * s;
    sum += v[s] * (u[0] * row[0] + u[1] * row[1] + u[2] * row[2] + u[3] * row[3]);
  }
  return sum;
}

/// Newton from the middle. \returns whether it converged within the part, give or take its rounding
bool newton(const RayPatch& p, double& u, double& v) {
  u = v = 0.5;
  double last = 1;
  for (int step = 0; step < 12; ++step) {
    const CubicBasis bu(u), bv(v);
    const double x = value(p.x, bu.b, bv.b), y = value(p.y, bu.b, bv.b);
    const double xu = value(p.x, bu.d, bv.b), yu = value(p.y, bu.d, bv.b);
    const double xv = value(p.x, bu.b, bv.d), yv = value(p.y, bu.b, bv.d);
    const double det = xu * yv - xv * yu;
    const double du = (xv * y - x * yv) / det, dv = (x * yu - xu * y) / det;
    u += du;
    v += dv;
    const double size = std::max(std::abs(du), std::abs(dv));
    if (!(u > -0.5 && u < 1.5 && v > -0.5 && v < 1.5)) return false;  // NaN too
    // Quadratic: after a step of 1e-8 what is left is rounding, and after two that do not shrink as well.
    if (size < 1e-8 || (size < 1e-6 && size > 0.5 * last)) {
      constexpr double kBeside = 1e-9;  // beyond it the winding number and Newton contradict each other
      if (!(std::min(u, v) > -kBeside && std::max(u, v) < 1 + kBeside)) return false;
      u = std::clamp(u, 0.0, 1.0);
      v = std::clamp(v, 0.0, 1.0);
      return true;
    }
    last = size;
  }
  return false;
}

class Search {
 public:
  Search(const RayPatch& patch, std::vector<PatchHit>& hits) : hits_(hits) {
    for (int n = 0; n < 16; ++n) {
      rounding_ = std::max({rounding_, kRounding * std::abs(patch.x[n]), kRounding * std::abs(patch.y[n])});
    }
    visit({patch});
  }

 private:
  void visit(const Part& part) {
    if (side<16>(part.p.y, 1, kNotBelow) != 0 || side<16>(part.p.x, 1, kPositive) != 0) return;
    const Tangents tangents(part.p);
    const int orientation = tangents.orientation();
    const bool is_point = (tangents.size_u <= rounding_ && tangents.size_v <= rounding_) ||
                          (part.level_u >= kPatchLevels && part.level_v >= kPatchLevels);
    if (orientation != 0 || is_point || ++parts_ > kMostParts || is_line(part.p, rounding_)) {
      const int w = winding(part.p, part.level_u, part.level_v);
      if (w == 0) return;
      double u = 0.5, v = 0.5;
      if (is_point || (w == orientation && newton(part.p, u, v))) {
        const double z = value(part.p.z, CubicBasis(u).b, CubicBasis(v).b);
        hits_.push_back(
            {part.u0 + std::ldexp(u, -part.level_u), part.v0 + std::ldexp(v, -part.level_v), z, w});
        return;
      }
    }
    const bool along_u =
        part.level_u < kPatchLevels && (tangents.size_u >= tangents.size_v || part.level_v >= kPatchLevels);
    Part left, right;
    halve(part, along_u, left, right);
    visit(left);
    visit(right);
  }

  std::vector<PatchHit>& hits_;
  double rounding_ = 0;
  int parts_ = 0;
};

/// Numbers so small that halving might make them 0, and change their side, are 0 from the start.
double kept(double x) {
  return std::abs(x) < 1e-200 ? 0.0 : x;
}

}  // namespace

RayFrame::RayFrame(const camera::Ray& ray, const Vec3& near) : along(ray.direction) {
  t_origin = along.dot(near - ray.origin);
  origin = ray.origin + t_origin * along;
  int least = 0;
  along.cwiseAbs().minCoeff(&least);
  across_x = along.cross(Vec3::Unit(least)).normalized();
  across_y = along.cross(across_x);
}

RayPatch::RayPatch(const FacePatch& face, const RayFrame& frame) {
  const auto along = [](const Vec3& axis, const Vec3& p) {
    return kept(axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2]);
  };
  for (int n = 0; n < 16; ++n) {
    const Vec3 p = face[n] - frame.origin;
    x[n] = along(frame.across_x, p);
    y[n] = along(frame.across_y, p);
    z[n] = along(frame.along, p);
  }
}

int winding(const RayPatch& patch) {
  return winding(patch, 0, 0);
}

void append_hits(const RayPatch& patch, std::vector<PatchHit>& hits) {
  Search(patch, hits);
}

}  // namespace vol::curvilinear
