#pragma once
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace vol::index {

/// A set of grid points, one bit each: 256^3 points are 2 MiB, so that sets are combined and dilated at the speed
/// of the second-level cache. Rows along x are padded to whole 64-bit words; the padding is always 0.
class BitGrid {
 public:
  BitGrid() = default;
  explicit BitGrid(const Dims& dims);  ///< the empty set

  [[nodiscard]] const Dims& dims() const { return dims_; }
  [[nodiscard]] std::int64_t words_per_row() const { return words_; }
  [[nodiscard]] bool test(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return (row(j, k)[i >> 6] >> (i & 63) & 1) != 0;
  }
  void set(std::int64_t i, std::int64_t j, std::int64_t k) { row(j, k)[i >> 6] |= std::uint64_t{1} << (i & 63); }
  [[nodiscard]] std::uint64_t* row(std::int64_t j, std::int64_t k) { return bits_.data() + words_ * (j + dims_[1] * k); }
  [[nodiscard]] const std::uint64_t* row(std::int64_t j, std::int64_t k) const {
    return bits_.data() + words_ * (j + dims_[1] * k);
  }

  BitGrid& operator|=(const BitGrid& other);  ///< union; both of the same dims

  /// Replaces the set by { i : some i' of the set with i - before <= i' <= i + after }, before, after >= 0, along
  /// one axis; the grid does not wrap. Windows are built by doubling: log2(before) + log2(after) passes.
  void dilate(int axis, std::int64_t before, std::int64_t after);

 private:
  /// set |= set shifted so that point i takes what point i + offset had.
  void unite_with_shift(int axis, std::int64_t offset);

  Dims dims_{0, 0, 0};
  std::int64_t words_ = 0;
  std::vector<std::uint64_t> bits_;
};

}  // namespace vol::index
