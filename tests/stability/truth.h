#pragma once
#include <cmath>
#include <vector>

#include "base/vec.h"
#include "camera/camera.h"

// What kernels are held against, in long double (64 bits of mantissa here).
namespace vol::stability {

using Real = long double;

/// Integral of f over [0, 1] by the tanh-sinh rule (Takahasi & Mori 1974): f may have integrable
/// singularities at the ends, and is asked for at (u, 1 - u), each with its own digits.
template <class F>
[[nodiscard]] Real tanh_sinh(const F& f) {
  constexpr Real kHalfPi = 1.57079632679489661923132169163975144L;
  Real sum = 0;
  constexpr int kSteps = 640;
  constexpr Real kStep = 6.6L / kSteps;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const Real t = kStep * static_cast<Real>(i);
    const Real y = kHalfPi * std::sinh(t);
    const Real u = 1 / (1 + std::exp(-2 * y)), v = 1 / (1 + std::exp(2 * y));  // u + v = 1
    const Real weight = 2 * kHalfPi * std::cosh(t) * u * v;
    if (weight > 0) sum += weight * f(u, v);
  }
  return sum * kStep;
}

/// -log(1 - a) where a runs from a0 to a1, at the share u of the way, v = 1 - u.
[[nodiscard]] inline Real ramp_depth(Real a0, Real a1, Real u, Real v) {
  const Real a = v * a0 + u * a1;
  return a < 0.5L ? -std::log1p(-a) : -std::log(v * (1 - a0) + u * (1 - a1));
}

/// A ray's way through the box [corner, corner + size], 0 where it misses; and what rounding of positions may
/// do to it: each end is known to `ulps` roundings of the numbers it is made of, over the cosine that the ray
/// makes with the face it passes.
struct TrueChord {
  Real length = 0;
  double entry = 0, exit = 0;
  double condition = 0;  ///< of both ends, in units of one rounding
};
[[nodiscard]] inline TrueChord true_chord(const Vec3& corner, const Vec3& size, const camera::Ray& ray,
                                          double t_min) {
  Real entry = t_min, exit = std::numeric_limits<Real>::infinity();
  double entry_condition = 0, exit_condition = 0;
  for (int a = 0; a < 3; ++a) {
    const Real o = ray.origin[a], d = ray.direction[a];
    Real low = static_cast<Real>(corner[a]), high = low + static_cast<Real>(size[a]);
    if (d == 0) {
      if (o < low || o > high) return {};
      continue;
    }
    if (d < 0) std::swap(low, high);
    const double condition =
        (std::abs(corner[a]) + std::abs(size[a]) + std::abs(ray.origin[a])) / std::abs(ray.direction[a]);
    const Real near = (low - o) / d, far = (high - o) / d;
    if (near > entry) {
      entry = near;
      entry_condition = condition;
    }
    if (far < exit) {
      exit = far;
      exit_condition = condition;
    }
  }
  const Real length = exit > entry ? exit - entry : 0;
  return {length, static_cast<double>(entry), static_cast<double>(exit), entry_condition + exit_condition};
}

}  // namespace vol::stability
