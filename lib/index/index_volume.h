#pragma once
#include <cstdint>

#include "base/buffer.h"
#include "base/vec.h"

namespace vol::index {

/// He's index volume: for each cell of the volume (or block of reduction^3 cells) the L for which 2^L d is a
/// fit sampling distance there, d the standard distance. Half a byte an entry, in memory as in files: two
/// entries a byte along x, low nibble first.
///
/// Entry (i, j, k) governs sampling positions whose index coordinates floor to cell (i, j, k) (the last entry
/// of an axis also the far border). Resolution is the volume's own divided by `reduction`, rounded up.
class IndexVolume {
 public:
  static constexpr int kMaxLevel = 15;

  IndexVolume() = default;
  /// All entries 0: the uniform sampling.
  IndexVolume(const Dims& volume_dims, int reduction, double standard_distance);

  [[nodiscard]] const Dims& volume_dims() const { return volume_dims_; }
  [[nodiscard]] const Dims& dims() const { return dims_; }  ///< number of entries per axis
  [[nodiscard]] int reduction() const { return reduction_; }
  [[nodiscard]] double standard_distance() const { return standard_distance_; }  ///< world length

  /// L of the entry (i, j, k) of the index volume itself.
  [[nodiscard]] int entry(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const auto byte = static_cast<std::size_t>((i >> 1) + row_bytes_ * (j + dims_[1] * k));
    return (nibbles_[byte] >> ((i & 1) * 4)) & 15;
  }
  void set_entry(std::int64_t i, std::int64_t j, std::int64_t k, int level);

  /// Rows of ceil(nx/2) bytes, j then k; words may be read over the end (buffer.h).
  [[nodiscard]] const Buffer<std::uint8_t>& nibbles() const { return nibbles_; }
  [[nodiscard]] Buffer<std::uint8_t>& nibbles() { return nibbles_; }
  [[nodiscard]] std::int64_t row_bytes() const { return row_bytes_; }

 private:
  Dims volume_dims_{0, 0, 0};
  Dims dims_{0, 0, 0};
  int reduction_ = 1;
  double standard_distance_ = 0;
  std::int64_t row_bytes_ = 0;
  Buffer<std::uint8_t> nibbles_;
};

}  // namespace vol::index
