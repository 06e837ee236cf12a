#include "features/codebook.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "features/clusters.h"

namespace vol::features {

void Codebook::validate() const {
  const auto features_count = static_cast<Eigen::Index>(names.size());
  const bool sizes = mean.size() == features_count && projection.cols() == features_count &&
                     units.rows() > 0 && units.cols() == projection.rows() &&
                     std::ssize(labels) == units.rows();
  if (!sizes)
    throw Error("codebook: the numbers of features, components, units and labels do not belong together");
  if (!mean.allFinite() || !projection.allFinite() || !units.allFinite())
    throw Error("codebook: a number is not finite");
  for (const int label : labels) {
    if (label < 0 || label >= kMostLabels)
      throw Error("codebook: label " + std::to_string(label) + " is outside 0 to 255");
  }
}

Samples drawn_samples(const FeatureField& field, std::int64_t most, std::uint64_t seed) {
  const Dims& n = field.geometry().dims;
  const std::int64_t voxels = field.geometry().count();
  if (most < 8) throw Error("samples: at least 8 are expected");
  std::vector<std::array<std::int64_t, 3>> places;
  if (voxels <= most) {
    for (std::int64_t v = 0; v < voxels; ++v) places.push_back({v % n[0], v / n[0] % n[1], v / n[0] / n[1]});
  } else {
    Rng rng(seed);
    for (std::int64_t drawn = 0; drawn < most / 8; ++drawn) {
      std::array<std::int64_t, 3> at;
      for (std::size_t a = 0; a < 3; ++a)
        at[a] = static_cast<std::int64_t>(rng.below(static_cast<std::uint64_t>((n[a] + 1) / 2)));
      for (int corner = 0; corner < 8; ++corner) {
        auto p = at;
        for (std::size_t a = 0; a < 3; ++a) p[a] = corner >> a & 1 ? n[a] - 1 - at[a] : at[a];
        places.push_back(p);
      }
    }
  }
  Samples samples(std::ssize(places), field.size());
  parallel_for(0, std::ssize(places), 1024, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> values(static_cast<std::size_t>(field.size()));
    for (std::int64_t s = begin; s < end; ++s) {
      const auto& p = places[static_cast<std::size_t>(s)];
      field.at(p[0], p[1], p[2], values);
      for (Eigen::Index f = 0; f < samples.cols(); ++f)
        samples(s, f) = static_cast<double>(values[static_cast<std::size_t>(f)]);
    }
  });
  return samples;
}

Training train(const FeatureField& field, const TrainingOptions& options) {
  if (options.labels < 1 || options.labels > kMostLabels) throw Error("labels: 1 to 256 are expected");
  Samples samples = drawn_samples(field, options.samples, options.seed);
  const PrincipalComponents pca = principal_components(samples, options.pca);
  const Samples points = (samples.rowwise() - pca.mean.transpose()) * pca.projection.transpose();
  Training t;
  t.samples = samples.rows();
  samples.resize(0, 0);
  t.shares = pca.variances / std::max(pca.variances.sum(), std::numeric_limits<double>::min());
  t.variance_share = pca.share();
  Codebook& book = t.codebook;
  std::vector<int> labels;
  if (options.method == Method::k_means) {
    KMeans clusters = k_means(points, options.labels, options.seed);
    book.units = std::move(clusters.centres);
    t.hits = std::move(clusters.hits);
    t.quantisation_error = clusters.quantisation_error;
  } else {
    SelfOrganisingMap map = train_map(points, options.map);
    book.units = std::move(map.units);
    t.hits = std::move(map.hits);
    t.quantisation_error = map.quantisation_error;
    t.topographic_error = map.topographic_error;
  }
  const double spread = points.norm() / std::sqrt(static_cast<double>(points.rows()));
  if (spread > 0) t.quantisation_error /= spread;
  book.labels = merged(book.units, t.hits, options.labels);
  std::vector<bool> met(kMostLabels, false);
  for (std::size_t u = 0; u < t.hits.size(); ++u) {
    if (t.hits[u] > 0) met[static_cast<std::size_t>(book.labels[u])] = true;
  }
  t.labels_found = static_cast<int>(std::count(met.begin(), met.end(), true));
  // From relative values to the volume's own.
  book.names = field.names();
  book.mean = pca.mean * field.unit();
  for (int f = 0; f < field.size(); ++f) book.mean[f] += field.offset(f);
  book.projection = pca.projection / field.unit();
  return t;
}

namespace {

/// Relative features are some ones at most, and squares of sums of 1024 of them are added: below this no
/// float overflows.
float as_float(double x) {
  if (!(std::abs(x) <= 1e15))
    throw Error("the codebook is for a volume of much smaller values than this one");
  return static_cast<float>(x);
}

}  // namespace

volume::Volume label_volume(const FeatureField& field, const Codebook& book) {
  book.validate();
  if (book.names != field.names()) {
    throw Error("the codebook is for other features: " + std::to_string(book.names.size()) + " from " +
                (book.names.empty() ? "" : book.names.front()) + ", not " + std::to_string(field.size()) +
                " from " + field.names().front());
  }
  const Dims& dims = field.geometry().dims;
  const std::int64_t nx = dims[0], ny = dims[1], nz = dims[2];
  const auto features = static_cast<std::size_t>(field.size());
  const auto components = static_cast<std::size_t>(book.projection.rows());
  // Relative to the field's unit and offset: y = sum_f p_f at_f - shift.
  std::vector<float> weights(components * features), shift(components);
  for (std::size_t c = 0; c < components; ++c) {
    double sum = 0;
    for (std::size_t f = 0; f < features; ++f) {
      const auto row = static_cast<Eigen::Index>(c), column = static_cast<Eigen::Index>(f);
      weights[c * features + f] = as_float(book.projection(row, column) * field.unit());
      sum += book.projection(row, column) * (book.mean[column] - field.offset(static_cast<int>(f)));
    }
    shift[c] = as_float(sum);
  }
  const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> units =
      book.units.unaryExpr(&as_float);
  volume::Volume result = volume::allocate(volume::VoxelType::u8, field.geometry());
  auto& labels = std::get<volume::Grid<std::uint8_t>>(result.grid).voxels;
  parallel_for(0, ny * nz, 8, [&](std::int64_t begin, std::int64_t end) {
    const auto n = static_cast<std::size_t>(nx);
    std::vector<float> values(features * n), points(components * n), least(n), distance(n);
    std::vector<std::uint8_t> best(n);
    for (std::int64_t row = begin; row < end; ++row) {
      field.row(row % ny, row / ny, values);
      for (std::size_t c = 0; c < components; ++c) {
        float* const y = points.data() + c * n;
        std::fill_n(y, n, -shift[c]);
        for (std::size_t f = 0; f < features; ++f) {
          const float w = weights[c * features + f];
          const float* const x = values.data() + f * n;
          for (std::size_t i = 0; i < n; ++i) y[i] += w * x[i];
        }
      }
      std::fill(least.begin(), least.end(), std::numeric_limits<float>::infinity());
      std::fill(best.begin(), best.end(), static_cast<std::uint8_t>(book.labels.front()));
      for (Eigen::Index u = 0; u < units.rows(); ++u) {
        std::fill(distance.begin(), distance.end(), 0.0F);
        for (std::size_t c = 0; c < components; ++c) {
          const float centre = units(u, static_cast<Eigen::Index>(c));
          const float* const y = points.data() + c * n;
          for (std::size_t i = 0; i < n; ++i) distance[i] += (y[i] - centre) * (y[i] - centre);
        }
        const auto label = static_cast<std::uint8_t>(book.labels[static_cast<std::size_t>(u)]);
        for (std::size_t i = 0; i < n; ++i) {
          const bool nearer = distance[i] < least[i];
          best[i] = nearer ? label : best[i];
          least[i] = nearer ? distance[i] : least[i];
        }
      }
      std::copy(best.begin(), best.end(), labels.begin() + row * nx);
    }
  });
  return result;
}

}  // namespace vol::features
