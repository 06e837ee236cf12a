#include "curvilinear/solid.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "curvilinear/cubic_basis.h"

namespace vol::curvilinear {
namespace {

Point4 mixed(const double (&w)[4], const Point4& p0, const Point4& p1, const Point4& p2, const Point4& p3) {
  return w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3;
}

/// A cubic at 1/2 and its derivative there.
Point4 halfway(const Point4& p0, const Point4& p1, const Point4& p2, const Point4& p3) {
  return 0.125 * ((p0 + p3) + 3 * (p1 + p2));
}
Point4 halfway_slope(const Point4& p0, const Point4& p1, const Point4& p2, const Point4& p3) {
  return 0.75 * ((p3 - p0) + (p2 - p1));
}

/// Adds weight times the derivative D of sample i (0 .. count-1 of those at hand, all `points` there are) to
/// a row.
void add_derivative(double (&row)[4], std::int64_t i, std::int64_t points, std::int64_t first,
                    double weight) {
  const auto add = [&](std::int64_t sample, double x) { row[sample - first] += weight * x; };
  if (points == 2) {
    add(0, -1);
    add(1, 1);
  } else if (i == 0) {
    add(0, -1.5);
    add(1, 2);
    add(2, -0.5);
  } else if (i == points - 1) {
    add(points - 1, 1.5);
    add(points - 2, -2);
    add(points - 3, 0.5);
  } else {
    add(i + 1, 0.5);
    add(i - 1, -0.5);
  }
}

}  // namespace

Point4 Solid::operator()(const Vec3& u) const {
  const CubicBasis x(u[0]), y(u[1]), z(u[2]);
  Point4 sum = Point4::Zero();
  for (std::size_t t = 0; t < 4; ++t) {
    for (std::size_t s = 0; s < 4; ++s) {
      const Point4* row = &b[4 * (s + 4 * t)];
      sum += z.b[t] * y.b[s] * mixed(x.b, row[0], row[1], row[2], row[3]);
    }
  }
  return sum;
}

Point4 Solid::operator()(const Vec3& u, Eigen::Matrix<double, 4, 3>& d) const {
  const CubicBasis x(u[0]), y(u[1]), z(u[2]);
  Point4 sum = Point4::Zero();
  d.setZero();
  for (std::size_t t = 0; t < 4; ++t) {
    Point4 plane = Point4::Zero(), plane_u = Point4::Zero(), plane_v = Point4::Zero();
    for (std::size_t s = 0; s < 4; ++s) {
      const Point4* row = &b[4 * (s + 4 * t)];
      const Point4 along = mixed(x.b, row[0], row[1], row[2], row[3]);
      plane += y.b[s] * along;
      plane_v += y.d[s] * along;
      plane_u += y.b[s] * mixed(x.d, row[0], row[1], row[2], row[3]);
    }
    sum += z.b[t] * plane;
    d.col(0) += z.b[t] * plane_u;
    d.col(1) += z.b[t] * plane_v;
    d.col(2) += z.d[t] * plane;
  }
  return sum;
}

Point4 Solid::centre(Eigen::Matrix<double, 4, 3>& d) const {
  Point4 along_z[16], slope_z[16], along_y[4], slope_y[4], across_z[4];
  for (std::size_t n = 0; n < 16; ++n) {
    along_z[n] = halfway(b[n], b[n + 16], b[n + 32], b[n + 48]);
    slope_z[n] = halfway_slope(b[n], b[n + 16], b[n + 32], b[n + 48]);
  }
  for (std::size_t n = 0; n < 4; ++n) {
    along_y[n] = halfway(along_z[n], along_z[n + 4], along_z[n + 8], along_z[n + 12]);
    slope_y[n] = halfway_slope(along_z[n], along_z[n + 4], along_z[n + 8], along_z[n + 12]);
    across_z[n] = halfway(slope_z[n], slope_z[n + 4], slope_z[n + 8], slope_z[n + 12]);
  }
  d.col(0) = halfway_slope(along_y[0], along_y[1], along_y[2], along_y[3]);
  d.col(1) = halfway(slope_y[0], slope_y[1], slope_y[2], slope_y[3]);
  d.col(2) = halfway(across_z[0], across_z[1], across_z[2], across_z[3]);
  return halfway(along_y[0], along_y[1], along_y[2], along_y[3]);
}

Point4 Solid::face_centre(int axis, Eigen::Matrix<double, 4, 3>& d) const {
  constexpr std::size_t kStride[3] = {1, 4, 16};
  const int first = (axis + 1) % 3, second = (axis + 2) % 3;
  const std::size_t s = kStride[first], t = kStride[second], layer = kStride[axis];
  Point4 along[4], slope[4], inner[4];
  for (std::size_t n = 0; n < 4; ++n) {
    const Point4 *p = &b[3 * layer + n * t], *q = &b[2 * layer + n * t];
    along[n] = halfway(p[0], p[s], p[2 * s], p[3 * s]);
    slope[n] = halfway_slope(p[0], p[s], p[2 * s], p[3 * s]);
    inner[n] = halfway(q[0], q[s], q[2 * s], q[3 * s]);
  }
  const Point4 centre = halfway(along[0], along[1], along[2], along[3]);
  d.col(first) = halfway(slope[0], slope[1], slope[2], slope[3]);
  d.col(second) = halfway_slope(along[0], along[1], along[2], along[3]);
  d.col(axis) = 3 * (centre - halfway(inner[0], inner[1], inner[2], inner[3]));
  return centre;
}

Box3 Solid::hull() const {
  Box3 box{b[0].head<3>(), b[0].head<3>()};
  for (const Point4& p : b) {
    box.min = box.min.cwiseMin(p.head<3>());
    box.max = box.max.cwiseMax(p.head<3>());
  }
  return box;
}

CurveWeights curve_weights(std::int64_t cell, std::int64_t points, CellKind kind, double beta) {
  CurveWeights c;
  if (kind == CellKind::trilinear) {
    c.first = cell;
    c.count = 2;
    constexpr double kThird[4] = {0, 1.0 / 3, 2.0 / 3, 1};
    for (int r = 0; r < 4; ++r) {
      c.w[r][0] = kThird[3 - r];
      c.w[r][1] = kThird[r];
    }
    return c;
  }
  c.first = std::clamp<std::int64_t>(cell - 1, 0, std::max<std::int64_t>(0, points - 4));
  c.count = static_cast<int>(std::min<std::int64_t>(4, points));
  const std::int64_t at = cell - c.first;
  c.w[0][at] = c.w[1][at] = 1;
  c.w[2][at + 1] = c.w[3][at + 1] = 1;
  add_derivative(c.w[1], cell, points, c.first, beta / 3);
  add_derivative(c.w[2], cell + 1, points, c.first, -beta / 3);
  return c;
}

Solids::Solids(const Block& block, std::span<const double> values, CellKind kind, double beta)
    : block_(&block), values_(values), kind_(kind), beta_(beta) {
  if (!(beta > 0 && std::isfinite(beta))) throw Error("beta must be positive and finite");
  if (!values.empty() && values.size() != block.points.size()) {
    throw Error("solids need one value a point of their block");
  }
}

Solid Solids::operator()(const Dims& cell) const {
  const auto along = [&](std::size_t a) { return CurveOperator(cell[a], block_->dims[a], kind_, beta_); };
  const CurveOperator c[3] = {along(0), along(1), along(2)};
  const int nx = c[0].count(), ny = c[1].count(), nz = c[2].count();
  Point4 samples[4], along_x[4][4][4], along_y[4][4][4];  // [z][x][y], [y][x][z]
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      const std::size_t row = block_->offset(c[0].first(), c[1].first() + j, c[2].first() + k);
      for (int i = 0; i < nx; ++i) {
        const std::size_t n = row + static_cast<std::size_t>(i);
        samples[i] << block_->points[n], values_.empty() ? 0.0 : values_[n];
      }
      Point4 b[4];
      c[0](samples, b);
      for (int r = 0; r < 4; ++r) along_x[k][r][j] = b[r];
    }
  }
  for (int k = 0; k < nz; ++k) {
    for (int r = 0; r < 4; ++r) {
      Point4 b[4];
      c[1](along_x[k][r], b);
      for (int s = 0; s < 4; ++s) along_y[s][r][k] = b[s];
    }
  }
  Solid solid;
  for (std::size_t s = 0; s < 4; ++s) {
    for (std::size_t r = 0; r < 4; ++r) {
      Point4 b[4];
      c[2](along_y[s][r], b);
      for (std::size_t t = 0; t < 4; ++t) solid.b[r + 4 * (s + 4 * t)] = b[t];
    }
  }
  return solid;
}

}  // namespace vol::curvilinear
