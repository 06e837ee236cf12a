#include <limits>

#include "fit/least_squares.h"

namespace vol::fit {

Eigen::MatrixXd design_matrix(const Samples& samples, std::span<const double> t, const FitOptions& o) {
  const auto rows = static_cast<Eigen::Index>(t.size());
  const Eigen::Index n = o.points, differences = o.smoothness > 0 && n > 2 ? n - 2 : 0;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows + differences, n);
  std::vector<double> basis(static_cast<std::size_t>(n));
  for (Eigen::Index j = 0; j < rows; ++j) {
    const auto s = static_cast<std::size_t>(j);
    transfer::bernstein_basis(t[s], basis);
    const double factor =
        std::sqrt(samples.weight[s]) * (o.quantity == Quantity::emission ? samples.v[s] : 1);
    for (Eigen::Index i = 0; i < n; ++i) a(j, i) = factor * basis[static_cast<std::size_t>(i)];
  }
  const double strength = std::sqrt(o.smoothness);
  for (Eigen::Index i = 0; i < differences; ++i) {
    a(rows + i, i) = a(rows + i, i + 2) = strength;
    a(rows + i, i + 1) = -2 * strength;
  }
  return a;
}

Eigen::VectorXd right_hand_side(const Samples& samples, std::span<const double> target, const FitOptions& o) {
  const auto rows = static_cast<Eigen::Index>(target.size());
  const Eigen::Index differences = o.smoothness > 0 && o.points > 2 ? o.points - 2 : 0;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(rows + differences);
  for (Eigen::Index j = 0; j < rows; ++j) {
    const auto s = static_cast<std::size_t>(j);
    b[j] = std::sqrt(samples.weight[s]) * target[s];
  }
  return b;
}

Triangle triangle(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index n = a.cols(), rows = std::min(a.rows(), n);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  Triangle t{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  t.r.topRows(rows) = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
  const Eigen::VectorXd turned = qr.householderQ().adjoint() * b;
  t.c.head(rows) = turned.head(rows);
  return t;
}

LinearSolution solve(const Triangle& problem) {
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(problem.r);
  LinearSolution solution;
  solution.points = decomposition.solve(problem.c);
  solution.rank = static_cast<int>(decomposition.rank());
  const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXd>(problem.r).singularValues();
  const double smallest = singular[singular.size() - 1];
  solution.condition = smallest > 0 ? singular[0] / smallest : std::numeric_limits<double>::infinity();
  return solution;
}

}  // namespace vol::fit
