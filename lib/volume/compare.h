#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "volume/volume.h"

namespace vol::volume {

/// Error of a volume t against a reference r of the same dims, voxel by voxel, whatever the two types.
///
/// Infinity and NaN are not passed over: equal infinities differ by 0, infinities of opposite sign, or an
/// infinity and a number, by infinity; one NaN in either volume makes the figures NaN. All sums are
/// compensated and folded in a fixed order; values of any size a double holds are scaled by a power of two
/// before they are squared, so that rmse and what derives from it neither overflow nor vanish.
struct VolumeError {
  double mse = 0;      ///< mean (t - r)^2
  double rmse = 0;     ///< sqrt(mse)
  double mae = 0;      ///< mean |t - r|
  double maximum = 0;  ///< max |t - r|
  std::array<std::int64_t, 3> maximum_at{
      -1, -1, -1};             ///< voxel of the maximum, the first in memory; -1: none differs
  Range reference_range;       ///< smallest and largest finite value of the reference
  double rmse_byte = 0;        ///< rmse 255 / (max - min) of the reference; infinite where that is constant
  double psnr = 0;             ///< 20 log10((max - min) / rmse), in dB; +infinity for equal volumes
  double relative_l2 = 0;      ///< sqrt(sum (t - r)^2 / sum r^2); infinite where the reference is 0
  std::int64_t differing = 0;  ///< voxels with t != r
  std::int64_t nan = 0;        ///< NaN values, in both together
  std::int64_t infinite = 0;   ///< infinite values, in both together
};

/// Throws vol::Error where the dims differ, naming both.
[[nodiscard]] VolumeError compare(const Volume& tested, const Volume& reference);

/// In what two grids of equal dims lie differently in the world, one sentence each. What a header of 32-bit
/// floats cannot tell apart counts as equal: spacing to 1e-6, direction to 1e-5, origin to 1e-4 of a voxel.
[[nodiscard]] std::vector<std::string> geometry_differences(const GridGeometry& tested,
                                                            const GridGeometry& reference);

}  // namespace vol::volume
