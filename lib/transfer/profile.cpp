#include "transfer/profile.h"

#include "transfer/piecewise_linear.h"

namespace vol::transfer {

Profile::Profile(std::vector<ProfilePoint> points) : points_(std::move(points)) {
  require_ordered(points_, "weight");
  for (const auto& p : points_) {
    if (!std::isfinite(p.weight))
      throw Error("weight that is not finite at the value " + std::to_string(p.value));
  }
}

double Profile::value(double value) const {
  return interpolate(points_, value, [](const ProfilePoint& p) { return p.weight; });
}

}  // namespace vol::transfer
