#include "render/ray_box.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"

namespace vol::render {

RayBox::RayBox(const volume::FieldBounds& bounds) : corner_(bounds.corner) {
  // Columns are scaled to unit length first: a determinant of edges 1e-120 long would underflow.
  const Vec3 lengths = bounds.edges.colwise().norm();
  if (!bounds.edges.allFinite() || !corner_.allFinite() || !(lengths.minCoeff() > 0)) {
    throw Error("the field's box has an edge that is zero or not finite");
  }
  const Mat3 unit = bounds.edges * lengths.cwiseInverse().asDiagonal();
  if (!(std::abs(unit.determinant()) > 1e-12))
    throw Error("the field's box is flat: its edges lie in a plane");
  inverse_ = lengths.cwiseInverse().asDiagonal() * unit.inverse();
}

std::optional<Chord> RayBox::chord(const camera::Ray& ray, double t_min) const {
  const Vec3 o = coordinates(ray.origin);
  const Vec3 d = inverse_ * ray.direction;
  Chord chord{t_min, std::numeric_limits<double>::infinity()};
  for (int a = 0; a < 3; ++a) {
    if (d[a] == 0) {
      if (o[a] < 0 || o[a] > 1) return std::nullopt;
      continue;
    }
    double near = -o[a] / d[a];
    double far = (1 - o[a]) / d[a];
    if (near > far) std::swap(near, far);
    chord.entry = std::max(chord.entry, near);
    chord.exit = std::min(chord.exit, far);
  }
  if (!(chord.exit > chord.entry)) return std::nullopt;
  return chord;
}

double longest_diagonal(const volume::FieldBounds& bounds) {
  const Mat3& edges = bounds.edges;
  double longest = 0;
  for (const double y : {-1.0, 1.0}) {
    for (const double z : {-1.0, 1.0}) {
      longest = std::max(longest, (edges.col(0) + y * edges.col(1) + z * edges.col(2)).norm());
    }
  }
  return longest;
}

}  // namespace vol::render
