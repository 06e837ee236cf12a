#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/rng.h"
#include "features/pca.h"

namespace vol::features {
namespace {

/// Samples whose correlation matrix is known exactly: orthogonal, equally long columns of signs (a Hadamard
/// design), mixed by the root of the matrix. z^T z / 8 = I, so x = z R has the covariance R^T R.
Samples hadamard_mixed(const Eigen::MatrixXd& root, const Eigen::RowVectorXd& mean) {
  Samples z(8, 3);
  for (int i = 0; i < 8; ++i) {
    for (int c = 0; c < 3; ++c) z(i, c) = i >> c & 1 ? 1 : -1;
  }
  return (z * root).rowwise() + mean;
}

// The correlation matrix with off-diagonal entries a, a, a has the eigenvalues 1 + 2a along (1,1,1)/sqrt 3
// and 1 - a twice; entries 0.6 (x,y) and 0 else 1.6, 1, 0.4. Rounding alone: 1e-10 is some 1e5 ulp of an
// 8-row sum.
TEST(Pca, KnownCovarianceComesBack) {
  Eigen::Matrix3d correlation;
  correlation << 1, 0.6, 0, 0.6, 1, 0, 0, 0, 1;
  const Eigen::Vector3d deviation(3, 0.02, 700);
  const Eigen::Matrix3d covariance = deviation.asDiagonal() * correlation * deviation.asDiagonal();
  const Eigen::Matrix3d root = covariance.llt().matrixU();
  const Samples x = hadamard_mixed(root, Eigen::RowVector3d(5, -2, 1e4));
  const auto pca = principal_components(x, {.share = 1});
  ASSERT_EQ(pca.components(), 3);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(pca.deviation[c] / deviation[c], 1, 1e-10) << c;
  EXPECT_NEAR(pca.variances[0], 1.6, 1e-10);
  EXPECT_NEAR(pca.variances[1], 1.0, 1e-10);
  EXPECT_NEAR(pca.variances[2], 0.4, 1e-10);
  const double r = std::sqrt(0.5);
  const Eigen::MatrixXd vectors = pca.projection * deviation.asDiagonal();
  Eigen::Matrix3d expected;
  expected << r, r, 0, 0, 0, 1, r, -r, 0;
  for (int row = 0; row < 3; ++row) {
    // Of the last both entries are of the same magnitude: rounding chooses the sign.
    const double sign = vectors.row(row).dot(expected.row(row)) < 0 ? -1 : 1;
    EXPECT_LT((sign * vectors.row(row) - expected.row(row)).norm(), 1e-10) << row;
  }
}

TEST(Pca, CoordinatesAreUncorrelatedAndWhitened) {
  Rng rng(3);
  Samples x(5000, 5);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const double shared = rng.normal();
    for (int c = 0; c < 5; ++c) x(i, c) = (c + 1) * shared + (6 - c) * rng.normal() + 100 * c;
  }
  for (const bool whiten : {false, true}) {
    const auto pca = principal_components(x, {.share = 1, .whiten = whiten});
    const Eigen::MatrixXd y = (x.rowwise() - pca.mean.transpose()) * pca.projection.transpose();
    const Eigen::MatrixXd covariance = y.transpose() * y / 5000;
    const Eigen::VectorXd expected = whiten ? Eigen::VectorXd::Ones(5) : pca.variances;
    EXPECT_LT((covariance - Eigen::MatrixXd(expected.asDiagonal())).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_NEAR(pca.variances.sum(), 5, 1e-11);  // the trace of a correlation matrix
  }
}

// The same design without standardising: eigenvalues of the covariance matrix itself.
TEST(Pca, CovarianceAsItIs) {
  Eigen::Matrix3d covariance;
  covariance << 4, 1.2, 0, 1.2, 4, 0, 0, 0, 0.25;
  const Samples x = hadamard_mixed(Eigen::Matrix3d(covariance.llt().matrixU()), Eigen::RowVector3d(1, 2, 3));
  const auto pca = principal_components(x, {.share = 1, .standardise = false});
  ASSERT_EQ(pca.components(), 3);
  EXPECT_NEAR(pca.variances[0], 5.2, 1e-10);
  EXPECT_NEAR(pca.variances[1], 2.8, 1e-10);
  EXPECT_NEAR(pca.variances[2], 0.25, 1e-10);
  EXPECT_NEAR(pca.projection(0, 0), std::sqrt(0.5), 1e-10);
  EXPECT_NEAR(pca.projection(0, 1), std::sqrt(0.5), 1e-10);
  EXPECT_NEAR(pca.projection(2, 2), 1, 1e-10);
}

TEST(Pca, ShareChoosesTheComponents) {
  Eigen::Matrix3d correlation;
  correlation << 1, 0.6, 0, 0.6, 1, 0, 0, 0, 1;
  const Samples x = hadamard_mixed(Eigen::Matrix3d(correlation.llt().matrixU()), Eigen::RowVector3d::Zero());
  EXPECT_EQ(principal_components(x, {.share = 0.53}).components(), 1);  // 1.6 / 3 = 0.533
  EXPECT_EQ(principal_components(x, {.share = 0.54}).components(), 2);
  EXPECT_EQ(principal_components(x, {.share = 0.9}).components(), 3);  // 2.6 / 3 = 0.867
  EXPECT_EQ(principal_components(x, {.components = 2}).components(), 2);
  EXPECT_EQ(principal_components(x, {.components = 9}).components(), 3);
  EXPECT_NEAR(principal_components(x, {.components = 2}).share(), 2.6 / 3, 1e-12);
}

TEST(Pca, ColumnsWithoutVarianceTakeNoPart) {
  Samples x(4, 3);
  x << 1, 7, 2, 2, 7, 4, 3, 7, 6, 4, 7, 8;  // the second constant, the third twice the first
  const auto pca = principal_components(x, {.share = 1});
  EXPECT_EQ(pca.components(), 1);
  EXPECT_EQ(pca.deviation[1], 0);
  EXPECT_EQ(pca.projection(0, 1), 0);
  const auto none = principal_components(Samples::Constant(4, 3, 0.1), {});
  EXPECT_EQ(none.components(), 0);
  EXPECT_EQ(none.share(), 1);
  EXPECT_THROW((void)principal_components(Samples(0, 3), {}), Error);
  EXPECT_THROW((void)principal_components(x, {.share = 0}), Error);
  EXPECT_THROW((void)principal_components(x, {.components = -1}), Error);
}

}  // namespace
}  // namespace vol::features
