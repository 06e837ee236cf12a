#pragma once
#include <functional>

#include "render/fields.h"
#include "truth.h"

// What rays are cast through: grids from functions, and the homogeneous medium's closed form.
namespace vol::stability {

using render::Quadrature;

struct Rule {
  const char* name;
  Quadrature quadrature;
};
inline const Rule kStepped[] = {{"rectangle", Quadrature::rectangle},
                                {"trapezoid", Quadrature::trapezoid},
                                {"preintegrated", Quadrature::preintegrated}};

inline volume::Volume grid(const Dims& dims, const Vec3& spacing,
                           const std::function<double(const Dims&)>& f) {
  volume::Grid<double> result;
  result.geometry.dims = dims;
  result.geometry.spacing = spacing;
  result.geometry.origin = Vec3(-3, 5, 2);
  result.voxels = Buffer<double>(static_cast<std::size_t>(result.geometry.count()));
  std::size_t n = 0;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) result.voxels[n++] = f({i, j, k});
    }
  }
  return {std::move(result), {}};
}

inline volume::Volume half(const Dims& dims, const Vec3& spacing) {
  return grid(dims, spacing, [](const Dims&) { return 0.5; });
}

inline const Vec3 kColour(0.2, 0.5, 0.9);

/// Homogeneous medium along a chord: 1 - (1 - a)^(length/reference).
inline Real true_alpha(double opacity, double reference_length, Real length) {
  if (length == 0) return 0;  // also of an opaque medium
  return -std::expm1(length / static_cast<Real>(reference_length) * std::log1p(-static_cast<Real>(opacity)));
}

inline double nodes(const TrueChord& chord, double step) {
  return std::max(1.0, std::ceil(static_cast<double>(chord.length) / step));
}

}  // namespace vol::stability
