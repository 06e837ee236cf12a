#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.h"

// Lists of points in order of their `value`: what transfer functions and profiles are made of.
namespace vol::transfer {

/// \throws vol::Error saying `what` kind of points is missing, not finite or out of order
template <class Point>
void require_ordered(const std::vector<Point>& points, const char* what) {
  if (points.empty()) throw Error(std::string("transfer function without ") + what + " points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i].value))
      throw Error(std::string(what) + " point at a value that is not finite");
    if (i > 0 && points[i].value < points[i - 1].value) {
      throw Error(std::string(what) + " points are not in order: " + std::to_string(points[i].value) +
                  " after " + std::to_string(points[i - 1].value));
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
  const double span = q.value - p.value;
  const double w = std::isfinite(span) ? (value - p.value) / span
                                       : (value / 2 - p.value / 2) / (q.value / 2 - p.value / 2);
  using Value = std::decay_t<decltype(get(p))>;
  return Value(get(p) + w * (get(q) - get(p)));
}

}  // namespace vol::transfer
