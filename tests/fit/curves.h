#pragma once
#include <Eigen/Dense>
#include <cmath>

#include "base/rng.h"
#include "fit/bezier_fit.h"

// Shared by the tests of lib/fit: curves and problems drawn afresh, the matrix of the fit by another way.
namespace vol::fit_test {

inline std::vector<double> random_points(Rng& rng, int n, double lo = 0, double hi = 2) {
  std::vector<double> points;
  for (int i = 0; i < n; ++i) points.push_back(rng.uniform(lo, hi));
  return points;
}

inline std::vector<double> on_curve(const fit::Samples& samples, const std::vector<double>& points) {
  const transfer::BezierCurve curve(points);
  std::vector<double> target;
  for (const double v : samples.v) target.push_back(curve.value(v));
  return target;
}

/// C(n-1, i) (1-v)^(n-1-i) v^i as it is written, times sqrt(weight).
inline Eigen::MatrixXd written_out(const fit::Samples& samples, int n) {
  Eigen::MatrixXd a(samples.v.size(), n);
  for (std::size_t j = 0; j < samples.v.size(); ++j) {
    double binomial = 1;
    for (int i = 0; i < n; ++i) {
      a(static_cast<Eigen::Index>(j), i) = std::sqrt(samples.weight[j]) * binomial *
                                           std::pow(1 - samples.v[j], n - 1 - i) * std::pow(samples.v[j], i);
      binomial *= static_cast<double>(n - 1 - i) / (i + 1);
    }
  }
  return a;
}

inline Eigen::VectorXd weighted(const fit::Samples& samples, const std::vector<double>& target) {
  Eigen::VectorXd b(static_cast<Eigen::Index>(target.size()));
  for (std::size_t j = 0; j < target.size(); ++j) {
    b[static_cast<Eigen::Index>(j)] = std::sqrt(samples.weight[j]) * target[j];
  }
  return b;
}

/// A target that no polynomial is: two bands with steps, and a slope.
inline double stepped(double v) {
  return v < 0.3 ? 0.1 : v < 0.55 ? 1.7 : v < 0.6 ? 0.4 : 2.5 * (v - 0.6);
}

}  // namespace vol::fit_test
