#pragma once
#include <array>
#include <cstdint>
#include <mutex>
#include <vector>

#include "base/buffer.h"
#include "index/macrocells.h"
#include "transfer/transfer_function.h"

namespace vol::render {

/// How far it is from each macrocell to one that the transfer function may make visible.
///
/// distance 0: visible; D > 0: every macrocell less than D away (largest of the three differences of index,
/// Chebyshev) is invisible, so that a ray may leave all (2 D - 1)^3 of them behind at once (Sramek and
/// Kaufman 2000). At most 255, which stands for any larger distance too.
struct Visibility {
  Dims dims{0, 0, 0};
  Buffer<std::uint8_t> distance;
  bool all_visible = true;

  /// Of the macrocell of a point, box coordinates u in [0,1]^3 (clamped) of a field of `dims` samples.
  [[nodiscard]] std::size_t offset(const Vec3& u, const Dims& samples) const;
};

/// The same for rays that go to one octant, which are not held up by what they pass or leave behind (Deakin
/// and Knackstedt 2020): distance D > 0: the D^3 macrocells less than D away, along each axis in the
/// direction of the rays, are invisible. A table an octant, each made when it is asked for first, by any
/// thread.
class VisibilityAhead {
 public:
  /// \param of  must live longer
  explicit VisibilityAhead(const Visibility& of) : of_(of) {}

  /// \param octant  x + 2 y + 4 z, each 1 where the rays go down along that axis; where they stay, either
  [[nodiscard]] const Buffer<std::uint8_t>& distance(int octant) const;

 private:
  struct Table {
    std::once_flag made;
    Buffer<std::uint8_t> distance;
  };
  const Visibility& of_;
  mutable std::array<Table, 8> tables_;
};

/// An invisible macrocell is one whose range, widened by the rounding of single-precision reconstruction,
/// lies where opacity is 0.
[[nodiscard]] Visibility visibility(const index::Macrocells& cells,
                                    const transfer::TransferFunction& transfer);

/// The closed intervals of values where opacity is 0, in order; the outermost may be unbounded.
[[nodiscard]] std::vector<volume::Range> invisible_values(const transfer::TransferFunction& transfer);

/// The grid's range around a macrocell as visibility() takes it: widened by 1e-6 of what rounding scales
/// with.
[[nodiscard]] volume::Range widened(const index::Macrocells::Range& range,
                                    const index::Macrocells::Range& all);

}  // namespace vol::render
