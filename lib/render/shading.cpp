#include "render/shading.h"

#include <cmath>

#include "base/error.h"

namespace vol::render {

BlinnPhong::BlinnPhong(const Shading& shading) : shading_(shading) {
  for (const double k : {shading.ambient, shading.diffuse, shading.specular, shading.exponent}) {
    if (!(k >= 0) || !std::isfinite(k)) throw Error("shading coefficient that is negative or not finite");
  }
  if (shading_.light) {
    const double norm = shading_.light->stableNorm();
    if (!(norm > 0) || !std::isfinite(norm)) throw Error("light is not a direction");
    *shading_.light /= norm;
  }
}

Lit BlinnPhong::operator()(const Vec3& gradient, const Vec3& direction) const {
  const double norm = gradient.stableNorm();  // no underflow for gradients of 1e-200
  if (!(norm > 0)) return {shading_.ambient, 0};
  const Vec3 normal = -gradient / norm;
  const Vec3 view = -direction;
  const Vec3 light = shading_.light.value_or(view);
  const Vec3 between = light + view;
  const double length = between.norm();
  const double n_dot_h = length > 0 ? std::abs(normal.dot(between)) / length : 0;
  return {shading_.ambient + shading_.diffuse * std::abs(normal.dot(light)),
          shading_.specular * std::pow(n_dot_h, shading_.exponent)};
}

}  // namespace vol::render
