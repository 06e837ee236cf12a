#pragma once
#include <concepts>

#include "base/vec.h"

namespace vol::volume {

/// The parallelepiped in world space on which a field lives: corner + edges * u, u in [0,1]^3.
struct FieldBounds {
  Vec3 corner = Vec3::Zero();
  Mat3 edges = Mat3::Identity();  ///< columns: the three edge vectors

  [[nodiscard]] Vec3 centre() const { return corner + 0.5 * (edges.col(0) + edges.col(1) + edges.col(2)); }
  [[nodiscard]] double longest_edge() const { return edges.colwise().norm().maxCoeff(); }
};

/// The one question every renderer, isosurfacer and resampler asks: value and gradient at a world point.
/// Grids with a reconstruction kernel, wavelet expansions, curvilinear grids and closed-form fields model it, so
/// that quadrature error can be measured with reconstruction error exactly zero.
///   value(p)     the field at world point p; p outside the bounds is clamped to them
///   gradient(p)  world gradient, in value per world length
///   bounds()     where the field lives
template <class F>
concept FieldSampler = requires(const F& f, const Vec3& p) {
  { f.value(p) } -> std::convertible_to<double>;
  { f.gradient(p) } -> std::convertible_to<Vec3>;
  { f.bounds() } -> std::convertible_to<FieldBounds>;
};

/// How a grid of samples becomes a field. Catmull-Rom interpolates; the cubic B-spline interpolates only
/// because its coefficients are prefiltered.
enum class Reconstruction { nearest, trilinear, catmull_rom, b_spline };

}  // namespace vol::volume
