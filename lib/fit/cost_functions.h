#pragma once
#include <ceres/cost_function.h>

#include <Eigen/Dense>

#include "fit/least_squares.h"

// Private to lib/fit and its tests: residuals with their derivatives in closed form, for Ceres.
namespace vol::fit {

/// What is unknown besides the control points.
enum class Unknowns { points, range, abscissae };

/// Residuals f_j (q B(v_j) - target_j) of the samples first .. first + count - 1, f_j = sqrt(weight_j) or 1.
/// Parameter blocks: the control points P; then
///   range      {a, s}: v = (u - a)/s clamped to [0, 1], u the sample's own v
///   abscissae  d_1 .. d_n-1 > 0: abscissae x_i = (d_1 + .. + d_i)/S, S the sum of all; B(u) = Y(t) where
///   X(t) = u
class CurveCost final : public ceres::CostFunction {
 public:
  CurveCost(const Samples& samples, std::span<const double> target, const FitOptions& o, Unknowns unknowns,
            std::size_t first, std::size_t count, bool weighted);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  struct Row {
    double residual;
    double* points;  ///< derivatives, or none wanted
    double* rest;
  };
  void range_row(std::size_t j, double const* const* parameters, double factor, Row& row) const;
  void abscissae_row(std::size_t j, double const* const* parameters, double factor, Row& row) const;

  const Samples& samples_;
  std::span<const double> target_;
  Unknowns unknowns_;
  std::size_t points_, first_, count_;
  bool emission_, weighted_;
};

/// Residuals strength (P_i - 2 P_i+1 + P_i+2).
class SmoothnessCost final : public ceres::CostFunction {
 public:
  SmoothnessCost(int points, double strength);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  double strength_;
};

}  // namespace vol::fit
