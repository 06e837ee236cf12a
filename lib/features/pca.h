#pragma once
#include <Eigen/Dense>

namespace vol::features {

/// Rows are vectors, columns what they hold.
using Samples = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// How vectors x become coordinates that are not correlated: y = projection (x - mean).
///
/// projection = V^T S^-1, where S holds the columns' standard deviations and V the leading eigenvectors of
/// the correlation matrix, the largest variance first (not standardised: S = I and the covariance matrix); so
/// a coordinate's variance over the samples is its eigenvalue. The sign is such that an eigenvector's entry
/// of largest magnitude is positive. Columns without variance take no part.
struct PrincipalComponents {
  Eigen::VectorXd mean;        ///< of each column
  Eigen::VectorXd deviation;   ///< standard deviation of each; 0: takes no part
  Eigen::MatrixXd projection;  ///< components x columns
  Eigen::VectorXd variances;   ///< of all components, the eigenvalues, descending
  [[nodiscard]] Eigen::Index components() const { return projection.rows(); }
  /// Share of the variance that the components hold; 1 where there is none.
  [[nodiscard]] double share() const;
};

struct PcaOptions {
  int components = 0;       ///< how many; 0: as many as hold the share
  double share = 0.95;      ///< in (0, 1]
  bool standardise = true;  ///< every column scaled to variance 1 first; false: variances as they are
  bool whiten = false;      ///< every coordinate scaled to variance 1
  /// Columns whose deviation is below this much of the column's largest magnitude are rounding.
  double negligible = 1e-6;
};

/// The matrix is summed in double in a fixed order. Fewer components come back where fewer have
/// variance. Throws vol::Error without samples or with options outside their ranges.
[[nodiscard]] PrincipalComponents principal_components(const Samples& samples, const PcaOptions& options);

}  // namespace vol::features
