#pragma once
#include <algorithm>
#include <limits>

#include "base/vec.h"

namespace vol::render {

/// Whether a line meets boxes within [begin, end], by slabs.
class LineMeets {
 public:
  LineMeets(const Vec3& origin, const Vec3& direction, double begin, double end)
      : origin_(origin), begin_(begin), end_(end) {
    for (int a = 0; a < 3; ++a) {
      inverse_[a] = direction[a] == 0 ? std::numeric_limits<double>::infinity() : 1 / direction[a];
    }
  }

  [[nodiscard]] bool operator()(const Box3& box) const {
    double in = begin_, out = end_;
    for (int a = 0; a < 3; ++a) {
      if (inverse_[a] == std::numeric_limits<double>::infinity()) {
        if (origin_[a] < box.min[a] || origin_[a] > box.max[a]) return false;
        continue;
      }
      const double near = (box.min[a] - origin_[a]) * inverse_[a];
      const double far = (box.max[a] - origin_[a]) * inverse_[a];
      in = std::max(in, std::min(near, far));
      out = std::min(out, std::max(near, far));
    }
    return in <= out;
  }

 private:
  Vec3 origin_;
  Vec3 inverse_;
  double begin_, end_;
};

}  // namespace vol::render
