#pragma once
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace vol::index {

/// A set of grid points, one bit each. Rows along x are padded to whole 64-bit words; the padding is always
/// 0.
class BitGrid {
 public:
  BitGrid() = default;
  explicit BitGrid(const Dims& dims);  ///< the empty set

  [[nodiscard]] const Dims& dims() const { return dims_; }
  [[nodiscard]] std::int64_t words_per_row() const { return words_; }
  [[nodiscard]] bool test(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return (row(j, k)[i >> 6] >> (i & 63) & 1) != 0;
  }
  void set(std::int64_t i, std::int64_t j, std::int64_t k) {
    row(j, k)[i >> 6] |= std::uint64_t{1} << (i & 63);
  }
  /// Row (j, k); the rows of a plane k follow one another.
  [[nodiscard]] std::uint64_t* row(std::int64_t j, std::int64_t k) {
    return bits_.data() + words_ * (j + dims_[1] * k);
  }
  [[nodiscard]] const std::uint64_t* row(std::int64_t j, std::int64_t k) const {
    return bits_.data() + words_ * (j + dims_[1] * k);
  }

 private:
  Dims dims_{0, 0, 0};
  std::int64_t words_ = 0;
  std::vector<std::uint64_t> bits_;
};

/// Sets bits first..last of a row; first <= last, both within it.
void set_bits(std::uint64_t* row, std::int64_t first, std::int64_t last);

}  // namespace vol::index
