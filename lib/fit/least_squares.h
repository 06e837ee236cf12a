#pragma once
#include <Eigen/Dense>
#include <span>

#include "fit/bezier_fit.h"

// Private to lib/fit: the linear problem, min ||A p - b||, one row a sample and one a second difference.
namespace vol::fit {

/// The triangle of A = Q R and what Q' makes of b: ||A p - b||^2 = ||R p - c||^2 + constant.
struct Triangle {
  Eigen::MatrixXd r;  ///< points x points
  Eigen::VectorXd c;
};

/// Row j is sqrt(weight_j) q_j b_i(t_j), b the Bernstein polynomials; then the second differences.
/// \param t  parameters of the samples: v itself, or of a curve with abscissae
[[nodiscard]] Eigen::MatrixXd design_matrix(const Samples& samples, std::span<const double> t,
                                            const FitOptions& o);
[[nodiscard]] Eigen::VectorXd right_hand_side(const Samples& samples, std::span<const double> target,
                                              const FitOptions& o);
[[nodiscard]] Triangle triangle(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

struct LinearSolution {
  Eigen::VectorXd points;
  int rank = 0;
  double condition = 0;  ///< largest over smallest singular value; infinite where that is 0
};
/// The shortest minimiser of ||R p - c||, by a complete orthogonal decomposition.
[[nodiscard]] LinearSolution solve(const Triangle& problem);

/// min ||R p - c|| with least <= p_i <= most, from a feasible start: the points at a bound are held, the
/// others solved by QR; a point is let go where the gradient pulls it inward, held where it would go out
/// (Stark & Parker 1995). \returns false where that does not end within 50 exchanges a point
[[nodiscard]] bool solve_bounded(const Triangle& problem, double least, double most, Eigen::VectorXd& points);

/// min ||R p - c|| with least <= B(t) <= most for t in [0, 1], kept to 1e-9 of most - least, or of the
/// largest p_i - least of the problem without bounds where that is less: a least distance problem (Lawson &
/// Hanson 1974, chapter 23) at places to which are added those where the curve leaves the bounds. R of full
/// rank.
[[nodiscard]] Eigen::VectorXd solve_curve_bounded(const Triangle& problem, double least, double most);

/// What nonlinear problems end with.
struct Nonlinear {
  std::vector<Eigen::VectorXd> points;  ///< one a curve
  Eigen::VectorXd rest;  ///< range {a, s} of v = (u - a)/s, or the increments of the abscissae, or nothing
  double cost = 0;
  int iterations = 0;
};
/// Ceres on the problem of fit_bezier() from a feasible start; `rest` says which unknowns there are besides.
void improve(const Samples& samples, const std::vector<std::vector<double>>& targets, const FitOptions& o,
             Nonlinear& state);
/// 0, d_1/S, (d_1 + d_2)/S .. 1, S the sum of the increments.
[[nodiscard]] std::vector<double> abscissae_of(const Eigen::VectorXd& increments);

}  // namespace vol::fit
