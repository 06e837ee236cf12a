#pragma once
#include "volume/volume.h"

namespace vol::volume {

/// Regions of the field "texture": four wedges between two oblique planes through the middle.
///   0  waves of 9 to 14 cycles an edge in all directions
///   1  of 20 to 28 in all directions
///   2  of 20 to 28 within 25 degrees of x
///   3  of 20 to 28 within 25 degrees of z
/// Mean, variance and distribution of the values are the same in all of them.
inline constexpr int kTextureRegions = 4;

/// Region of a point of [-1,1]^3. On a plane it is that of the higher number.
[[nodiscard]] int texture_region(const Vec3& p_canonical);

/// The truth for a segmentation: the region of every voxel of "texture" on a grid, u8.
[[nodiscard]] Volume texture_labels(const GridGeometry& geometry);

}  // namespace vol::volume
