#pragma once
#include <cmath>

namespace vol {

/// Sum with the rounding of each addition carried along (Neumaier 1974): error about one ulp of the result
/// plus n eps^2 sum |x|, whatever the order of magnitude of the terms.
class CompensatedSum {
 public:
  void add(double x) {
    const double t = sum_ + x;
    carry_ += std::abs(sum_) >= std::abs(x) ? (sum_ - t) + x : (x - t) + sum_;
    sum_ = t;
  }
  void add(const CompensatedSum& other) {
    add(other.sum_);
    carry_ += other.carry_;
  }
  [[nodiscard]] double value() const {
    const double total = sum_ + carry_;
    return std::isnan(total) ? sum_ : total;  // an infinite sum has carry inf - inf
  }

 private:
  double sum_ = 0;
  double carry_ = 0;
};

}  // namespace vol
