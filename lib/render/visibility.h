#pragma once
#include <cstdint>
#include <vector>

#include "transfer/transfer_function.h"
#include "volume/field_sampler.h"
#include "volume/volume.h"

namespace vol::render {

/// What values the field takes in blocks of the grid's cells, by the samples under the reconstruction kernel:
/// the convex hull of the samples for nearest, trilinear and B-spline (its coefficients); for Catmull-Rom,
/// whose weights sum to at most 1.25 in magnitude per axis, the hull widened about its middle by 1.25^3.
class BlockRanges {
 public:
  static constexpr std::int64_t kBlock = 4;  ///< cells an edge

  BlockRanges(const volume::Volume& volume, volume::Reconstruction reconstruction);

  /// Number of the block of a point, box coordinates u in [0,1]^3 (clamped).
  [[nodiscard]] std::size_t block_at(const Vec3& u) const;
  [[nodiscard]] const volume::Range& range(std::size_t block) const { return ranges_[block]; }
  [[nodiscard]] std::size_t size() const { return ranges_.size(); }

 private:
  template <class T>
  void gather(const volume::Grid<T>& grid, std::int64_t margin);

  Dims cells_{1, 1, 1};
  Dims blocks_{1, 1, 1};
  std::vector<volume::Range> ranges_;
};

}  // namespace vol::render
