#pragma once
#include <cstdint>
#include <vector>

#include "features/pca.h"

namespace vol::features {

/// Merges points into at most `labels` clusters: from one each, always the two whose union adds least to the
/// sum of squared distances to the clusters' means, n_a n_b / (n_a + n_b) |m_a - m_b|^2 (Ward 1963); of equal
/// costs the nearest, then the first. A point of weight 0 costs nothing and goes to its nearest first.
/// Returns the cluster of every point, 0 the one of largest weight, then descending (ties: the earlier point
/// first).
[[nodiscard]] std::vector<int> merged(const Samples& points, const std::vector<std::int64_t>& weights,
                                      int labels);

/// Lloyd's k-means: centres drawn by k-means++ (Arthur & Vassilvitskii 2007), until no sample changes or 100
/// rounds are over, the best of four starts. Fewer centres come back where there are fewer distinct samples.
struct KMeans {
  Samples centres;
  std::vector<std::int64_t> hits;
  double quantisation_error = 0;  ///< root mean square distance of the samples to their centres
};
[[nodiscard]] KMeans k_means(const Samples& samples, int clusters, std::uint64_t seed);

/// Agreement of two labellings of the same things, adjusted for chance (Hubert & Arabie 1985): 1 where they
/// are the same but for the names, 0 on average for labels drawn at random. Two labellings that both know one
/// class only agree: 1. \param counts  counts[a][b]: things that the one calls a and the other b
[[nodiscard]] double adjusted_rand_index(const std::vector<std::vector<std::int64_t>>& counts);

}  // namespace vol::features
