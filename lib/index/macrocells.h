#pragma once
#include <cstdint>

#include "base/buffer.h"
#include "volume/field_sampler.h"
#include "volume/volume.h"

namespace vol::index {

/// What values the field takes around each block of kEdge^3 cells, for empty-space skipping.
///
/// Macrocell (a, b, c) holds the cells i in [kEdge a, kEdge (a + 1)) along x, and so on; its range covers the
/// reconstructed field at positions in those cells, up to the rounding of the reconstruction: the convex hull
/// of the samples under the kernel for nearest, trilinear and B-spline (there of its coefficients); for
/// Catmull-Rom, whose weights sum to at most 1.25 in magnitude per axis, the hull widened about its middle by
/// 1.25^3. Neighbouring macrocells share samples, so that their ranges meet. An axis of one sample has one
/// macrocell. Ranges are floats rounded outward: 2 floats for 64 voxels, 0.125 byte a voxel.
struct Macrocells {
  static constexpr int kEdgeLog2 = 2;
  static constexpr int kEdge = 1 << kEdgeLog2;

  struct Range {
    float min;
    float max;
  };

  Dims dims{0, 0, 0};  ///< macrocells per axis
  Buffer<Range> ranges;
  Range all{0, 0};  ///< of the whole volume

  [[nodiscard]] std::size_t offset(std::int64_t a, std::int64_t b, std::int64_t c) const {
    return static_cast<std::size_t>(a + dims[0] * (b + dims[1] * c));
  }
  [[nodiscard]] const Range& operator()(std::int64_t a, std::int64_t b, std::int64_t c) const {
    return ranges[offset(a, b, c)];
  }
};

/// One parallel pass over the volume (B-spline: over its coefficients, in double). NaN makes a macrocell's
/// range unspecified; refuse it before.
[[nodiscard]] Macrocells macrocells(
    const volume::Volume& volume, volume::Reconstruction reconstruction = volume::Reconstruction::trilinear);

}  // namespace vol::index
