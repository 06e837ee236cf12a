#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/parallel_view.h"
#include "wavelet/expansion.h"

namespace vol::render {

/// A view along an axis z of the grid: the footprint of f(x) g(y) h(z) is f(x) g(y) times the integral of h
/// within the box. So it is, but for a small error, a little off the axis: a term is then read where the ray
/// passes the middle of its support.
class AxisProducts {
 public:
  /// None where the error, by the largest slopes, may exceed what is allowed. Along an axis, and within 1e-12
  /// samples of that, there is none.
  /// \param rays  all rows of the picture
  [[nodiscard]] static std::optional<AxisProducts> make(const wavelet::Expansion& expansion,
                                                        const ParallelView& view,
                                                        const std::vector<PixelRow>& rays, double allowed);

  [[nodiscard]] int axis() const { return axis_; }
  /// Bound of a pixel's error.
  [[nodiscard]] double estimate() const { return estimate_; }

  /// Adds the rows first .. first + count - 1, a stride apart; right for pixels whose rays enter and leave
  /// through the faces across the axis. \param met  if given, +1 where a term begins in a row, -1 behind its
  /// end
  void add(const std::vector<PixelRow>& rays, int first, int count, std::int64_t stride, double* values,
           std::int32_t* met) const;

 private:
  struct Item {
    const wavelet::Band* band = nullptr;
    const wavelet::Term* term = nullptr;
    std::array<const wavelet::PiecewiseCubic*, 2> factor{};
    double amplitude = 0;
    double plane = 0;               ///< index coordinate, along the axis, of the middle of its support
    std::array<double, 4> reach{};  ///< least and most column, least and most row
  };
  /// One of the two functions where the ray of a pixel passes the item's plane; the arithmetic is that of
  /// wavelet::line_integral, so that at a jump both take the same side.
  [[nodiscard]] double factor_at(const Item& item, std::size_t which, const PixelRow& row,
                                 std::size_t x) const;

  int axis_ = 2;
  int width_ = 0;
  Vec3 direction_ = Vec3::UnitZ();
  double estimate_ = 0;
  /// Which function goes with the columns, the other going with the rows: the usual camera. 2: neither.
  std::size_t columns_ = 2;
  int hit_column_ = 0, hit_row_ = 0;  ///< a pixel whose ray meets the box
  std::vector<Item> items_;
};

}  // namespace vol::render
