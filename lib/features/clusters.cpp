#include "features/clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "features/self_organising_map.h"

namespace vol::features {
namespace {

constexpr std::int64_t kGrain = 1024;

/// Numbers clusters by descending weight.
std::vector<int> renumbered(const std::vector<int>& cluster, const std::vector<std::int64_t>& weights) {
  const auto n = cluster.size();
  std::vector<std::int64_t> total(n, 0);
  for (std::size_t i = 0; i < n; ++i) total[static_cast<std::size_t>(cluster[i])] += weights[i];
  std::vector<int> order;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::find(order.begin(), order.end(), cluster[i]) == order.end()) order.push_back(cluster[i]);
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return total[static_cast<std::size_t>(a)] > total[static_cast<std::size_t>(b)];
  });
  std::vector<int> result(n);
  for (std::size_t i = 0; i < n; ++i) {
    result[i] = static_cast<int>(std::find(order.begin(), order.end(), cluster[i]) - order.begin());
  }
  return result;
}

}  // namespace

namespace {

/// What joining two clusters costs.
struct Union {
  double cost = std::numeric_limits<double>::infinity(), distance = cost;
  int with = -1;  // the later of the two
  [[nodiscard]] bool cheaper_than(const Union& other) const {
    return cost < other.cost || (cost == other.cost && distance < other.distance);
  }
};

class Clusters {
 public:
  Clusters(const Samples& points, const std::vector<std::int64_t>& weights)
      : means_(points), weight_(points.rows()), alive_(weights.size()), best_(weights.size()) {
    for (std::size_t i = 0; i < weights.size(); ++i)
      weight_[static_cast<Eigen::Index>(i)] = static_cast<double>(weights[i]);
    std::iota(alive_.begin(), alive_.end(), 0);
    for (std::size_t x = 0; x < alive_.size(); ++x) search(x);
  }
  [[nodiscard]] std::size_t count() const { return alive_.size(); }

  /// Joins the two whose union is cheapest, and says which: the second becomes part of the first.
  std::pair<int, int> join() {
    int a = alive_.front();
    for (const int x : alive_) {
      if (best(x).cheaper_than(best(a))) a = x;
    }
    const int b = best(a).with;
    const double both = weight_[a] + weight_[b];
    if (both > 0) means_.row(a) = (weight_[a] * means_.row(a) + weight_[b] * means_.row(b)) / both;
    weight_[a] = both;
    std::erase(alive_, b);
    for (std::size_t x = 0; x < alive_.size(); ++x) {
      const int c = alive_[x];
      if (c == a || best(c).with == a || best(c).with == b) {
        search(x);
      } else if (c < a) {
        const Union with_a = of(c, a);
        const bool earlier = !best(c).cheaper_than(with_a) && a < best(c).with;
        if (earlier || with_a.cheaper_than(best(c))) best(c) = with_a;
      }
    }
    return {a, b};
  }

 private:
  [[nodiscard]] Union& best(int cluster) { return best_[static_cast<std::size_t>(cluster)]; }
  [[nodiscard]] Union of(int a, int b) const {
    const double distance = (means_.row(a) - means_.row(b)).squaredNorm(), both = weight_[a] + weight_[b];
    return {both > 0 ? weight_[a] * weight_[b] / both * distance : 0, distance, b};
  }
  /// The cheapest union of the x-th cluster that is left with a later one; of equal ones the first.
  void search(std::size_t x) {
    Union found;
    if (x + 1 < alive_.size()) found.with = alive_[x + 1];
    for (std::size_t y = x + 1; y < alive_.size(); ++y) {
      const Union with_y = of(alive_[x], alive_[y]);
      if (with_y.cheaper_than(found)) found = with_y;
    }
    best(alive_[x]) = found;
  }

  Samples means_;
  Eigen::VectorXd weight_;
  std::vector<int> alive_;  // ascending
  std::vector<Union> best_;
};

}  // namespace

std::vector<int> merged(const Samples& points, const std::vector<std::int64_t>& weights, int labels) {
  if (labels < 1) throw Error("labels: at least 1 is expected");
  std::vector<int> cluster(weights.size());
  std::iota(cluster.begin(), cluster.end(), 0);
  Clusters clusters(points, weights);
  while (std::cmp_greater(clusters.count(), labels)) {
    const auto [a, b] = clusters.join();
    std::replace(cluster.begin(), cluster.end(), b, a);
  }
  return renumbered(cluster, weights);
}

namespace {

struct Assignment {
  Samples sums;
  std::vector<std::int64_t> hits;
  double squares = 0;
  std::int64_t changed = 0;
};

Assignment assign(const Samples& samples, const Samples& centres, std::vector<int>& cluster) {
  return parallel_reduce<Assignment>(
      0, samples.rows(), kGrain,
      [&](std::int64_t begin, std::int64_t end) {
        Assignment a{Samples::Zero(centres.rows(), centres.cols()),
                     std::vector<std::int64_t>(static_cast<std::size_t>(centres.rows())), 0, 0};
        for (std::int64_t i = begin; i < end; ++i) {
          const auto c = nearest(centres, samples.row(i));
          a.sums.row(c) += samples.row(i);
          ++a.hits[static_cast<std::size_t>(c)];
          a.squares += (samples.row(i) - centres.row(c)).squaredNorm();
          int& before = cluster[static_cast<std::size_t>(i)];
          a.changed += before != static_cast<int>(c);
          before = static_cast<int>(c);
        }
        return a;
      },
      [](Assignment& total, const Assignment& part) {
        if (total.hits.empty()) {
          total = part;
          return;
        }
        total.sums += part.sums;
        for (std::size_t c = 0; c < part.hits.size(); ++c) total.hits[c] += part.hits[c];
        total.squares += part.squares;
        total.changed += part.changed;
      });
}

/// k-means++: each centre is a sample, drawn in proportion to its squared distance from those before it.
Samples first_centres(const Samples& samples, int clusters, Rng& rng) {
  const Eigen::Index n = samples.rows();
  Samples centres(clusters, samples.cols());
  Eigen::VectorXd distance = Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  auto at = static_cast<Eigen::Index>(rng.below(static_cast<std::uint64_t>(n)));
  int found = 0;
  while (found < clusters) {
    centres.row(found++) = samples.row(at);
    distance = distance.cwiseMin((samples.rowwise() - samples.row(at)).rowwise().squaredNorm());
    double left = rng.uniform() * distance.sum();
    if (!(distance.maxCoeff() > 0)) break;
    for (at = 0; at + 1 < n && (left -= distance[at]) >= 0; ++at) {
    }
    while (at > 0 && !(distance[at] > 0)) --at;  // rounding may run over the end
    if (!(distance[at] > 0)) (void)distance.maxCoeff(&at);
  }
  return centres.topRows(found);
}

}  // namespace

KMeans k_means(const Samples& samples, int clusters, std::uint64_t seed) {
  if (samples.rows() < 1) throw Error("k-means: there are no samples");
  if (clusters < 1) throw Error("k-means: at least 1 cluster is expected");
  constexpr int kStarts = 4, kRounds = 100;
  Rng rng(seed);
  KMeans best;
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start < kStarts; ++start) {
    Samples centres = first_centres(samples, clusters, rng);
    std::vector<int> cluster(static_cast<std::size_t>(samples.rows()), -1);
    Assignment a = assign(samples, centres, cluster);
    for (int round = 0; round < kRounds && a.changed > 0; ++round) {
      for (Eigen::Index c = 0; c < centres.rows(); ++c) {
        const auto hits = a.hits[static_cast<std::size_t>(c)];
        if (hits > 0) centres.row(c) = a.sums.row(c) / static_cast<double>(hits);
      }
      a = assign(samples, centres, cluster);
    }
    if (a.squares < least) {
      least = a.squares;
      best = {centres, a.hits, std::sqrt(a.squares / static_cast<double>(samples.rows()))};
    }
  }
  return best;
}

double adjusted_rand_index(const std::vector<std::vector<std::int64_t>>& counts) {
  const auto pairs = [](double n) { return n * (n - 1) / 2; };
  std::vector<double> columns;
  double all = 0, both = 0, first = 0, second = 0;
  for (const auto& row : counts) {
    columns.resize(std::max(columns.size(), row.size()));
    double sum = 0;
    for (std::size_t b = 0; b < row.size(); ++b) {
      const auto n = static_cast<double>(row[b]);
      sum += n;
      columns[b] += n;
      both += pairs(n);
    }
    first += pairs(sum);
    all += sum;
  }
  for (const double n : columns) second += pairs(n);
  if (!(all >= 2)) return 1;
  const double expected = first * (second / pairs(all)), most = (first + second) / 2;
  return most > expected ? (both - expected) / (most - expected) : 1;
}

}  // namespace vol::features
