#include "transfer/bezier.h"

#include "base/rng.h"
#include "kernels.h"
#include "truth.h"

// Curves of up to 21 control points, against the sum of Bernstein polynomials.
namespace vol::stability {
namespace {

const double kPlaces[] = {
    0, std::numeric_limits<double>::min(), 1e-16, 1e-3, 0.1, 0.37, 0.5, 0.83, 0.999, 1 - 0x1p-53, 1};

Real bernstein(int degree, int i, Real t) {
  Real b = 1;
  for (int k = 0; k < i; ++k) b = b * static_cast<Real>(degree - k) / static_cast<Real>(k + 1);
  return b * std::pow(t, static_cast<Real>(i)) * std::pow(1 - t, static_cast<Real>(degree - i));
}

struct Sum {
  Real value = 0, magnitude = 0;
};
Sum sum_of(const std::vector<double>& points, Real t) {
  Sum sum;
  const int degree = static_cast<int>(points.size()) - 1;
  for (int i = 0; i <= degree; ++i) {
    const Real term = bernstein(degree, i, t) * static_cast<Real>(points[static_cast<std::size_t>(i)]);
    sum.value += term;
    sum.magnitude += std::abs(term);
  }
  return sum;
}

std::vector<double> random_points(Rng& rng, int n, double scale, double offset) {
  std::vector<double> points;
  for (int i = 0; i < n; ++i) points.push_back(offset + scale * rng.uniform(-1, 1));
  return points;
}

void values(Table& table, const std::string& what, double scale, double offset) {
  Worst value, slope, raised;
  Rng rng(9);
  for (int n = 1; n <= transfer::kMostControlPoints; ++n) {
    const auto points = random_points(rng, n, scale, offset);
    const auto higher = transfer::elevated(points, transfer::kMostControlPoints);
    std::vector<double> differences;
    double largest = 0;
    for (int i = 0; i + 1 < n; ++i) {
      const double difference = points[static_cast<std::size_t>(i + 1)] - points[static_cast<std::size_t>(i)];
      differences.push_back((n - 1) * difference);
      largest = std::max(largest, (n - 1) * (std::abs(points[static_cast<std::size_t>(i)]) +
                                             std::abs(points[static_cast<std::size_t>(i + 1)])));
    }
    for (const double t : kPlaces) {
      const Sum truth = sum_of(points, t);
      const auto found = transfer::de_casteljau(points, t);
      const auto relative = [](double x, Real y, Real size) {
        return static_cast<double>(std::abs(x - y) /
                                   (size + static_cast<Real>(std::numeric_limits<double>::min())));
      };
      value.add(relative(found.value, truth.value, truth.magnitude), gamma(3.0 * (n - 1), kDouble));
      if (n > 1)
        slope.add(relative(found.slope, sum_of(differences, t).value, largest), gamma(3.0 * n, kDouble));
      // Raising the degree takes as many means, evaluating them as many again.
      raised.add(relative(static_cast<double>(sum_of(higher, t).value), truth.value,
                          sum_of(higher, t).magnitude + truth.magnitude),
                 gamma(4.0 * (transfer::kMostControlPoints - n + 1), kDouble));
    }
  }
  table.row(what, "de_casteljau, value", "double", value,
            "n - 1 means of 3 roundings: gamma_3(n-1) of sum b|P|");
  table.row(what, "de_casteljau, slope", "double", slope, "gamma_3n of the largest (n-1)(|P_i| + |P_i+1|)");
  table.row(what, "elevated to 21", "double", raised, "21 - n means of 4 roundings, of sum b|P|");
}

void bases(Table& table) {
  Worst basis, sums;
  for (int n = 1; n <= transfer::kMostControlPoints; ++n) {
    std::vector<double> b(static_cast<std::size_t>(n));
    for (const double t : kPlaces) {
      transfer::bernstein_basis(t, b);
      Real total = -1;
      for (int i = 0; i < n; ++i) {
        const Real truth = bernstein(n - 1, i, t);
        total += static_cast<Real>(b[static_cast<std::size_t>(i)]);
        basis.add(static_cast<double>(std::abs(b[static_cast<std::size_t>(i)] - truth) /
                                      (truth + static_cast<Real>(std::numeric_limits<double>::min()))),
                  gamma(3.0 * n, kDouble));
      }
      sums.add(static_cast<double>(std::abs(total)), gamma(3.0 * n, kDouble));
    }
  }
  table.row("up to 21 polynomials, t from 0 to 1 - ulp/2 and 1", "bernstein_basis", "double", basis,
            "positive terms: gamma_3n, relative");
  table.row("up to 21 polynomials, t from 0 to 1 - ulp/2 and 1", "bernstein_basis, sum", "double", sums,
            "1 within gamma_3n");
}

/// X(t) = v with abscissae that crowd: the residual of the root.
void parameters(Table& table) {
  Worst residual;
  Rng rng(4);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + static_cast<int>(rng.below(20));
    std::vector<double> x{0};
    for (int i = 1; i < n; ++i) x.push_back(x.back() + std::pow(10, rng.uniform(-6, 0)));
    for (double& a : x) a /= x.back() > 0 ? x.back() : 1;
    x.back() = 1;
    bool rising = true;
    for (int i = 1; i < n; ++i)
      rising = rising && x[static_cast<std::size_t>(i)] > x[static_cast<std::size_t>(i - 1)];
    if (!rising) continue;
    const transfer::BezierCurve curve(random_points(rng, n, 1, 0), x);
    for (const double v : kPlaces) {
      // t is a double: X moves by X' times half its ulp; and X itself is known to gamma_3n.
      const double t = curve.parameter(v);
      const double steep = transfer::de_casteljau(x, t).slope;
      residual.add(static_cast<double>(std::abs(sum_of(x, t).value - static_cast<Real>(v))),
                   4 * kDouble * steep + gamma(6.0 * n, kDouble));
    }
  }
  table.row("abscissae 1e-6 apart and further, up to 21", "BezierCurve::parameter", "double", residual,
            "t to 4 u, X to gamma_6n: |X(t) - v|");
}

}  // namespace

void bezier(Table& table) {
  values(table, "up to 21 points of -1 to 1, t from 0 to 1 - ulp/2 and 1", 1, 0);
  values(table, "points of 1e30", 1e30, 0);
  values(table, "points of 1e-30", 1e-30, 0);
  values(table, "points of 1 on 1e8", 1, 1e8);
  bases(table);
  parameters(table);
  table.refusal("22 points", "BezierCurve", "double",
                [] { (void)transfer::BezierCurve(std::vector<double>(22, 1.0)); });
  table.refusal("a point beyond 1e30", "BezierCurve", "double", [] {
    (void)transfer::BezierCurve({0, 2e30});
  });
  table.refusal("abscissae that fall", "BezierCurve", "double", [] {
    (void)transfer::BezierCurve({0, 1, 0}, {0, 0.7, 0.7});
  });
}

}  // namespace vol::stability
