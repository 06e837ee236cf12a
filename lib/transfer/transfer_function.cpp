#include "transfer/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"

namespace vol::transfer {
namespace {

template <class Point>
void require_ordered(const std::vector<Point>& points, const char* what) {
  if (points.empty()) throw Error(std::string("transfer function without ") + what + " points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i].value)) throw Error(std::string(what) + " point at a value that is not finite");
    if (i > 0 && points[i].value < points[i - 1].value) {
      throw Error(std::string(what) + " points are not in order: " + std::to_string(points[i].value) + " after " +
                  std::to_string(points[i - 1].value));
    }
  }
}

/// Piecewise-linear interpolation; `get` picks the quantity. At a jump the right-hand point holds.
template <class Point, class Get>
auto interpolate(const std::vector<Point>& points, double value, const Get& get) {
  const auto above = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& p) { return v < p.value; });
  if (above == points.begin()) return get(points.front());
  if (above == points.end()) return get(points.back());
  const Point& p = *(above - 1);
  const Point& q = *above;
  const double w = (value - p.value) / (q.value - p.value);
  using Value = std::decay_t<decltype(get(p))>;
  return Value(get(p) + w * (get(q) - get(p)));
}

}  // namespace

TransferFunction::TransferFunction(std::vector<ColourPoint> colours, std::vector<OpacityPoint> opacities)
    : colours_(std::move(colours)), opacities_(std::move(opacities)) {
  require_ordered(colours_, "colour");
  require_ordered(opacities_, "opacity");
  for (const auto& p : colours_) {
    if (!p.rgb.allFinite() || p.rgb.minCoeff() < 0) throw Error("colour with a component that is negative or not finite");
  }
  for (const auto& p : opacities_) {
    if (!(p.opacity >= 0 && p.opacity <= 1)) {
      throw Error("opacity " + std::to_string(p.opacity) + " is outside 0 to 1");
    }
  }
  for (const auto& p : colours_) breakpoints_.push_back(p.value);
  for (const auto& p : opacities_) breakpoints_.push_back(p.value);
  std::sort(breakpoints_.begin(), breakpoints_.end());
  breakpoints_.erase(std::unique(breakpoints_.begin(), breakpoints_.end()), breakpoints_.end());
}

Vec3 TransferFunction::colour(double value) const {
  return interpolate(colours_, value, [](const ColourPoint& p) { return p.rgb; });
}

double TransferFunction::opacity(double value) const {
  return interpolate(opacities_, value, [](const OpacityPoint& p) { return p.opacity; });
}

double TransferFunction::max_opacity(double lo, double hi) const {
  double most = std::max(opacity(lo), opacity(hi));
  for (const auto& p : opacities_) {
    if (p.value >= lo && p.value <= hi) most = std::max(most, p.opacity);
  }
  return most;
}

double TransferFunction::min_opacity(double lo, double hi) const {
  double least = std::min(opacity(lo), opacity(hi));
  for (const auto& p : opacities_) {
    if (p.value >= lo && p.value <= hi) least = std::min(least, p.opacity);
  }
  return least;
}

}  // namespace vol::transfer
