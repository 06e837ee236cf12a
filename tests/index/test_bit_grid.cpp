#include <gtest/gtest.h>

#include "base/rng.h"
#include "index/bit_grid.h"

namespace vol::index {
namespace {

BitGrid random_set(const Dims& dims, double density, std::uint64_t seed) {
  BitGrid set(dims);
  Rng rng(seed);
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        if (rng.uniform() < density) set.set(i, j, k);
      }
    }
  }
  return set;
}

// The definition of dilate(), point by point.
bool dilated_at(const BitGrid& set, int axis, std::int64_t before, std::int64_t after, std::array<std::int64_t, 3> p) {
  const auto a = static_cast<std::size_t>(axis);
  const std::int64_t centre = p[a];
  for (p[a] = std::max<std::int64_t>(0, centre - before); p[a] <= std::min(centre + after, set.dims()[a] - 1); ++p[a]) {
    if (set.test(p[0], p[1], p[2])) return true;
  }
  return false;
}

TEST(BitGrid, DilationIsTheUnionOverItsWindow) {
  Rng rng(9);
  for (int trial = 0; trial < 40; ++trial) {
    const Dims dims = {1 + static_cast<std::int64_t>(rng.below(150)), 1 + static_cast<std::int64_t>(rng.below(20)),
                       1 + static_cast<std::int64_t>(rng.below(20))};
    const auto set = random_set(dims, 0.02, rng.next());
    const int axis = trial % 3;
    const auto before = static_cast<std::int64_t>(rng.below(80)), after = static_cast<std::int64_t>(rng.below(80));
    auto dilated = set;
    dilated.dilate(axis, before, after);
    for (std::int64_t k = 0; k < dims[2]; ++k) {
      for (std::int64_t j = 0; j < dims[1]; ++j) {
        for (std::int64_t i = 0; i < dims[0]; ++i) {
          ASSERT_EQ(dilated.test(i, j, k), dilated_at(set, axis, before, after, {i, j, k}))
              << "dims " << dims[0] << " " << dims[1] << " " << dims[2] << " axis " << axis << " window -" << before
              << " +" << after << " at " << i << " " << j << " " << k;
        }
      }
    }
  }
}

}  // namespace
}  // namespace vol::index
