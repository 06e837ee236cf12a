#pragma once
#include <array>
#include <string_view>

#include "volume/volume.h"

// Voxels moved, never changed. Unless said otherwise the geometry follows, so that every voxel keeps its
// place in the world and the field is the same field.
namespace vol::volume {

/// The voxels of a half-open box of indices; throws vol::Error where it is empty or leaves the volume.
[[nodiscard]] Volume cropped(const Volume& volume, const Dims& lower, const Dims& upper);

/// `margin` voxels of `value` (rounded and clamped to the type) on all six sides.
[[nodiscard]] Volume padded(const Volume& volume, std::int64_t margin, double value);

/// The voxels in reverse order along an axis (0, 1, 2); the axis direction is reversed with them.
[[nodiscard]] Volume flipped(const Volume& volume, int axis);

/// Axis a of the result is axis order[a] of the volume; throws vol::Error unless order is a permutation.
[[nodiscard]] Volume transposed(const Volume& volume, const std::array<int, 3>& order);

/// "zyx" as {2, 1, 0}; throws vol::Error unless it names each axis once.
[[nodiscard]] std::array<int, 3> axis_order(std::string_view text);

}  // namespace vol::volume
