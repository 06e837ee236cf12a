#pragma once
#include <cmath>
#include <limits>
#include <type_traits>

#include "volume/volume.h"

namespace vol::volume {

/// A value as a voxel of type T: integers rounded to nearest even and clamped to the type's range.
template <class T>
[[nodiscard]] T stored_as(double value) {
  if constexpr (std::is_integral_v<T>) {
    return static_cast<T>(
        std::fmin(std::fmax(std::nearbyint(value), static_cast<double>(std::numeric_limits<T>::min())),
                  static_cast<double>(std::numeric_limits<T>::max())));
  } else if constexpr (std::is_same_v<T, half>) {
    return half(static_cast<float>(value));
  } else {
    return static_cast<T>(value);
  }
}

/// The same voxels as another type, rounded and clamped as stored_as() says; attributes are kept.
[[nodiscard]] Volume as_type(Volume volume, VoxelType type);

/// a v + b for every voxel v, in double, as the given type.
[[nodiscard]] Volume scaled(const Volume& volume, double a, double b, VoxelType type);

/// The linear map that takes the volume's range to [lo, hi], as scaled() does it. A constant volume becomes
/// lo.
[[nodiscard]] Volume rescaled(const Volume& volume, double lo, double hi, VoxelType type);

/// f - g voxel by voxel, with the geometry and attributes of f, in a type that holds every difference: i16
/// for 8-bit integers, f32 where both are at most 16-bit integers or one is f32 or f16 (there rounded), else
/// f64. Throws vol::Error where the dims differ.
[[nodiscard]] Volume difference(const Volume& f, const Volume& g);

}  // namespace vol::volume
