#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "features/clusters.h"

namespace vol::features {
namespace {

TEST(Merged, WardsOrderByHand) {
  // On a line 0, 1, 4, 6: costs of equal weights are half the squared distances; 0 and 1 join, then 4 and 6.
  Samples x(4, 1);
  x << 0, 1, 4, 6;
  EXPECT_EQ(merged(x, {1, 1, 1, 1}, 3), (std::vector<int>{0, 0, 1, 2}));
  EXPECT_EQ(merged(x, {1, 1, 1, 1}, 2), (std::vector<int>{0, 0, 1, 1}));
  EXPECT_EQ(merged(x, {1, 1, 1, 1}, 1), (std::vector<int>{0, 0, 0, 0}));
  // Weights: joining 0 (9) with 1 (9) costs 4.5, 4 (1) with 6 (1) costs 2. Label 0 is the heaviest.
  EXPECT_EQ(merged(x, {9, 8, 1, 1}, 3), (std::vector<int>{0, 1, 2, 2}));
  EXPECT_EQ(merged(x, {1, 1, 9, 8}, 3), (std::vector<int>{2, 2, 0, 1}));
  // A unit without samples goes with its nearest.
  EXPECT_EQ(merged(x, {5, 6, 0, 4}, 3), (std::vector<int>{1, 0, 2, 2}));
  EXPECT_EQ(merged(x, {1, 1, 1, 1}, 9).size(), 4U);
  EXPECT_THROW((void)merged(x, {1, 1, 1, 1}, 0), Error);
}

Samples blobs(int each, std::uint64_t seed) {
  Rng rng(seed);
  Samples x(3 * each, 2);
  for (int i = 0; i < 3 * each; ++i) {
    x.row(i) << 10 * (i % 3) + rng.normal(), (i % 3 == 1 ? 10 : 0) + rng.normal();
  }
  return x;
}

TEST(KMeans, FindsBlobsTenDeviationsApart) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto found = k_means(blobs(1000, seed), 3, seed);
    EXPECT_EQ(found.hits, (std::vector<std::int64_t>{1000, 1000, 1000}));
    EXPECT_NEAR(found.quantisation_error, std::sqrt(2.0), 0.06);  // two coordinates of variance 1
  }
}

TEST(KMeans, SameForAnyNumberOfThreads) {
  set_thread_count(1);
  const auto one = k_means(blobs(3000, 4), 7, 5);
  set_thread_count(3);
  const auto three = k_means(blobs(3000, 4), 7, 5);
  set_thread_count(0);
  EXPECT_TRUE(one.centres == three.centres);
  EXPECT_FALSE(one.centres == k_means(blobs(3000, 4), 7, 6).centres);
}

TEST(KMeans, FewerDistinctSamplesThanClusters) {
  Samples x(6, 1);
  x << 1, 1, 2, 2, 2, 1;
  const auto found = k_means(x, 5, 1);
  EXPECT_EQ(found.centres.rows(), 2);
  EXPECT_EQ(found.quantisation_error, 0);
  EXPECT_EQ(k_means(Samples::Constant(4, 3, 1.0), 2, 1).centres.rows(), 1);
  EXPECT_THROW((void)k_means(Samples(0, 2), 2, 1), Error);
}

TEST(AdjustedRandIndex, KnownValues) {
  EXPECT_EQ(adjusted_rand_index({{5, 0}, {0, 7}}), 1);
  EXPECT_EQ(adjusted_rand_index({{0, 5}, {7, 0}}), 1);  // names do not matter
  EXPECT_EQ(adjusted_rand_index({{12}}), 1);
  EXPECT_EQ(adjusted_rand_index({{6, 6}}), 0);  // one class says nothing about two
  // By hand: pairs alike in both 1 + 1 = 2; in rows 3 + 3, in columns 3 + 3, of 15 in all.
  EXPECT_NEAR(adjusted_rand_index({{2, 1}, {1, 2}}), (2 - 2.4) / (6 - 2.4), 1e-15);
}

}  // namespace
}  // namespace vol::features
