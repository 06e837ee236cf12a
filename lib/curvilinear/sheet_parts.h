#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/buffer.h"
#include "curvilinear/screen.h"
#include "curvilinear/sheets.h"

// Private to lib/curvilinear: what both ways of drawing sheets stand on.
namespace vol::curvilinear {

/// 1 - exp(-x) for x >= 0, infinity included; float, relative error some eps.
inline float opacity_of_depth(float x) {
  if (x < 0.125F) {  // the first term left out is x^7 / 5040, relatively 1e-9
    constexpr float kThird = 1.0F / 3, kFifth = 1.0F / 5, kSixth = 1.0F / 6;
    return x * (1 - x * 0.5F * (1 - x * kThird * (1 - x * 0.25F * (1 - x * kFifth * (1 - x * kSixth)))));
  }
  return -std::expm1(-x);
}

/// Colour and optical depth phi(a) = -log1p(-a) by value: even steps between the first and the last break of
/// the transfer function, the value at each step's middle; what lies outside exactly. Values are looked up as
/// shares of that stretch, made of them in double precision before anything is narrowed: so a small signal on
/// a large offset keeps its digits.
class TransferTable {
 public:
  struct Entry {
    float r, g, b, depth;
  };
  /// \param off  values may be off by so much (a share; of a single break a distance): the largest optical
  /// depth there (or the smallest, `off` being negative), with the colour at the stretch's higher (lower) end
  TransferTable(const transfer::TransferFunction& transfer, double thinned_by, double off = 0);
  /// 0 at the first break, 1 at the last; of a single break the distance from it. Held within +-1e30, so that
  /// float holds what lies between two of them.
  [[nodiscard]] double share(double value) const {
    constexpr double kMost = 1e30;
    return std::clamp((value - origin_) * scale_ * per_value_, -kMost, kMost);
  }
  [[nodiscard]] const Entry& operator()(float share) const {
    if (!(share > 0)) return entries_.front();
    if (share >= end_) return entries_.back();
    return entries_[1 + static_cast<std::size_t>(share * kEntries)];
  }
  /// Of the stretch, as a share; of a single break infinite.
  [[nodiscard]] double range() const { return end_ == 1 ? 1 : std::numeric_limits<double>::infinity(); }
  /// For kernels that look many values up at once: entries()[1 + share steps()], but the first up to 0 and
  /// the last from end() on.
  [[nodiscard]] const Entry* entries() const { return entries_.data(); }
  [[nodiscard]] std::int32_t last() const { return static_cast<std::int32_t>(entries_.size()) - 1; }
  [[nodiscard]] static constexpr float steps() { return kEntries; }
  [[nodiscard]] float end() const { return end_; }

 private:
  static constexpr int kEntries = 1 << 14;
  std::vector<Entry> entries_;
  double origin_, per_value_ = 1;
  double scale_ = 1;  ///< other than 1 where the reciprocal of the stretch is no number
  float end_ = std::numeric_limits<float>::min();  ///< share of the last break; of a single one all above it
};

/// Rows [top, bottom) of the picture while it is drawn, front to back.
struct Band {
  struct alignas(16) Pixel {
    float r = 0, g = 0, b = 0, transmittance = 1;
  };
  int width = 0, top = 0, bottom = 0;
  std::vector<Pixel> pixels;
  std::vector<std::int32_t> samples;  ///< of each pixel
  std::vector<std::int32_t> sheets;   ///< of each pixel, the last that drew there; of layers only
  std::int32_t sheet = 0;
  /// Where a pixel's ray is inside the solid that is drawn: the last surface it met. Of physical thickness
  /// only.
  struct Inside {
    Buffer<float> depth, value;
    Buffer<std::int32_t> solid;  ///< number of the solid; another: not inside
  } inside;
  std::int32_t solid = 0;
  SheetCounts counts;

  Band() = default;
  Band(int image_width, int first, int end) : width(image_width), top(first), bottom(end) {
    const auto count = static_cast<std::size_t>(image_width) * static_cast<std::size_t>(end - first);
    pixels.resize(count);
    samples.resize(count);
  }
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y - top) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  /// A piece of a sheet over what is in front of it.
  void composite(std::size_t at, const TransferTable::Entry& entry, float opacity) {
    ++samples[at];
    Pixel& pixel = pixels[at];
    const float weight = pixel.transmittance * opacity;
    pixel.r += weight * entry.r;
    pixel.g += weight * entry.g;
    pixel.b += weight * entry.b;
    pixel.transmittance -= weight;
  }
};

/// A solid in view coordinates with its axes put so that sheets of constant w are drawn from w = 0 to 1:
/// front to back, and of the largest area in the picture.
struct Oriented {
  Solid solid;
  int axis;  ///< which was taken for w
};
[[nodiscard]] Oriented oriented(const Solid& seen, const Screen& screen);

/// Bounds of the solid's change per unit of each parameter, from its control points: in the picture (the
/// larger of x and y) and in space (of each coordinate's largest), both in pixels.
struct Extents {
  double across[3] = {};
  double length[3] = {};
};
[[nodiscard]] Extents extents(const Solid& seen, const Screen& screen);

/// The largest differences of neighbouring control points, of each coordinate (x, y, z, value): first and
/// second along each axis, and mixed along the first two. In float, less an origin near the solid, so that
/// they are those of the solid to 1e-6 of its size.
struct LargestDifferences {
  Eigen::Array4f first[3], second[3], mixed;
  LargestDifferences(const Solid& seen, const Point4& origin);
};
/// The same; what they give is only more in perspective.
[[nodiscard]] Extents extents(const Solid& seen, const LargestDifferences& differences, const Screen& screen);

/// Pixels that control points span.
struct ImageBox {
  double left, right, top, bottom;
  ImageBox(const Solid& seen, const Screen& screen);
};

/// Points by which steps of `throttle` do not exceed an extent; 1 to kMostSteps.
[[nodiscard]] int step_count(double extent, double throttle);

/// The points of a solid (oriented) by layers, into the rows of a band.
/// \param share  of its cell that it is, along w
void draw_layers(const Solid& solid, const Screen& screen, const TransferTable& table, double throttle,
                 double share, Band& band);

}  // namespace vol::curvilinear
