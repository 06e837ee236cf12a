#include "transfer/opacity.h"

#include <cmath>
#include <limits>

namespace vol::transfer {

double extinction(double opacity, double reference_length) { return -std::log1p(-opacity) / reference_length; }

double corrected_opacity(double opacity, double step, double reference_length) {
  if (opacity >= 1) return step > 0 ? 1.0 : 0.0;
  return -std::expm1(step / reference_length * std::log1p(-opacity));
}

double mean_ramp_depth(double a0, double a1) {
  const double u0 = 1 - a0, u1 = 1 - a1;
  if (u0 == 0 && u1 == 0) return std::numeric_limits<double>::infinity();
  // With m the midpoint and r = (u0 - u1) / (u0 + u1), log is analytic about m and its mean over the segment is
  // log m - sum_k r^2k / (2k (2k + 1)). For |r| < 0.05 five terms leave less than r^12 / 156 < 2e-18.
  const double r = (u0 - u1) / (u0 + u1);
  if (std::abs(r) < 0.05) {
    const double q = r * r;
    const double tail = q * (1.0 / 6 + q * (1.0 / 20 + q * (1.0 / 42 + q * (1.0 / 72 + q / 110))));
    // The midpoint as the smaller of a and 1 - a, which keeps its digits: 1 - a is exact from 1/2 on.
    const double u = 0.5 * (u0 + u1);
    return (u < 0.5 ? -std::log(u) : -std::log1p(-0.5 * (a0 + a1))) + tail;
  }
  const auto u_log_u = [](double a) { return a >= 1 ? 0.0 : (1 - a) * std::log1p(-a); };
  return 1 + (u_log_u(a1) - u_log_u(a0)) / (u0 - u1);
}

}  // namespace vol::transfer
