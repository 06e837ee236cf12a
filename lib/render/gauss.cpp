#include "render/gauss.h"

#include <cmath>
#include <numbers>

namespace vol::render {
namespace {

constexpr int kN = GaussCollocation::kNodes;

/// P_0 .. P_n at z in [-1, 1], by the three-term recurrence.
std::array<double, kN + 2> legendre(double z) {
  std::array<double, kN + 2> p{};
  p[0] = 1;
  p[1] = z;
  for (int k = 1; k <= kN; ++k) p[k + 1] = ((2 * k + 1) * z * p[k] - k * p[k - 1]) / (k + 1);
  return p;
}

GaussCollocation make() {
  GaussCollocation g{};
  for (int i = 0; i < kN; ++i) {
    double z = -std::cos(std::numbers::pi * (i + 0.75) / (kN + 0.5));  // Newton from the usual estimate
    double slope = 1;
    for (int step = 0; step < 10; ++step) {
      const auto p = legendre(z);
      slope = kN * (z * p[kN] - p[kN - 1]) / (z * z - 1);
      z -= p[kN] / slope;
    }
    g.x[i] = 0.5 * (1 + z);
    g.w[i] = 1 / ((1 - z * z) * slope * slope);
  }
  // A function sampled at the nodes has Legendre coefficients c_k = (2k+1) sum_j w_j P_k(z_j) f_j, exact up
  // to degree kN - 1, and the integral of P_k from -1 to z is (P_{k+1} - P_{k-1})(z) / (2k+1), of P_0 it is 1
  // + z.
  for (int j = 0; j < kN; ++j) {
    const auto pj = legendre(2 * g.x[j] - 1);
    g.coefficient_last[j] = (2 * kN - 1) * g.w[j] * pj[kN - 1];
    g.coefficient_before[j] = (2 * kN - 3) * g.w[j] * pj[kN - 2];
    for (int i = 0; i < kN; ++i) {
      const auto pi = legendre(2 * g.x[i] - 1);
      double sum = g.w[j] * (pi[1] + 1);
      for (int k = 1; k < kN; ++k) sum += g.w[j] * pj[k] * (pi[k + 1] - pi[k - 1]);
      g.up_to[i][j] = 0.5 * sum;
    }
  }
  return g;
}

}  // namespace

const GaussCollocation& gauss_collocation() {
  static const GaussCollocation g = make();
  return g;
}

}  // namespace vol::render
