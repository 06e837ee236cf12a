#include "fit/cost_functions.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vol::fit {

CurveCost::CurveCost(const Samples& samples, std::span<const double> target, const FitOptions& o,
                     Unknowns unknowns, std::size_t first, std::size_t count, bool weighted)
    : samples_(samples),
      target_(target),
      unknowns_(unknowns),
      points_(static_cast<std::size_t>(o.points)),
      first_(first),
      count_(count),
      emission_(o.quantity == Quantity::emission),
      weighted_(weighted) {
  set_num_residuals(static_cast<int>(count));
  mutable_parameter_block_sizes()->push_back(o.points);
  if (unknowns == Unknowns::range) mutable_parameter_block_sizes()->push_back(2);
  if (unknowns == Unknowns::abscissae) mutable_parameter_block_sizes()->push_back(o.points - 1);
}

bool CurveCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const std::size_t rest = unknowns_ == Unknowns::range ? 2 : points_ - 1;
  for (std::size_t k = 0; k < count_; ++k) {
    const std::size_t j = first_ + k;
    const double factor = weighted_ ? std::sqrt(samples_.weight[j]) : 1;
    Row row{};
    if (jacobians && jacobians[0]) row.points = jacobians[0] + k * points_;
    if (jacobians && unknowns_ != Unknowns::points && jacobians[1]) row.rest = jacobians[1] + k * rest;
    if (unknowns_ == Unknowns::abscissae) {
      abscissae_row(j, parameters, factor, row);
    } else {
      range_row(j, parameters, factor, row);
    }
    residuals[k] = row.residual;
  }
  return true;
}

void CurveCost::range_row(std::size_t j, double const* const* parameters, double factor, Row& row) const {
  const double u = samples_.v[j];
  double v = u, s = 1;
  if (unknowns_ == Unknowns::range) {
    s = parameters[1][1];
    v = (u - parameters[1][0]) / s;
  }
  const bool inside = v > 0 && v < 1;
  v = std::clamp(v, 0.0, 1.0);
  const auto b = transfer::de_casteljau({parameters[0], points_}, v);
  const double q = emission_ ? v : 1;
  row.residual = factor * (q * b.value - target_[j]);
  if (row.points) {
    const std::span<double> basis{row.points, points_};
    transfer::bernstein_basis(v, basis);
    for (double& derivative : basis) derivative *= factor * q;
  }
  if (row.rest) {
    // d(q B)/dv, and dv/da = -1/s, dv/ds = -v/s; beyond the range nothing changes with it.
    const double slope = inside ? factor * (q * b.slope + (emission_ ? b.value : 0)) : 0;
    row.rest[0] = -slope / s;
    row.rest[1] = -slope * v / s;
  }
}

void CurveCost::abscissae_row(std::size_t j, double const* const* parameters, double factor, Row& row) const {
  const double u = samples_.v[j];
  const Eigen::Map<const Eigen::VectorXd> increments(parameters[1], static_cast<Eigen::Index>(points_ - 1));
  const transfer::BezierCurve curve({parameters[0], parameters[0] + points_}, abscissae_of(increments));
  const double t = curve.parameter(u);
  const auto x = transfer::de_casteljau(curve.abscissae(), t),
             y = transfer::de_casteljau(curve.ordinates(), t);
  const double q = factor * (emission_ ? u : 1);
  row.residual = q * y.value - factor * target_[j];
  std::array<double, transfer::kMostControlPoints> basis;
  transfer::bernstein_basis(t, {basis.data(), points_});
  if (row.points) {
    for (std::size_t i = 0; i < points_; ++i) row.points[i] = q * basis[i];
  }
  if (row.rest) {
    // X(t) = u stays: dt/dx_i = -b_i/X', so dB/dx_i = -b_i Y'/X'; and dx_i/dd_k = ([k <= i] - x_i)/S.
    const double slope = -q * y.slope / x.slope, sum = increments.sum();
    double mean = 0, above = 0;
    for (std::size_t i = 1; i < points_; ++i) mean += basis[i] * curve.abscissae()[i];
    for (std::size_t k = points_ - 1; k >= 1; --k) {
      above += basis[k];
      row.rest[k - 1] = slope * (above - mean) / sum;
    }
  }
}

SmoothnessCost::SmoothnessCost(int points, double strength) : strength_(strength) {
  set_num_residuals(points - 2);
  mutable_parameter_block_sizes()->push_back(points);
}

bool SmoothnessCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const int n = parameter_block_sizes()[0];
  const double* p = parameters[0];
  for (int i = 0; i + 2 < n; ++i) residuals[i] = strength_ * (p[i] - 2 * p[i + 1] + p[i + 2]);
  if (!jacobians || !jacobians[0]) return true;
  std::fill(jacobians[0], jacobians[0] + (n - 2) * n, 0.0);
  for (int i = 0; i + 2 < n; ++i) {
    double* row = jacobians[0] + i * n + i;
    row[0] = row[2] = strength_;
    row[1] = -2 * strength_;
  }
  return true;
}

}  // namespace vol::fit
