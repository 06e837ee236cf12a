#include "fit/bezier_fit.h"

#include <sstream>

#include "base/rng.h"
#include "kernels.h"
#include "truth.h"

// Curves that a fit must find again: what is sampled has control points of its own.
namespace vol::stability {
namespace {

using namespace vol::fit;

void recovered(Table& table, const std::string& what, const std::vector<int>& counts, double scale,
               const volume::Range& range, Quantity quantity) {
  Worst points, residual;
  Rng rng(6);
  for (const int n : counts) {
    std::vector<double> control;
    double largest = 0;
    for (int i = 0; i < n; ++i) {
      control.push_back(scale * rng.uniform(0, 2));
      largest = std::max(largest, control.back());
    }
    const transfer::BezierCurve curve(control);
    const Samples samples = uniform_samples(range, 400);
    std::vector<double> target;
    for (const double v : samples.v)
      target.push_back(curve.value(v) * (quantity == Quantity::emission ? v : 1));
    FitOptions options;
    options.points = n;
    options.bounds = Bounds::none;
    options.quantity = quantity;
    const Fit fit = fit_bezier(samples, {target}, options);
    Real error = 0, size = 0;
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Real e = static_cast<Real>(fit.curves[0].ordinates()[at]) - static_cast<Real>(control[at]);
      error += e * e;
      size += static_cast<Real>(control[at]) * static_cast<Real>(control[at]);
    }
    // QR is backward stable (Higham 2002, theorem 20.3): as if matrix and target had been off by gamma_cmn;
    // the residual is 0, so that the condition number enters once. The target itself is rounded, too.
    const double backward = gamma(3.0 * n * std::sqrt(static_cast<double>(n)) + 3.0 * n + 40, kDouble);
    points.add(static_cast<double>(std::sqrt(error / size)), 4 * backward * fit.condition);
    residual.add(fit.residuals[0].rms / largest, 4 * backward * std::sqrt(static_cast<double>(n)));
  }
  table.row(what, "fit_bezier, points", "double", points,
            "QR is backward stable: 4 gamma_(3 n^1.5 + 3n + 40) times the condition");
  table.row(what, "fit_bezier, residual", "double", residual, "the same without the condition");
}

}  // namespace

void fit(Table& table) {
  const std::vector<int> all{1, 2, 6, 12, 16, 21};
  recovered(table, "1 to 21 points of 0 to 2", all, 1, {0, 1}, Quantity::weight);
  recovered(table, "1 to 21 points of 1e29", all, 1e29, {0, 1}, Quantity::weight);
  recovered(table, "1 to 21 points of 1e-30", all, 1e-30, {0, 1}, Quantity::weight);
  recovered(table, "1 to 21 points, v B(v)", all, 1, {0, 1}, Quantity::emission);
  recovered(table, "values of -1e30 to 1e30", all, 1, {-1e30, 1e30}, Quantity::weight);
  recovered(table, "values 1 apart on 1e8", all, 1, {1e8, 1e8 + 1}, Quantity::weight);
  recovered(table, "21 points", {21}, 1, {0, 1}, Quantity::weight);
  recovered(table, "21 points, v B(v)", {21}, 1, {0, 1}, Quantity::emission);
  table.refusal("a range without extent", "uniform_samples", "double", [] {
    (void)uniform_samples({1, 1}, 10);
  });
  table.refusal("22 points", "fit_bezier", "double", [] {
    const Samples samples = uniform_samples({0, 1}, 100);
    FitOptions options;
    options.points = 22;
    (void)fit_bezier(samples, {std::vector<double>(100, 1.0)}, options);
  });
}

}  // namespace vol::stability
