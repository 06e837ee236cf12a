#include "camera/camera.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "base/error.h"

namespace vol::camera {
namespace {

/// Right-hand vector of a view: d x up, or, where d is parallel to up, its limit as the elevation comes
/// from the equator: d(e) = d(e0) - s (e0 - e) dd/de with s the sign of e0.
Vec3 right_of(const Vec3& d, const Vec3& d_elevation, double elevation, const Vec3& up) {
  const Vec3 right = d.cross(up);
  constexpr double kParallel = 1e-9;  // sine of the angle below which d x up has lost its direction
  if (right.norm() > kParallel * up.norm()) return right.normalized();
  const Vec3 limit = (elevation >= 0 ? -1.0 : 1.0) * d_elevation.cross(up);
  return limit.normalized();
}

}  // namespace

Camera::Camera(const View& view, const Vec3& centre, double longest_edge, int image_width, int image_height)
    : projection_(view.projection), image_width_(image_width), image_height_(image_height) {
  if (!std::isfinite(view.azimuth)) throw Error("azimuth is not finite");
  if (!(std::abs(view.elevation) <= 90)) {
    throw Error("elevation " + std::to_string(view.elevation) + " is outside -90 to 90 degrees");
  }
  if (!(view.up.norm() > 0) || !view.up.allFinite()) throw Error("camera up is not a direction");
  if (projection_ == Projection::perspective && !(view.fov > 0 && view.fov < 180)) {
    throw Error("field of view " + std::to_string(view.fov) + " is not between 0 and 180 degrees");
  }
  width_ = view.width.value_or(1.6 * longest_edge);
  if (!(width_ > 0) || !std::isfinite(width_)) throw Error("image width in world units is not positive");

  constexpr double kRadians = std::numbers::pi / 180;
  const double a = view.azimuth * kRadians, e = view.elevation * kRadians;
  const bool pole = std::abs(view.elevation) == 90;  // cos(pi/2) is 6e-17 in floating point, not 0
  const double cos_e = pole ? 0.0 : std::cos(e), sin_e = std::sin(e);
  direction_ = Vec3(-cos_e * std::sin(a), -sin_e, -cos_e * std::cos(a));
  const Vec3 d_elevation(sin_e * std::sin(a), -cos_e, sin_e * std::cos(a));
  right_ = right_of(direction_, d_elevation, view.elevation, view.up);
  up_ = right_.cross(direction_);

  const Vec3 target = view.target.value_or(centre);
  if (projection_ == Projection::orthographic) {
    eye_ = target;
  } else {
    const double tan_half = std::tan(0.5 * view.fov * kRadians);
    const double height = width_ * image_height / image_width;
    distance_ = view.distance.value_or(0.5 * height / tan_half);
    if (!(distance_ > 0)) throw Error("camera distance is not positive");
    width_ = 2 * distance_ * tan_half * image_width / image_height;
    eye_ = target - distance_ * direction_;
  }
}

double Camera::t_min() const {
  return projection_ == Projection::perspective ? 0.0 : -std::numeric_limits<double>::infinity();
}

Ray Camera::ray(double x, double y) const {
  const double u = (x / image_width_ - 0.5) * width_;
  const double v = (0.5 * image_height_ - y) / image_width_ * width_;
  const Vec3 offset = u * right_ + v * up_;
  if (projection_ == Projection::orthographic) return {eye_ + offset, direction_};
  return {eye_, (distance_ * direction_ + offset).normalized()};
}

}  // namespace vol::camera
