#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "features/clusters.h"
#include "features/self_organising_map.h"

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

/// As the declaration says it: all pairs anew for every union.
std::vector<int> merged_plainly(const Samples& points, const std::vector<std::int64_t>& weights, int labels) {
  std::vector<int> cluster(weights.size());
  Samples means = points;
  std::vector<double> weight(weights.begin(), weights.end());
  std::vector<int> alive;
  for (int i = 0; i < std::ssize(weights); ++i) alive.push_back(cluster[static_cast<std::size_t>(i)] = i);
  while (std::ssize(alive) > labels) {
    double least = INFINITY, nearest = INFINITY;
    int a = 0, b = 0;
    for (const int x : alive) {
      for (const int y : alive) {
        if (y <= x) continue;
        const double distance = (means.row(x) - means.row(y)).squaredNorm();
        const double wx = weight[static_cast<std::size_t>(x)], wy = weight[static_cast<std::size_t>(y)];
        const double cost = wx + wy > 0 ? wx * wy / (wx + wy) * distance : 0;
        if (cost < least || (cost == least && distance < nearest)) {
          least = cost, nearest = distance, a = x, b = y;
        }
      }
    }
    double &wa = weight[static_cast<std::size_t>(a)], wb = weight[static_cast<std::size_t>(b)];
    if (wa + wb > 0) means.row(a) = (wa * means.row(a) + wb * means.row(b)) / (wa + wb);
    wa += wb;
    std::replace(cluster.begin(), cluster.end(), b, a);
    std::erase(alive, b);
  }
  return cluster;
}

// Points of a coarse lattice: many are alike, and many unions cost the same.
TEST(Merged, IsTheSearchOfAllPairs) {
  Rng rng(11);
  for (int trial = 0; trial < 60; ++trial) {
    const auto n = static_cast<std::size_t>(2 + 38 * rng.uniform());
    Samples x(static_cast<Eigen::Index>(n), 2);
    std::vector<std::int64_t> weights;
    for (std::size_t i = 0; i < n; ++i) {
      x.row(static_cast<Eigen::Index>(i)) << std::floor(5 * rng.uniform()), std::floor(4 * rng.uniform());
      weights.push_back(static_cast<std::int64_t>(3 * rng.uniform()));
    }
    for (const int labels : {1, 2, 5, 20}) {
      const auto plain = merged_plainly(x, weights, labels), found = merged(x, weights, labels);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < i; ++j) {
          ASSERT_EQ(found[i] == found[j], plain[i] == plain[j])
              << trial << " " << labels << " " << i << " " << j;
        }
      }
    }
  }
}

// 4096 units, as the largest map has: searching all pairs for every union takes a thousand times as long.
TEST(Merged, TheLargestMap) {
  Rng rng(12);
  Samples x(kMostUnits, 3);
  for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = rng.uniform();
  const auto found = merged(x, std::vector<std::int64_t>(kMostUnits, 1), 7);
  EXPECT_EQ(*std::max_element(found.begin(), found.end()), 6);
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
