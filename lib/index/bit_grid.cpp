#include "index/bit_grid.h"

#include <algorithm>
#include <cstdlib>

#include "base/checked.h"
#include "base/parallel.h"

namespace vol::index {
namespace {

/// row |= row shifted, within its own words: bit i takes bit i + offset. In place, from the side it reads from.
void unite_row(std::uint64_t* row, std::int64_t words, std::int64_t offset) {
  const std::int64_t whole = std::abs(offset) >> 6;
  const int part = static_cast<int>(std::abs(offset) & 63);
  if (offset > 0) {
    for (std::int64_t w = 0; w + whole < words; ++w) {
      std::uint64_t from = row[w + whole] >> part;
      if (part != 0 && w + whole + 1 < words) from |= row[w + whole + 1] << (64 - part);
      row[w] |= from;
    }
  } else {
    for (std::int64_t w = words - 1; w - whole >= 0; --w) {
      std::uint64_t from = row[w - whole] << part;
      if (part != 0 && w - whole - 1 >= 0) from |= row[w - whole - 1] >> (64 - part);
      row[w] |= from;
    }
  }
}

/// target[s] |= target[s + offset] for a stack of `count` rows, `stride` words apart, in place.
void unite_stack(std::uint64_t* first, std::int64_t count, std::int64_t stride, std::int64_t words, std::int64_t offset) {
  const std::int64_t reach = std::abs(offset);
  for (std::int64_t n = 0; n + reach < count; ++n) {
    const std::int64_t s = offset > 0 ? n : count - 1 - n;
    std::uint64_t* to = first + s * stride;
    const std::uint64_t* from = first + (s + offset) * stride;
    for (std::int64_t w = 0; w < words; ++w) to[w] |= from[w];
  }
}

}  // namespace

BitGrid::BitGrid(const Dims& dims) : dims_(dims), words_((dims[0] + 63) / 64) {
  (void)checked_count(dims);
  bits_.assign(static_cast<std::size_t>(words_ * dims[1] * dims[2]), 0);
}

BitGrid& BitGrid::operator|=(const BitGrid& other) {
  for (std::size_t w = 0; w < bits_.size(); ++w) bits_[w] |= other.bits_[w];
  return *this;
}

void BitGrid::unite_with_shift(int axis, std::int64_t offset) {
  const std::int64_t plane = words_ * dims_[1];
  if (axis == 2) {
    parallel_for(0, dims_[1], 16, [&](std::int64_t begin, std::int64_t end) {
      unite_stack(bits_.data() + begin * words_, dims_[2], plane, (end - begin) * words_, offset);
    });
    return;
  }
  const int tail = static_cast<int>(dims_[0] & 63);
  const std::uint64_t last_mask = tail == 0 ? ~std::uint64_t{0} : (std::uint64_t{1} << tail) - 1;
  parallel_for(0, dims_[2], 8, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      if (axis == 1) {
        unite_stack(bits_.data() + k * plane, dims_[1], words_, words_, offset);
        continue;
      }
      for (std::int64_t j = 0; j < dims_[1]; ++j) {
        unite_row(row(j, k), words_, offset);
        row(j, k)[words_ - 1] &= last_mask;
      }
    }
  });
}

void BitGrid::dilate(int axis, std::int64_t before, std::int64_t after) {
  const auto a = static_cast<std::size_t>(axis);
  for (const std::int64_t sign : {1, -1}) {
    std::int64_t missing = std::min(sign > 0 ? after : before, dims_[a] - 1);
    // Having united i .. i + reach, a shift by at most reach + 1 unites i .. i + reach + shift.
    for (std::int64_t reach = 0; missing > 0;) {
      const std::int64_t shift = std::min(reach + 1, missing);
      unite_with_shift(axis, sign * shift);
      reach += shift;
      missing -= shift;
    }
  }
}

}  // namespace vol::index
