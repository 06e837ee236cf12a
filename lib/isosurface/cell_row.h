#pragma once
#include <bit>
#include <cstdint>

#include "isosurface/inside_bits.h"

namespace vol::isosurface {

/// Four rows of bits about a row of cells, word by word: each word and the one moved down by a bit.
class CellRow {
 public:
  CellRow(const InsideBits& bits, std::int64_t r)
      : words_(bits.words),
        cells_(bits.dims[0] - 1),
        row_{bits.row(r), bits.row(r + 1), bits.row(r + bits.dims[1]), bits.row(r + bits.dims[1] + 1)} {}

  /// Calls f(i, corners) for every cell that is neither all inside nor all outside.
  template <class F>
  void for_active(const F& f) const {
    for (std::int64_t w = 0; 64 * w < cells_; ++w) {
      std::uint64_t low[4];
      std::uint64_t high[4];
      std::uint64_t any = 0;
      std::uint64_t all = ~std::uint64_t{0};
      for (int n = 0; n < 4; ++n) {
        low[n] = row_[n][w];
        high[n] = low[n] >> 1 | (w + 1 < words_ ? row_[n][w + 1] << 63 : 0);
        any |= low[n] | high[n];
        all &= low[n] & high[n];
      }
      std::uint64_t active = any & ~all;
      if (const std::int64_t left = cells_ - 64 * w; left < 64) active &= (std::uint64_t{1} << left) - 1;
      for (; active != 0; active &= active - 1) {
        const int s = std::countr_zero(active);
        unsigned corners = 0;
        for (int n = 0; n < 4; ++n) {
          corners |= static_cast<unsigned>((low[n] >> s & 1) | (high[n] >> s & 1) << 1) << (2 * n);
        }
        f(64 * w + s, static_cast<int>(corners));
      }
    }
  }

 private:
  std::int64_t words_;
  std::int64_t cells_;
  const std::uint64_t* row_[4];
};

/// The crossings of word w of a row with its neighbours along x; n samples a row.
inline std::uint64_t x_crossings(const std::uint64_t* row, std::int64_t w, std::int64_t words,
                                 std::int64_t n) {
  const std::uint64_t moved = row[w] >> 1 | (w + 1 < words ? row[w + 1] << 63 : 0);
  std::uint64_t cut = row[w] ^ moved;
  if (const std::int64_t left = n - 1 - 64 * w; left < 64)
    cut &= left <= 0 ? 0 : (std::uint64_t{1} << left) - 1;
  return cut;
}

}  // namespace vol::isosurface
