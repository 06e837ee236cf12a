#pragma once
#include <limits>

#include "camera/camera.h"
#include "curvilinear/solid.h"

namespace vol::curvilinear {

/// Solids as a camera sees them. View coordinates have x to the right, y down and z into the scene:
/// orthographic in pixels, so that x and y are image positions; perspective in world units from the eye.
/// Turned and scaled alike along all axes, so that lengths and angles stay.
class Screen {
 public:
  explicit Screen(const camera::Camera& camera);

  [[nodiscard]] bool is_perspective() const { return perspective_; }
  [[nodiscard]] Vec3 view(const Vec3& world) const { return turn_ * (world - eye_) + offset_; }
  /// The points of a block, whose solids are then the block's as seen.
  [[nodiscard]] Block view(const Block& world) const;
  /// Image position of view coordinates, pixels; pixel (i, j)'s centre is (i + 0.5, j + 0.5).
  [[nodiscard]] Eigen::Vector2d project(const Vec3& v) const {
    if (!perspective_) return v.head<2>();
    return middle_ + focal_ / v.z() * v.head<2>();
  }
  /// Direction of the ray through view coordinates, a unit vector of them.
  [[nodiscard]] Vec3 direction(const Vec3& v) const {
    return perspective_ ? Vec3(v.normalized()) : Vec3(0, 0, 1);
  }
  /// Whether what lies there is in front of the eye; always so where there is none.
  [[nodiscard]] bool in_front(const Vec3& v) const { return !perspective_ || v.z() > 0; }
  /// Pixels that a unit of view coordinates spans there, across the ray.
  [[nodiscard]] double pixels(const Vec3& v) const { return perspective_ ? focal_ / v.z() : 1; }
  /// Pixels over which what is linear along a plane is so in the picture: of a perspective view a fiftieth of
  /// the eye's distance, where the error, a bend of 1 / 8 of its square, is 5e-5.
  [[nodiscard]] double linear_pixels() const {
    return perspective_ ? 0.02 * focal_ : std::numeric_limits<double>::infinity();
  }
  /// Whether the parameter along an axis grows (1) or falls (-1) along the ray through a point where a solid
  /// has the derivatives d, in view coordinates; 0: neither.
  [[nodiscard]] int runs_away(const Vec3& at, const Eigen::Matrix<double, 4, 3>& d, int axis) const;
  [[nodiscard]] double world_length() const { return world_length_; }  ///< of a unit of view coordinates

 private:
  bool perspective_;
  Mat3 turn_;
  Vec3 eye_, offset_;
  Eigen::Vector2d middle_;
  double focal_ = 0;  // pixels
  double world_length_ = 1;
};

}  // namespace vol::curvilinear
