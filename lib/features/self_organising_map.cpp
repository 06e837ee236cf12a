#include "features/self_organising_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::features {
namespace {

constexpr std::int64_t kGrain = 1024;

struct Sums {
  Samples vectors;  // of the samples of each unit
  Eigen::VectorXd count;
};

Sums sums_by_unit(const Samples& samples, const Samples& units) {
  return parallel_reduce<Sums>(
      0, samples.rows(), kGrain,
      [&](std::int64_t begin, std::int64_t end) {
        Sums s{Samples::Zero(units.rows(), units.cols()), Eigen::VectorXd::Zero(units.rows())};
        for (std::int64_t i = begin; i < end; ++i) {
          const auto u = nearest(units, samples.row(i));
          s.vectors.row(u) += samples.row(i);
          s.count[u] += 1;
        }
        return s;
      },
      [](Sums& total, const Sums& part) {
        if (total.count.size() == 0) {
          total = part;
          return;
        }
        total.vectors += part.vectors;
        total.count += part.count;
      });
}

Samples first_units(const Samples& samples, const SelfOrganisingMap& map) {
  const auto [columns, rows, grid, epochs, radius] = map.options;
  const Eigen::RowVectorXd mean = samples.colwise().mean();
  Samples units = mean.replicate(columns * rows, 1);
  const auto spread = [&](Eigen::Index component, int at, int n) {
    if (component >= samples.cols() || n < 2) return 0.0;
    const double deviation = std::sqrt((samples.col(component).array() - mean[component]).square().mean());
    return 2 * deviation * (2.0 * at / (n - 1) - 1);
  };
  // The longer side goes along the larger variance.
  const int along = columns >= rows ? 0 : 1;
  for (int u = 0; u < columns * rows; ++u) {
    if (samples.cols() > along) units(u, along) += spread(along, u % columns, columns);
    if (samples.cols() > 1 - along) units(u, 1 - along) += spread(1 - along, u / columns, rows);
  }
  return units;
}

void measure(SelfOrganisingMap& map, const Samples& samples) {
  struct Errors {
    std::vector<std::int64_t> hits;
    double squares = 0;
    std::int64_t torn = 0;
  };
  const auto errors = parallel_reduce<Errors>(
      0, samples.rows(), kGrain,
      [&](std::int64_t begin, std::int64_t end) {
        Errors e{std::vector<std::int64_t>(static_cast<std::size_t>(map.units.rows())), 0, 0};
        for (std::int64_t i = begin; i < end; ++i) {
          Eigen::Index first = 0, second = -1;
          Eigen::VectorXd d = (map.units.rowwise() - samples.row(i)).rowwise().squaredNorm();
          e.squares += d.minCoeff(&first);
          ++e.hits[static_cast<std::size_t>(first)];
          if (d.size() < 2) continue;
          d[first] = std::numeric_limits<double>::infinity();
          (void)d.minCoeff(&second);
          e.torn += !map.are_neighbours(static_cast<int>(first), static_cast<int>(second));
        }
        return e;
      },
      [](Errors& total, const Errors& part) {
        total.hits.resize(part.hits.size());
        for (std::size_t u = 0; u < part.hits.size(); ++u) total.hits[u] += part.hits[u];
        total.squares += part.squares;
        total.torn += part.torn;
      });
  const auto n = static_cast<double>(samples.rows());
  map.hits = errors.hits;
  map.quantisation_error = std::sqrt(errors.squares / n);
  map.topographic_error = static_cast<double>(errors.torn) / n;
}

}  // namespace

Eigen::Index nearest(const Samples& centres, const Eigen::Ref<const Eigen::RowVectorXd>& vector) {
  Eigen::Index best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index u = 0; u < centres.rows(); ++u) {
    double distance = 0;
    for (Eigen::Index c = 0; c < centres.cols(); ++c) {
      const double x = centres(u, c) - vector[c];
      distance += x * x;
    }
    if (distance < least) {
      least = distance;
      best = u;
    }
  }
  return best;
}

double SelfOrganisingMap::grid_distance(int a, int b) const {
  const auto place = [&](int u) {
    const int row = u / options.columns;
    double x = u % options.columns, y = row;
    if (options.grid == MapGrid::hexagonal) {
      x += row % 2 == 1 ? 0.5 : 0;
      y *= std::sqrt(0.75);
    }
    return std::pair{x, y};
  };
  const auto [ax, ay] = place(a);
  const auto [bx, by] = place(b);
  return std::hypot(ax - bx, ay - by);
}

bool SelfOrganisingMap::are_neighbours(int a, int b) const {
  // sqrt 2 across the corner of a rectangle; 1 to all six of a hexagon, sqrt 3 to the next.
  return grid_distance(a, b) < 1.5;
}

SelfOrganisingMap train_map(const Samples& samples, const MapOptions& options) {
  if (options.columns < 1 || options.rows < 1 || options.columns > kMostUnits / options.rows) {
    throw Error("self-organising map: 1 to " + std::to_string(kMostUnits) + " units are expected, not " +
                std::to_string(options.columns) + "x" + std::to_string(options.rows));
  }
  if (samples.rows() < 1) throw Error("self-organising map: there are no samples");
  if (options.epochs < 1 || !(options.last_radius > 0))
    throw Error("self-organising map: at least one epoch and a positive radius are expected");
  SelfOrganisingMap map{.options = options, .units = {}, .hits = {}};
  map.units = first_units(samples, map);
  const int units = options.columns * options.rows;
  const double first_radius = std::max({0.5 * std::max(options.columns, options.rows), options.last_radius});
  Eigen::MatrixXd neighbourhood(units, units);
  for (int epoch = 0; epoch < options.epochs; ++epoch) {
    const double t = options.epochs > 1 ? double(epoch) / (options.epochs - 1) : 1;
    const double radius = first_radius * std::pow(options.last_radius / first_radius, t);
    for (int a = 0; a < units; ++a) {
      for (int b = 0; b < units; ++b) {
        const double g = map.grid_distance(a, b) / radius;
        neighbourhood(a, b) = std::exp(-0.5 * g * g);
      }
    }
    const Sums sums = sums_by_unit(samples, map.units);
    const Eigen::VectorXd weights = neighbourhood * sums.count;
    const Samples moved = neighbourhood * sums.vectors;
    for (int u = 0; u < units; ++u) {
      // A unit so far from all samples that its weight underflows stays where it is.
      if (weights[u] > 0) map.units.row(u) = moved.row(u) / weights[u];
    }
  }
  measure(map, samples);
  return map;
}

}  // namespace vol::features
