#include <gtest/gtest.h>

#include "base/error.h"
#include "base/rng.h"
#include "index/bit_grid.h"

namespace vol::index {
namespace {

TEST(BitGrid, HoldsWhatIsSet) {
  BitGrid grid({70, 3, 2});
  EXPECT_EQ(grid.words_per_row(), 2);
  grid.set(63, 0, 0), grid.set(64, 2, 1);
  int members = 0;
  for (std::int64_t k = 0; k < 2; ++k) {
    for (std::int64_t j = 0; j < 3; ++j) {
      for (std::int64_t i = 0; i < 70; ++i) members += grid.test(i, j, k);
    }
  }
  EXPECT_EQ(members, 2);
  EXPECT_TRUE(grid.test(63, 0, 0) && grid.test(64, 2, 1));
  EXPECT_THROW(BitGrid({1, 0, 1}), Error);
}

TEST(BitGrid, SetBitsSetsTheRangeAndNothingElse) {
  Rng rng(9);
  for (int trial = 0; trial < 200; ++trial) {
    const auto n = 1 + static_cast<std::int64_t>(rng.below(200));
    BitGrid set({n, 1, 1});
    const auto first = static_cast<std::int64_t>(rng.below(static_cast<std::uint64_t>(n)));
    const auto last = first + static_cast<std::int64_t>(rng.below(static_cast<std::uint64_t>(n - first)));
    const auto before = static_cast<std::int64_t>(rng.below(static_cast<std::uint64_t>(n)));
    set.set(before, 0, 0);
    set_bits(set.row(0, 0), first, last);
    for (std::int64_t i = 0; i < n; ++i) {
      ASSERT_EQ(set.test(i, 0, 0), (i >= first && i <= last) || i == before)
          << "bits " << first << " to " << last << " of " << n << " at " << i;
    }
  }
}

}  // namespace
}  // namespace vol::index
