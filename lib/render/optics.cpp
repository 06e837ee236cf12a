#include "render/optics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace vol::render {
namespace {

/// Limit of a piecewise-linear list from below: at a jump the first point at that value holds.
template <class Point, class Get>
auto from_below(const std::vector<Point>& points, double value, const Get& get) {
  using Value = std::decay_t<decltype(get(points.front()))>;
  const auto at = std::lower_bound(points.begin(), points.end(), value,
                                   [](const Point& p, double v) { return p.value < v; });
  if (at == points.end()) return Value(get(points.back()));
  if (at->value == value || at == points.begin()) return Value(get(*at));
  const Point& p = *(at - 1);
  const double w = (value - p.value) / (at->value - p.value);
  return Value(get(p) + w * (get(*at) - get(p)));
}

}  // namespace

double OpticsInterval::position(double value) const {
  // Halved, so that values near the largest double do not overflow.
  return std::clamp((0.5 * value - 0.5 * lo) / (0.5 * hi - 0.5 * lo), 0.0, 1.0);
}

double OpticsInterval::opacity(double value) const {
  const double w = opacity_lo == opacity_hi ? 1 : position(value);
  return w == 1 ? opacity_hi : opacity_lo + w * (opacity_hi - opacity_lo);  // opaque stays opaque exactly
}

Vec3 OpticsInterval::colour(double value) const {
  if (colour_lo == colour_hi) return colour_lo;
  return colour_lo + position(value) * (colour_hi - colour_lo);
}

Optics::Optics(const transfer::TransferFunction& transfer, double reference_length)
    : transfer_(transfer), reference_length_(reference_length) {
  if (!(reference_length > 0) || !std::isfinite(reference_length)) {
    throw Error("reference length of the opacities is not a positive number");
  }
  if (transfer.opacities().empty()) throw Error("scene without a transfer function");
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto& points = transfer.breakpoints();
  const auto colour = [](const transfer::ColourPoint& p) { return p.rgb; };
  const auto opacity = [](const transfer::OpacityPoint& p) { return p.opacity; };
  for (std::size_t k = 0; k <= points.size(); ++k) {
    OpticsInterval interval{k > 0 ? points[k - 1] : -kInfinity,
                            k < points.size() ? points[k] : kInfinity,
                            0,
                            0,
                            Vec3::Zero(),
                            Vec3::Zero()};
    if (k > 0) {
      interval.opacity_lo = transfer.opacity(interval.lo);
      interval.colour_lo = transfer.colour(interval.lo);
    }
    if (k < points.size()) {
      interval.opacity_hi = from_below(transfer.opacities(), interval.hi, opacity);
      interval.colour_hi = from_below(transfer.colours(), interval.hi, colour);
    }
    if (k == 0) {
      interval.opacity_lo = interval.opacity_hi;
      interval.colour_lo = interval.colour_hi;
    }
    if (k == points.size()) {
      interval.opacity_hi = interval.opacity_lo;
      interval.colour_hi = interval.colour_lo;
    }
    intervals_.push_back(interval);
  }
  for (const auto& p : transfer.colours()) brightest_ = std::max(brightest_, p.rgb.maxCoeff());
}

std::size_t Optics::interval_of(double value) const {
  const auto& points = transfer_.breakpoints();
  return static_cast<std::size_t>(std::upper_bound(points.begin(), points.end(), value) - points.begin());
}

}  // namespace vol::render
