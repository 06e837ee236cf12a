#pragma once
#include <optional>

#include "camera/camera.h"
#include "volume/field_sampler.h"

namespace vol::render {

/// Part of a ray inside the field's box, in the ray's t; entry < exit.
struct Chord {
  double entry;
  double exit;
  [[nodiscard]] double length() const { return exit - entry; }
};

/// Intersection of rays with a parallelepiped, by slabs in the box's own coordinates u in [0,1]^3.
class RayBox {
 public:
  /// \throws vol::Error when the box has no volume or is not finite
  explicit RayBox(const volume::FieldBounds& bounds);

  /// The chord from t_min on; none where the ray misses or only touches. A ray in a face counts as inside.
  [[nodiscard]] std::optional<Chord> chord(const camera::Ray& ray, double t_min) const;
  /// Coordinates of a world point, [0,1]^3 in the box.
  [[nodiscard]] Vec3 coordinates(const Vec3& p_world) const { return inverse_ * (p_world - corner_); }
  [[nodiscard]] const Vec3& corner() const { return corner_; }
  /// Displacements in the world to those in the box.
  [[nodiscard]] const Mat3& to_box() const { return inverse_; }

 private:
  Vec3 corner_;
  Mat3 inverse_;
};

/// The longest way through a field's box.
[[nodiscard]] double longest_diagonal(const volume::FieldBounds& bounds);

}  // namespace vol::render
