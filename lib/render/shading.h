#pragma once
#include "render/options.h"

namespace vol::render {

/// What light does to the colour c of a point: c diffuse + specular (white highlight).
struct Lit {
  double diffuse = 1;
  double specular = 0;

  [[nodiscard]] Vec3 operator()(const Vec3& colour) const {
    return colour * diffuse + Vec3::Constant(specular);
  }
};

/// Blinn-Phong (Blinn 1977) with the normal N = -grad f / |grad f|:
///   diffuse = ambient + kd |N.L|,  specular = ks |N.H|^exponent,  H = (L + V) / |L + V|, V = -d.
/// Both sides of a level set are lit alike (the absolute values): in a translucent medium neither side is the
/// outside, and so the picture does not change with the sign of f. Where the gradient vanishes: ambient only.
class BlinnPhong {
 public:
  /// \throws vol::Error on a coefficient that is negative or not finite, or a light of no direction
  explicit BlinnPhong(const Shading& shading);

  /// \param gradient  world gradient of the field
  /// \param direction unit direction of the ray
  [[nodiscard]] Lit operator()(const Vec3& gradient, const Vec3& direction) const;
  /// Upper bounds of `diffuse` and `specular`.
  [[nodiscard]] Lit brightest() const { return {shading_.ambient + shading_.diffuse, shading_.specular}; }

 private:
  Shading shading_;
};

}  // namespace vol::render
