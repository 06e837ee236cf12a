#pragma once
#include "volume/volume.h"

namespace vol::fourier {

struct CannyOptions {
  double sigma = 1;  ///< of the Gaussian before differences are taken, in voxels
  double low = 0.1;  ///< thresholds, as shares of the largest gradient
  double high = 0.2;
};

/// What canny_edges() takes while it works, bytes a voxel, result included: two boxes of floats, two of
/// bytes, and the growing list of voxels to go on from (8 bytes each, thrice while it grows, half the voxels
/// at most).
inline constexpr std::int64_t kCannyBytes = 22;

/// Canny 1986 in three dimensions: 1 at edge voxels, else 0. Smoothing by a Gaussian cut at 3 sigma,
/// replicated border; central differences in world lengths; a voxel stays if its gradient is at least that of
/// both neighbours (trilinear) one smallest spacing along the gradient, is at least `high`, or at least `low`
/// and joined to such a one through the 26 neighbours. \throws vol::Error unless sigma >= 0 and 0 <= low <=
/// high <= 1
[[nodiscard]] Buffer<std::uint8_t> canny_edges(const volume::Volume& volume,
                                               const CannyOptions& options = {});

}  // namespace vol::fourier
