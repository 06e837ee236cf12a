#pragma once
#include <cstdint>

#include "base/buffer.h"
#include "volume/volume.h"

namespace vol::index {

/// Smallest and largest sample around each block of kEdge^3 cells, for empty-space skipping.
///
/// Macrocell (a, b, c) holds the cells i in [kEdge a, kEdge (a + 1)) along x, and so on; its range covers all
/// the samples at corners of its cells, [kEdge a, kEdge (a + 1)] clipped to the volume, so nearest and
/// trilinear values at positions in those cells lie inside it (up to the rounding of the interpolation). An
/// axis of one sample has one macrocell. Ranges are floats rounded outward, so that no sample lies outside: 2
/// floats for 64 voxels, 0.125 byte a voxel.
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

/// One parallel pass over the volume. NaN makes a macrocell's range unspecified; refuse it before.
[[nodiscard]] Macrocells macrocells(const volume::Volume& volume);

}  // namespace vol::index
