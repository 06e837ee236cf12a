#include "render/refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::render {
namespace {

constexpr int kDepthChannel = 5;
constexpr int kColours = 4;
constexpr int kLargestStep = 64;

/// Corners at (x, y) and (x + w, y + h); the last cells of a row or column are smaller, down to one pixel.
struct Cell {
  std::int32_t x, y, w, h;
  [[nodiscard]] bool is_single() const { return w <= 1 && h <= 1; }
};

/// Weights of four neighbours a cell apart for a place in the middle cell, t in [0, 1]: the cubic of Catmull
/// and Rom (1974), or where an outer neighbour is missing the line through the inner two.
using Weights = std::array<float, 4>;
Weights cubic(float t) {
  return {0.5F * t * (-1 + t * (2 - t)), 1 + 0.5F * t * t * (-5 + 3 * t), 0.5F * t * (1 + t * (4 - 3 * t)),
          0.5F * t * t * (t - 1)};
}
Weights linear(float t) {
  return {0, 1 - t, t, 0};
}

class Refinement {
 public:
  Refinement(image::Image& image, double tolerance, const CastPixels& cast)
      : image_(image),
        tolerance_(static_cast<float>(tolerance)),
        cast_(cast),
        known_(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {}

  void run(int step) {
    std::vector<Cell> cells = first_cells(step);
    for (const Cell& cell : cells) want_corners(cell);
    cast_wanted();
    while (!cells.empty()) cells = divide(cells);
    const auto some = [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) fill(leaves_[static_cast<std::size_t>(i)]);
    };
    parallel_for(0, static_cast<std::int64_t>(leaves_.size()), 32, some);
  }

 private:
  /// In blocks of 4 x 4, so that rays next to each other in the list are near in the picture.
  [[nodiscard]] std::vector<Cell> first_cells(int step) const {
    constexpr int kBlock = 4;
    const int across = std::max(1, (image_.width - 1 + step - 1) / step);
    const int down = std::max(1, (image_.height - 1 + step - 1) / step);
    std::vector<Cell> cells;
    cells.reserve(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
    for (int top = 0; top < down; top += kBlock) {
      for (int left = 0; left < across; left += kBlock) {
        for (int j = top; j < std::min(top + kBlock, down); ++j) {
          for (int i = left; i < std::min(left + kBlock, across); ++i) {
            const int x = i * step, y = j * step;
            cells.push_back(
                {x, y, std::min(step, image_.width - 1 - x), std::min(step, image_.height - 1 - y)});
          }
        }
      }
    }
    return cells;
  }

  [[nodiscard]] std::size_t offset(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] const float* pixel(int x, int y) const {
    return image_.pixels.data() + offset(x, y) * image_.channels.size();
  }
  [[nodiscard]] bool is_known(int x, int y) const {
    return x >= 0 && y >= 0 && x < image_.width && y < image_.height && known_[offset(x, y)];
  }
  void want(int x, int y) {
    if (known_[offset(x, y)]) return;
    known_[offset(x, y)] = 1;
    wanted_.push_back({x, y});
  }
  void want_corners(const Cell& c) {
    for (const int y : {c.y, c.y + c.h}) {
      for (const int x : {c.x, c.x + c.w}) want(x, y);
    }
  }
  void cast_wanted() {
    if (!wanted_.empty()) cast_(wanted_);
    wanted_.clear();
  }

  /// Second difference through three pixels in a line, `before` and `behind` apart, for a spacing of `size`:
  /// the largest over the channels.
  [[nodiscard]] float bend(const float* a, const float* b, const float* c, int before, int behind,
                           int size) const {
    const auto s = static_cast<float>(size);
    const float scale = 2 * s * s / static_cast<float>(before + behind);
    float most = 0;
    for (int k = 0; k < kColours; ++k) {
      const float d = (c[k] - b[k]) / static_cast<float>(behind) - (b[k] - a[k]) / static_cast<float>(before);
      most = std::max(most, d == d ? std::abs(scale * d) : INFINITY);
    }
    return most;
  }

  /// The largest second difference along a side from (x, y), `size` pixels in direction (dx, dy), and its
  /// neighbours on the same line; infinite where there is none to compare with.
  [[nodiscard]] float side_bend(int x, int y, int dx, int dy, int size) const {
    if (size <= 1) return 0;
    const int ex = x + size * dx, ey = y + size * dy;
    float most = -1;
    for (const int reach : {size, size + 1, size - 1}) {
      if (is_known(x - reach * dx, y - reach * dy)) {
        most = std::max(
            most, bend(pixel(x - reach * dx, y - reach * dy), pixel(x, y), pixel(ex, ey), reach, size, size));
        break;
      }
    }
    for (const int reach : {size, size + 1, size - 1}) {
      if (is_known(ex + reach * dx, ey + reach * dy)) {
        most = std::max(most, bend(pixel(x, y), pixel(ex, ey), pixel(ex + reach * dx, ey + reach * dy), size,
                                   reach, size));
        break;
      }
    }
    return most < 0 ? INFINITY : most;
  }

  /// Interpolation misses a kink in the middle of a cell by half of the second differences at its corners,
  /// and less where the picture is smooth.
  [[nodiscard]] bool is_flat(const Cell& c) const {
    const float across = std::max(side_bend(c.x, c.y, 1, 0, c.w), side_bend(c.x, c.y + c.h, 1, 0, c.w));
    const float down = std::max(side_bend(c.x, c.y, 0, 1, c.h), side_bend(c.x + c.w, c.y, 0, 1, c.h));
    return 0.5F * (across + down) <= tolerance_;
  }

  /// Flat cells become leaves; the quarters of the others are returned, their corners cast.
  [[nodiscard]] std::vector<Cell> divide(const std::vector<Cell>& cells) {
    std::vector<std::uint8_t> flat(cells.size());
    const auto some = [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const Cell& cell = cells[static_cast<std::size_t>(i)];
        flat[static_cast<std::size_t>(i)] = !cell.is_single() && is_flat(cell);
      }
    };
    parallel_for(0, static_cast<std::int64_t>(cells.size()), 1024, some);
    std::vector<Cell> quarters;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Cell& cell = cells[i];
      if (cell.is_single()) continue;
      if (flat[i]) {
        leaves_.push_back(cell);
        continue;
      }
      const int w = cell.w / 2, h = cell.h / 2;
      // A side of one pixel is not cut.
      for (const int bottom : {0, 1}) {
        if (bottom == 0 && h == 0) continue;
        for (const int right : {0, 1}) {
          if (right == 0 && w == 0) continue;
          const Cell quarter{cell.x + right * w, cell.y + bottom * h, right ? cell.w - w : w,
                             bottom ? cell.h - h : h};
          want_corners(quarter);
          quarters.push_back(quarter);
        }
      }
    }
    cast_wanted();
    return quarters;
  }

  /// Whether all sixteen pixels around a cell, one cell apart, were cast.
  [[nodiscard]] bool is_surrounded(const Cell& c) const {
    for (int j = -1; j <= 2; ++j) {
      for (int i = -1; i <= 2; ++i) {
        if (!is_known(c.x + i * c.w, c.y + j * c.h)) return false;
      }
    }
    return true;
  }

  /// Colour and alpha of one pixel.
  using Colour = std::array<float, kColours>;
  static void add(Colour& sum, float weight, const float* colour) {
    for (std::size_t c = 0; c < kColours; ++c) sum[c] += weight * colour[c];
  }

  void fill(const Cell& cell) {
    const bool surrounded = cell.w > 0 && cell.h > 0 && is_surrounded(cell);
    const auto place = [](int at, int size) {
      return size > 0 ? static_cast<float>(at) / static_cast<float>(size) : 0.0F;
    };
    const auto weights = [&](float t) { return surrounded ? cubic(t) : linear(t); };
    std::array<std::array<Colour, 4>, 4>
        around{};  // rows of columns; the outer ones 0 where they are not used
    for (int r = surrounded ? 0 : 1; r < (surrounded ? 4 : 3); ++r) {
      for (int c = surrounded ? 0 : 1; c < (surrounded ? 4 : 3); ++c) {
        const float* p = pixel(cell.x + (c - 1) * cell.w, cell.y + (r - 1) * cell.h);
        std::copy(p, p + kColours, around[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)].begin());
      }
    }
    const Depths depths(*this, cell);
    // Columns and rows that the next cells open are theirs.
    const int columns = std::max(1, cell.x + cell.w < image_.width - 1 ? cell.w : cell.w + 1);
    const int rows = std::max(1, cell.y + cell.h < image_.height - 1 ? cell.h : cell.h + 1);
    std::array<float, kLargestStep + 1> u;
    std::array<Weights, kLargestStep + 1> across;
    for (int i = 0; i < columns; ++i) {
      const auto n = static_cast<std::size_t>(i);
      u[n] = place(i, cell.w);
      across[n] = weights(u[n]);
    }
    for (int j = 0; j < rows; ++j) {
      const float v = place(j, cell.h);
      const Weights down = weights(v);
      std::array<Colour, 4> row{};  // of the four columns, at this row
      for (std::size_t c = 0; c < 4; ++c) {
        for (std::size_t r = 0; r < 4; ++r) add(row[c], down[r], around[r][c].data());
      }
      const DepthRow depth = depths.at(v);
      for (int i = 0; i < columns; ++i) {
        const std::size_t at = offset(cell.x + i, cell.y + j);
        if (known_[at]) continue;
        const auto n = static_cast<std::size_t>(i);
        Colour sum{};
        for (std::size_t c = 0; c < 4; ++c) add(sum, across[n][c], row[c].data());
        float* const to = image_.pixels.data() + at * image_.channels.size();
        std::copy(sum.begin(), sum.end(), to);
        to[kDepthChannel] = depth.at(u[n]);
      }
    }
  }

  /// Depth along a row of a cell, u in [0, 1].
  struct DepthRow {
    float left, right;
    bool linear;
    [[nodiscard]] float at(float u) const {
      return linear ? (1 - u) * left + u * right : u > 0.5F ? right : left;
    }
  };
  /// Depth inside a cell: bilinear where all four corners have one, else the nearest corner's.
  class Depths {
   public:
    Depths(const Refinement& of, const Cell& cell) {
      for (int b = 0; b < 2; ++b) {
        for (int a = 0; a < 2; ++a)
          corners_[2 * b + a] = of.pixel(cell.x + a * cell.w, cell.y + b * cell.h)[kDepthChannel];
      }
      bilinear_ = std::all_of(corners_, corners_ + 4, [](float depth) { return std::isfinite(depth); });
    }
    [[nodiscard]] DepthRow at(float v) const {
      const float* const nearest = corners_ + (v > 0.5F ? 2 : 0);
      if (!bilinear_) return {nearest[0], nearest[1], false};
      return {(1 - v) * corners_[0] + v * corners_[2], (1 - v) * corners_[1] + v * corners_[3], true};
    }

   private:
    float corners_[4];
    bool bilinear_;
  };

  image::Image& image_;
  float tolerance_;
  const CastPixels& cast_;
  std::vector<std::uint8_t> known_;  // cast already, or wanted
  std::vector<PixelPosition> wanted_;
  std::vector<Cell> leaves_;
};

}  // namespace

void cast_refined(image::Image& image, int step, double tolerance, const CastPixels& cast) {
  if (step < 1 || step > kLargestStep || (step & (step - 1)) != 0)
    throw Error("image step: a power of two from 1 to 64 is expected");
  if (!(tolerance >= 0)) throw Error("image tolerance is not a number >= 0");
  Refinement(image, tolerance, cast).run(step);
}

}  // namespace vol::render
