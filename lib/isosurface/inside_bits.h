#pragma once
#include <cstdint>

#include "base/buffer.h"
#include "base/vec.h"

namespace vol::isosurface {

/// One bit a sample, 1 where it is at least the isovalue; rows along x begin at a new word, unused bits are
/// 0.
struct InsideBits {
  enum class Row : std::uint8_t { outside, inside, mixed };

  Dims dims{};
  std::int64_t words = 0;  ///< a row
  Buffer<std::uint64_t> bits;
  Buffer<Row> rows;  ///< what each row is all of, by j + ny k

  [[nodiscard]] const std::uint64_t* row(std::int64_t r) const { return bits.data() + r * words; }
};

/// Bits of the samples of a grid, `pad` (0 or 1) samples outside added at every end of every axis.
/// For T any voxel type.
template <class T>
[[nodiscard]] InsideBits inside_bits(const T* samples, const Dims& dims, double isovalue, int pad);

}  // namespace vol::isosurface
