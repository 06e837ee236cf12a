#pragma once
#include <optional>

#include "base/vec.h"

namespace vol::camera {

/// Half line in world space; direction is a unit vector, so the ray parameter t is world length.
struct Ray {
  Vec3 origin;
  Vec3 direction;
};

enum class Projection { orthographic, perspective };

/// A view, in the user's terms. Angles in degrees.
struct View {
  double azimuth = 0;                    ///< 0,0 looks from +z along -z; positive moves the camera toward +x
  double elevation = 0;                  ///< positive moves the camera up; in [-90, 90]
  Vec3 up{0, 1, 0};
  Projection projection = Projection::orthographic;
  std::optional<double> width;           ///< world width of the image (orthographic); default 1.6 longest edge
  double fov = 30;                       ///< vertical field of view (perspective), in (0, 180)
  std::optional<double> distance;        ///< eye to target (perspective); default: the target plane shows `width`
  std::optional<Vec3> target;            ///< default: the centre of the field's box
};

/// The one place that knows the camera of lib/README.md: pixels to rays.
///
/// Direction into the scene d = (-cos e sin a, -sin e, -cos e cos a); right = d x up, at the poles its limit
/// along the meridian; image up = right x d. Pixel (i, j), row 0 at the top, has its centre at
/// ((i + 1/2) / W - 1/2) width to the right and ((H/2 - (j + 1/2)) / W) width up: pixels are square.
/// Orthographic rays start on the plane through the target, and their t may be negative.
class Camera {
 public:
  /// \param centre       world centre of the field's box, the default target
  /// \param longest_edge longest world edge of the box, for the default width
  /// \throws vol::Error on an elevation or field of view out of range, a zero `up`, a width not positive
  Camera(const View& view, const Vec3& centre, double longest_edge, int image_width, int image_height);

  /// Ray through image position (x, y) in pixels: pixel (i, j)'s centre is (i + 0.5, j + 0.5).
  [[nodiscard]] Ray ray(double x, double y) const;
  [[nodiscard]] const Vec3& direction() const { return direction_; }  ///< into the scene
  [[nodiscard]] const Vec3& right() const { return right_; }
  [[nodiscard]] const Vec3& up() const { return up_; }
  [[nodiscard]] const Vec3& eye() const { return eye_; }  ///< eye (perspective) or target (orthographic)
  [[nodiscard]] Projection projection() const { return projection_; }
  [[nodiscard]] double width() const { return width_; }   ///< world width of the image in the target plane
  [[nodiscard]] double distance() const { return distance_; }  ///< eye to target (perspective)
  [[nodiscard]] int image_width() const { return image_width_; }
  [[nodiscard]] int image_height() const { return image_height_; }
  /// Smallest t at which a ray may meet the field: 0 (the eye) for perspective, -infinity for orthographic.
  [[nodiscard]] double t_min() const;

 private:
  Projection projection_;
  Vec3 eye_, direction_, right_, up_;
  double width_ = 0;
  double distance_ = 0;
  int image_width_, image_height_;
};

}  // namespace vol::camera
