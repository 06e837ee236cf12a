#pragma once
#include <vector>

namespace vol::transfer {

struct ProfilePoint {
  double value;
  double weight;
};

/// A weight for each data value as a user draws it: linear between points, the end values outside; two points
/// at one value are a step, at which the second holds. Unlike an opacity it may be any finite number.
class Profile {
 public:
  /// \throws vol::Error for no points, points out of order, a number that is not finite
  explicit Profile(std::vector<ProfilePoint> points);

  [[nodiscard]] double value(double value) const;
  [[nodiscard]] const std::vector<ProfilePoint>& points() const { return points_; }

 private:
  std::vector<ProfilePoint> points_;
};

}  // namespace vol::transfer
