#include <ceres/ceres.h>
#include <glog/logging.h>

#include "base/error.h"
#include "fit/cost_functions.h"

namespace vol::fit {
namespace {

/// Ceres reports by glog, several lines on standard error, what its summary says too; while this lives glog
/// is silent but for what ends the program.
class SilentGlog {
 public:
  SilentGlog() : before_(FLAGS_minloglevel) { FLAGS_minloglevel = google::GLOG_FATAL; }
  ~SilentGlog() { FLAGS_minloglevel = before_; }
  SilentGlog(const SilentGlog&) = delete;
  SilentGlog& operator=(const SilentGlog&) = delete;

 private:
  int before_;
};

/// One thread, so that sums have one order; until a step changes nothing more.
ceres::Solver::Summary solved(ceres::Problem& problem) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  const SilentGlog silent;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    throw Error(
        "the fit fails: target, bounds, scale of the loss and smoothness differ too much in size; bring them "
        "nearer to each other");
  }
  return summary;
}

void bound(ceres::Problem& problem, Eigen::VectorXd& block, double least, double most) {
  for (int i = 0; i < block.size(); ++i) {
    problem.SetParameterLowerBound(block.data(), i, least);
    problem.SetParameterUpperBound(block.data(), i, most);
  }
}

/// One residual block of all samples, or under a loss one for each.
void add_curve(ceres::Problem& problem, const Samples& samples, std::span<const double> target,
               const FitOptions& o, Unknowns unknowns, Eigen::VectorXd& points, Eigen::VectorXd& rest) {
  std::vector<double*> blocks{points.data()};
  if (unknowns != Unknowns::points) blocks.push_back(rest.data());
  const std::size_t all = samples.v.size();
  if (o.loss == Loss::none) {
    problem.AddResidualBlock(new CurveCost(samples, target, o, unknowns, 0, all, true), nullptr, blocks);
  } else {
    for (std::size_t j = 0; j < all; ++j) {
      ceres::LossFunction* loss = o.loss == Loss::huber
                                      ? static_cast<ceres::LossFunction*>(new ceres::HuberLoss(o.loss_scale))
                                      : new ceres::CauchyLoss(o.loss_scale);
      problem.AddResidualBlock(new CurveCost(samples, target, o, unknowns, j, 1, false),
                               new ceres::ScaledLoss(loss, samples.weight[j], ceres::TAKE_OWNERSHIP), blocks);
    }
  }
  if (o.smoothness > 0 && o.points > 2) {
    problem.AddResidualBlock(new SmoothnessCost(o.points, std::sqrt(o.smoothness)), nullptr, points.data());
  }
  if (o.bounds == Bounds::points) bound(problem, points, o.least, o.most);
}

}  // namespace

std::vector<double> abscissae_of(const Eigen::VectorXd& increments) {
  std::vector<double> x{0};
  const double sum = increments.sum();
  double part = 0;
  for (Eigen::Index k = 0; k + 1 < increments.size(); ++k) {
    part += increments[k];
    x.push_back(part / sum);
  }
  x.push_back(1);
  return x;
}

void improve(const Samples& samples, const std::vector<std::vector<double>>& targets, const FitOptions& o,
             Nonlinear& state) {
  const Unknowns unknowns = o.free_range   ? Unknowns::range
                            : o.parametric ? Unknowns::abscissae
                                           : Unknowns::points;
  ceres::Problem problem;
  for (std::size_t c = 0; c < targets.size(); ++c) {
    add_curve(problem, samples, targets[c], o, unknowns, state.points[c], state.rest);
  }
  if (o.free_range) {
    // v = 0 up to a range's length below the samples, v = 1 up to as much above; at least a fiftieth of them
    // within.
    problem.SetParameterLowerBound(state.rest.data(), 0, -1);
    problem.SetParameterUpperBound(state.rest.data(), 0, 0.98);
    problem.SetParameterLowerBound(state.rest.data(), 1, 0.02);
    problem.SetParameterUpperBound(state.rest.data(), 1, 3);
  }
  // Increments from a hundredth of an even one to a hundred of it: X' never vanishes, and their common
  // factor, which changes nothing, cannot run away.
  if (o.parametric) bound(problem, state.rest, 0.01, 100);
  const auto summary = solved(problem);
  state.cost = summary.final_cost;
  state.iterations += static_cast<int>(summary.iterations.size());
}

}  // namespace vol::fit
