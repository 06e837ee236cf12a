#include "features/pca.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::features {
namespace {

constexpr std::int64_t kGrain = 1024;  // rows summed at a time: a fixed order

Eigen::VectorXd column_means(const Samples& samples) {
  using Vector = Eigen::VectorXd;
  const Vector sum = parallel_reduce<Vector>(
      0, samples.rows(), kGrain,
      [&](std::int64_t a, std::int64_t b) -> Vector {
        return samples.middleRows(a, b - a).colwise().sum().transpose();
      },
      [](Vector& total, const Vector& part) { total = total.size() == 0 ? part : Vector(total + part); });
  return sum / static_cast<double>(samples.rows());
}

Eigen::MatrixXd covariance(const Samples& samples, const Eigen::VectorXd& mean) {
  using Matrix = Eigen::MatrixXd;
  const Matrix sum = parallel_reduce<Matrix>(
      0, samples.rows(), kGrain,
      [&](std::int64_t a, std::int64_t b) -> Matrix {
        const Matrix centred = samples.middleRows(a, b - a).rowwise() - mean.transpose();
        return centred.transpose() * centred;
      },
      [](Matrix& total, const Matrix& part) { total = total.size() == 0 ? part : Matrix(total + part); });
  return sum / static_cast<double>(samples.rows());
}

}  // namespace

double PrincipalComponents::share() const {
  const double total = variances.sum();
  return total > 0 ? variances.head(components()).sum() / total : 1;
}

PrincipalComponents principal_components(const Samples& samples, const PcaOptions& options) {
  if (samples.rows() < 1 || samples.cols() < 1) throw Error("principal components: there are no samples");
  if (options.components < 0 || !(options.share > 0 && options.share <= 1)) {
    throw Error("principal components: a number of them, or a share of the variance in (0, 1], is expected");
  }
  PrincipalComponents pca;
  pca.mean = column_means(samples);
  const Eigen::MatrixXd matrix = covariance(samples, pca.mean);
  pca.deviation = matrix.diagonal().cwiseMax(0).cwiseSqrt();
  std::vector<Eigen::Index> used;
  for (Eigen::Index c = 0; c < samples.cols(); ++c) {
    if (pca.deviation[c] > options.negligible * samples.col(c).cwiseAbs().maxCoeff()) {
      used.push_back(c);
    } else {
      pca.deviation[c] = 0;
    }
  }
  const auto n = static_cast<Eigen::Index>(used.size());
  pca.projection = Eigen::MatrixXd::Zero(0, samples.cols());
  pca.variances = Eigen::VectorXd::Zero(n);
  if (n == 0) return pca;
  const auto scale = [&](Eigen::Index column) { return options.standardise ? pca.deviation[column] : 1; };
  Eigen::MatrixXd correlation(n, n);
  for (Eigen::Index r = 0; r < n; ++r) {
    for (Eigen::Index c = 0; c < n; ++c) {
      const auto a = used[static_cast<std::size_t>(r)], b = used[static_cast<std::size_t>(c)];
      correlation(r, c) = matrix(a, b) / (scale(a) * scale(b));
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation);
  if (solver.info() != Eigen::Success) throw Error("principal components: the eigenvalues did not converge");
  pca.variances = solver.eigenvalues().reverse().cwiseMax(0);
  const Eigen::MatrixXd vectors = solver.eigenvectors().rowwise().reverse();
  // Eigenvalues at rounding are none: they are off by some n ulp of the trace.
  Eigen::Index most = 0;
  while (most < n && pca.variances[most] > 1e-12 * pca.variances.sum()) ++most;
  Eigen::Index count = std::min<Eigen::Index>(options.components, most);
  if (options.components == 0) {
    double held = 0;
    while (count < most && held < (options.share - 1e-12) * pca.variances.sum())
      held += pca.variances[count++];
  }
  pca.projection = Eigen::MatrixXd::Zero(count, samples.cols());
  for (Eigen::Index r = 0; r < count; ++r) {
    Eigen::VectorXd v = vectors.col(r);
    Eigen::Index largest = 0;
    v.cwiseAbs().maxCoeff(&largest);
    if (v[largest] < 0) v = -v;
    if (options.whiten) v /= std::sqrt(pca.variances[r]);
    for (Eigen::Index c = 0; c < n; ++c) {
      const auto at = used[static_cast<std::size_t>(c)];
      pca.projection(r, at) = v[c] / scale(at);
    }
  }
  return pca;
}

}  // namespace vol::features
