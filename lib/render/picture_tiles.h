#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace vol::render {

/// A picture in 16 x 16 parts (of 16 pixels at least), for sums over what reaches each of them.
class PictureTiles {
 public:
  PictureTiles(int width, int height) : size_(std::max({16, (width + 15) / 16, (height + 15) / 16})) {
    columns_ = (width + size_ - 1) / size_;
    rows_ = (height + size_ - 1) / size_;
  }
  /// Means over a part's pixels of the sum of magnitudes and of squares of what reaches a pixel; the largest.
  struct Sums {
    double one = 0, two = 0, largest = 0;
  };
  [[nodiscard]] std::vector<Sums> none() const {
    return std::vector<Sums>(static_cast<std::size_t>(columns_ * rows_));
  }
  /// f(part, share of it) for the parts that the rectangle between some pixels meets.
  template <class F>
  void visit(double column0, double column1, double row0, double row1, const F& f) const {
    const auto first = [this](double p) { return static_cast<int>(std::max(std::floor(p / size_), 0.0)); };
    const auto last = [this](double p, int count) {
      return static_cast<int>(std::clamp(std::floor(p / size_), -1.0, count - 1.0));
    };
    const auto share = [this](double low, double high, int part) {
      return (std::min(high, double(part + 1) * size_) - std::max(low, double(part) * size_)) / size_;
    };
    if (column0 >= columns_ * size_ || row0 >= rows_ * size_) return;
    for (int j = first(row0); j <= last(row1, rows_); ++j) {
      for (int i = first(column0); i <= last(column1, columns_); ++i) {
        f(static_cast<std::size_t>(j * columns_ + i), share(column0, column1, i) * share(row0, row1, j));
      }
    }
  }

 private:
  int size_, columns_ = 0, rows_ = 0;
};

}  // namespace vol::render
