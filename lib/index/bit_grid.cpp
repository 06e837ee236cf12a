#include "index/bit_grid.h"

#include "base/checked.h"

namespace vol::index {

BitGrid::BitGrid(const Dims& dims) : dims_(dims), words_((dims[0] + 63) / 64) {
  (void)checked_count(dims);
  bits_.assign(static_cast<std::size_t>(words_ * dims[1] * dims[2]), 0);
}

void set_bits(std::uint64_t* row, std::int64_t first, std::int64_t last) {
  const std::int64_t first_word = first >> 6, last_word = last >> 6;
  const std::uint64_t head = ~std::uint64_t{0} << (first & 63),
                      tail = ~std::uint64_t{0} >> (63 - (last & 63));
  if (first_word == last_word) {
    row[first_word] |= head & tail;
    return;
  }
  row[first_word] |= head;
  for (std::int64_t w = first_word + 1; w < last_word; ++w) row[w] = ~std::uint64_t{0};
  row[last_word] |= tail;
}

}  // namespace vol::index
