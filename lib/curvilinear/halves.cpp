#include "curvilinear/halves.h"

#include <algorithm>

#include "curvilinear/sheet_parts.h"

namespace vol::curvilinear {
namespace {

constexpr std::size_t kStride[3] = {1, 4, 16};

/// Cosine of the ray with the normal of the sheet at a corner, bit a of which is its end along axis a.
double cosine_at_corner(const Solid& solid, const Screen& screen, std::size_t corner) {
  std::size_t at = 0;
  for (std::size_t a = 0; a < 3; ++a) at += (corner >> a & 1) * 3 * kStride[a];
  const Vec3 p = solid.b[at].head<3>();
  Vec3 along[2];
  for (std::size_t a = 0; a < 2; ++a) {
    const bool end = (corner >> a & 1) != 0;
    const Vec3 next = solid.b[end ? at - kStride[a] : at + kStride[a]].head<3>();
    along[a] = end ? Vec3(p - next) : Vec3(next - p);
  }
  const Vec3 normal = along[0].cross(along[1]);
  const double length = normal.norm();
  return length > 0 ? normal.dot(screen.direction(p)) / length : 0;
}

/// The cubic's polar form.
Point4 blossom(const Point4 (&b)[4], double s, double t, double u) {
  const auto between = [](const Point4& p, const Point4& q, double x) -> Point4 {
    return (1 - x) * p + x * q;
  };
  const Point4 p0 = between(b[0], b[1], s), p1 = between(b[1], b[2], s), p2 = between(b[2], b[3], s);
  return between(between(p0, p1, t), between(p1, p2, t), u);
}

}  // namespace

Solid part(const Solid& solid, const Vec3& low, const Vec3& high) {
  Solid cut = solid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double from = low[static_cast<int>(axis)], to = high[static_cast<int>(axis)];
    if (from == 0 && to == 1) continue;
    const std::size_t s = kStride[axis];
    for (std::size_t n = 0; n < 64; ++n) {
      if (n / s % 4 != 0) continue;
      const Point4 b[4] = {cut.b[n], cut.b[n + s], cut.b[n + 2 * s], cut.b[n + 3 * s]};
      cut.b[n] = blossom(b, from, from, from);
      cut.b[n + s] = blossom(b, from, from, to);
      cut.b[n + 2 * s] = blossom(b, from, to, to);
      cut.b[n + 3 * s] = blossom(b, to, to, to);
    }
  }
  return cut;
}

std::array<Solid, 2> halves(const Solid& solid, std::size_t axis) {
  std::array<Solid, 2> parts;
  const std::size_t s = kStride[axis];
  for (std::size_t n = 0; n < 64; ++n) {
    if (n / s % 4 != 0) continue;
    const Point4 &b0 = solid.b[n], &b1 = solid.b[n + s], &b2 = solid.b[n + 2 * s], &b3 = solid.b[n + 3 * s];
    const Point4 b01 = 0.5 * (b0 + b1), b12 = 0.5 * (b1 + b2), b23 = 0.5 * (b2 + b3);
    const Point4 b012 = 0.5 * (b01 + b12), b123 = 0.5 * (b12 + b23), middle = 0.5 * (b012 + b123);
    const Point4 left[4] = {b0, b01, b012, middle}, right[4] = {middle, b123, b23, b3};
    for (std::size_t r = 0; r < 4; ++r) {
      parts[0].b[n + r * s] = left[r];
      parts[1].b[n + r * s] = right[r];
    }
  }
  return parts;
}

int axis_to_halve(const Solid& oriented, const Screen& screen, double throttle) {
  Eigen::Matrix<double, 4, 3> d;
  const Vec3 centre = oriented.centre(d).head<3>();
  const Vec3 normal = d.col(0).head<3>().cross(d.col(1).head<3>());
  if (!(normal.norm() > 0)) return -1;
  const double middle = normal.normalized().dot(screen.direction(centre));
  bool turns = false;
  for (std::size_t corner = 0; corner < 8 && !turns; ++corner) {
    const double c = cosine_at_corner(oriented, screen, corner);
    turns = c != 0 && c * middle < 0.3 * middle * middle;
  }
  if (!turns) return -1;
  const Extents e = extents(oriented, screen);
  if (std::max({e.across[0], e.across[1], e.across[2]}) < kLeastPixels * throttle) return -1;
  int worst = -1;
  double largest = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    double bend = 0;
    for (std::size_t n = 0; n < 64; ++n) {
      if (n / kStride[a] % 4 > 1) continue;
      const Point4 second = oriented.b[n] - 2 * oriented.b[n + kStride[a]] + oriented.b[n + 2 * kStride[a]];
      bend = std::max(bend, second.head<3>().norm());
    }
    if (bend > largest) {
      largest = bend;
      worst = static_cast<int>(a);
    }
  }
  return worst;
}

}  // namespace vol::curvilinear
