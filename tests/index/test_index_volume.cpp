#include <gtest/gtest.h>

#include "base/error.h"
#include "base/rng.h"
#include "index/index_volume.h"

namespace vol::index {
namespace {

TEST(IndexVolume, EntriesAreIndependentAndTakeHalfAByte) {
  IndexVolume index({7, 5, 3}, 1, 0.5);
  EXPECT_EQ(index.nibbles().size(), 4u * 5u * 3u);
  Rng rng(4);
  std::vector<int> expected;
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 5; ++j) {
      for (int i = 0; i < 7; ++i) {
        expected.push_back(static_cast<int>(rng.below(16)));
        index.set_entry(i, j, k, 15 - expected.back());
        index.set_entry(i, j, k, expected.back());
      }
    }
  }
  for (std::size_t n = 0; n < expected.size(); ++n) {
    const auto m = static_cast<std::int64_t>(n);
    EXPECT_EQ(index.entry(m % 7, m / 7 % 5, m / 35), expected[n]);
  }
}

TEST(IndexVolume, ReductionRoundsUp) {
  EXPECT_EQ(IndexVolume({9, 8, 1}, 4, 1).dims(), (Dims{3, 2, 1}));
  EXPECT_THROW(IndexVolume({9, 8, 1}, 0, 1), Error);
  EXPECT_THROW(IndexVolume({9, 8, 1}, 1, 0), Error);
}

}  // namespace
}  // namespace vol::index
