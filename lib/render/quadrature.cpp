#include "render/quadrature.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/gauss.h"
#include "transfer/opacity.h"

namespace vol::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Segment absorbing(double tau, const Vec3& colour) {
  const double alpha = -std::expm1(-tau);
  return {colour * alpha, alpha, std::exp(-tau), tau};
}

Segment opaque(const Vec3& colour) {
  return {colour, 1, 0, kInfinity};
}

/// Appends a piece behind what a segment holds already.
void append(Segment& front, const Segment& back) {
  front.emission += front.transmittance * back.emission;
  front.alpha += front.transmittance * back.alpha;
  front.transmittance *= back.transmittance;
  front.optical_depth += back.optical_depth;
}

/// Optical depth of a ramp, 0 for no length (where an opaque piece would give 0 times infinity).
double ramp_depth(double a0, double a1, double r) {
  return r > 0 ? r * transfer::mean_ramp_depth(a0, a1) : 0;
}

}  // namespace

Segment rectangle(const Node& left, double h, const Optics& optics) {
  if (left.opacity >= 1) return opaque(left.lit(left.colour));
  return absorbing(-std::log1p(-left.opacity) * (h / optics.reference_length()), left.lit(left.colour));
}

Segment trapezoid(const Node& left, const Node& right, double h, const Optics& optics) {
  const double r = h / optics.reference_length();
  const bool left_opaque = left.opacity >= 1;
  const bool right_opaque = right.opacity >= 1;
  if (left_opaque && right_opaque) return opaque(left.lit(left.colour));
  if (left_opaque || right_opaque) {
    const Node& end = left_opaque ? left : right;
    return absorbing(ramp_depth(left.opacity, right.opacity, r), end.lit(end.colour));
  }
  const double s0 = -std::log1p(-left.opacity);
  const double s1 = -std::log1p(-right.opacity);
  if (s0 + s1 == 0) return {};
  const double weight = s1 / (s0 + s1);
  return absorbing(r * 0.5 * (s0 + s1),
                   (1 - weight) * left.lit(left.colour) + weight * right.lit(right.colour));
}

Segment ramp(double a0, double a1, const Vec3& c0, const Vec3& c1, double r) {
  if (a0 == 1 && a1 == 1) return opaque(c0);
  const double tau = ramp_depth(a0, a1, r);
  Segment segment = absorbing(tau, c0);
  if (c0 == c1 || tau == 0) return segment;
  const auto excess = [&](double u) {  // e^-(tau - rho) - e^-tau
    const double rho = ramp_depth(a0 + u * (a1 - a0), a1, r * (1 - u));
    return rho < 1 ? std::exp(-tau) * std::expm1(rho) : std::exp(rho - tau) - std::exp(-tau);
  };
  // Where tau is large all happens near the start: a first cut there keeps the rule from overlooking it.
  const double cut = tau > 4 ? 4 / tau : 0.5;
  const double integral = gauss_kronrod(excess, 0, cut, 5e-14) + gauss_kronrod(excess, cut, 1, 5e-14);
  segment.emission += (c1 - c0) * integral;
  return segment;
}

Segment preintegrated(const Node& left, const Node& right, double h, const Optics& optics) {
  const double f0 = left.value, f1 = right.value;
  const double r = h / optics.reference_length();
  const bool rising = f1 >= f0;
  const Vec3 diffuse_highlight(0.5 * (left.lit.diffuse + right.lit.diffuse),
                               0.5 * (left.lit.specular + right.lit.specular), 0);
  Segment total;
  // Walk the intervals from f0's to f1's. Falling values leave an interval through its lower end, so one that
  // starts exactly on a point belongs to the interval below.
  std::size_t k = optics.interval_of(f0);
  if (!rising && k > 0 && optics.intervals()[k].lo == f0) --k;
  double f = f0;
  double position = 0;  // of f along the segment, in [0, 1]
  while (total.transmittance > 0) {
    const OpticsInterval& interval = optics.intervals()[k];
    const double border = rising ? interval.hi : interval.lo;
    const bool last = rising ? !(border < f1) : !(border > f1);
    const double f_end = last ? f1 : border;
    const double end =
        last ? 1.0 : std::clamp((0.5 * f_end - 0.5 * f0) / (0.5 * f1 - 0.5 * f0), position, 1.0);
    if (end > position && !interval.transparent()) {
      append(total, ramp(interval.opacity(f), interval.opacity(f_end), interval.colour(f),
                         interval.colour(f_end), r * (end - position)));
    }
    if (last) break;
    f = f_end;
    position = end;
    k += rising ? 1 : std::size_t(-1);
  }
  total.emission = total.emission * diffuse_highlight[0] + Vec3::Constant(diffuse_highlight[1] * total.alpha);
  return total;
}

}  // namespace vol::render
