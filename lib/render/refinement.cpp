#include "render/refinement.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::render {
namespace {

constexpr int kDepthChannel = 5;
constexpr int kLargestStep = 64;

/// R, G, B and A of a pixel.
using Colour = Eigen::Array4f;

/// Corners at (x, y) and (x + w, y + h); the last cells of a row or column are smaller, down to one pixel.
struct Cell {
  std::int32_t x, y, w, h;
  [[nodiscard]] bool is_single() const { return w <= 1 && h <= 1; }
};

/// The places of pixels along a side of a cell, and what neighbours beyond its ends tell of them.
class Places {
 public:
  struct Place {
    float t;        ///< 0 at the side's beginning, 1 at its end
    float bend[4];  ///< weights of what the cubic of Catmull and Rom (1974) adds to the line
  };
  Places() {
    for (int size = 0; size <= kLargestStep; ++size) {
      for (int i = 0; i <= size; ++i) {
        const float t = size > 0 ? static_cast<float>(i) / static_cast<float>(size) : 0.0F;
        // What it adds are the second differences at the two ends, times these.
        const float begin = -0.5F * t * (1 - t) * (1 - t), end = -0.5F * t * t * (1 - t);
        places_.push_back({t, {begin, end - 2 * begin, begin - 2 * end, end}});
      }
    }
  }
  /// Those of a side `size` pixels long, size + 1 of them.
  [[nodiscard]] const Place* of_side(int size) const { return places_.data() + size * (size + 1) / 2; }

 private:
  std::vector<Place> places_;
};

const Places& all_places() {
  static const Places places;
  return places;
}

/// What a cell's pixels are made from.
enum class Made : std::uint8_t { of_quarters, of_corners, of_surroundings };

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
      for (std::int64_t i = begin; i < end; ++i) {
        const Leaf& leaf = leaves_[static_cast<std::size_t>(i)];
        leaf.surrounded ? fill<true>(leaf.cell) : fill<false>(leaf.cell);
      }
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
  /// The corners of a cell's quarters that are not its own.
  void want_middles(const Cell& c) {
    const int w = c.w / 2, h = c.h / 2;
    if (w > 0) want(c.x + w, c.y);
    if (h > 0) want(c.x, c.y + h);
    if (w > 0 && h > 0) want(c.x + w, c.y + h);
    if (h > 0) want(c.x + c.w, c.y + h);
    if (w > 0) want(c.x + w, c.y + c.h);
  }
  void cast_wanted() {
    if (!wanted_.empty()) cast_(wanted_);
    wanted_.clear();
  }

  [[nodiscard]] Colour colour(int x, int y) const { return Eigen::Map<const Colour>(pixel(x, y)); }

  /// Magnitude of the second difference through three pixels in a line, `before` and `behind` apart, for a
  /// spacing of `size`.
  static Colour bend(const Colour& a, const Colour& b, const Colour& c, int before, int behind, int size) {
    const Colour first = b - a, second = c - b;  // of finite values: never infinite of one sign
    if (before == size && behind == size) return (second - first).abs();
    const auto s = static_cast<float>(size);
    const float scale = 2 * s * s / static_cast<float>(before + behind);
    return (scale * (second / static_cast<float>(behind) - first / static_cast<float>(before))).abs();
  }

  /// The largest second differences along a side from (x, y), `size` pixels in direction (dx, dy), and its
  /// neighbours on the same line; infinite where there is none to compare with.
  [[nodiscard]] Colour side_bend(int x, int y, int dx, int dy, int size) const {
    if (size <= 1) return Colour::Zero();
    const int ex = x + size * dx, ey = y + size * dy;
    const Colour here = colour(x, y), there = colour(ex, ey);
    Colour most = Colour::Constant(-1);
    for (const int reach : {size, size + 1, size - 1}) {
      if (is_known(x - reach * dx, y - reach * dy)) {
        most = bend(colour(x - reach * dx, y - reach * dy), here, there, reach, size, size);
        break;
      }
    }
    for (const int reach : {size, size + 1, size - 1}) {
      if (is_known(ex + reach * dx, ey + reach * dy)) {
        const Colour last = bend(here, there, colour(ex + reach * dx, ey + reach * dy), size, reach, size);
        most = most.max(last);
        break;
      }
    }
    return most[0] == -1 ? Colour::Constant(INFINITY) : most;
  }

  /// Interpolation misses a kink in the middle of a cell by half of the second differences at its corners,
  /// and less where the picture is smooth.
  [[nodiscard]] bool is_flat(const Cell& c) const {
    const float across = side_bend(c.x, c.y, 1, 0, c.w).max(side_bend(c.x, c.y + c.h, 1, 0, c.w)).maxCoeff();
    if (!(across <= 2 * tolerance_)) return false;
    const float down = side_bend(c.x, c.y, 0, 1, c.h).max(side_bend(c.x + c.w, c.y, 0, 1, c.h)).maxCoeff();
    return across + down <= 2 * tolerance_;
  }

  /// Flat cells become leaves; the quarters of the others are returned, their corners cast.
  [[nodiscard]] std::vector<Cell> divide(const std::vector<Cell>& cells) {
    std::vector<Made> made(cells.size());
    const auto some = [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const Cell& cell = cells[static_cast<std::size_t>(i)];
        // Neighbours that are cast later are no part of what flatness was told by.
        made[static_cast<std::size_t>(i)] = !is_flat(cell)        ? Made::of_quarters
                                            : is_surrounded(cell) ? Made::of_surroundings
                                                                  : Made::of_corners;
      }
    };
    parallel_for(0, static_cast<std::int64_t>(cells.size()), 256, some);
    std::vector<Cell> quarters;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Cell& cell = cells[i];
      if (made[i] != Made::of_quarters) {
        leaves_.push_back({cell, made[i] == Made::of_surroundings});
        continue;
      }
      want_middles(cell);
      const int w = cell.w / 2, h = cell.h / 2;
      // A side of one pixel is not cut.
      for (const int bottom : {0, 1}) {
        if (bottom == 0 && h == 0) continue;
        for (const int right : {0, 1}) {
          if (right == 0 && w == 0) continue;
          const Cell quarter{cell.x + right * w, cell.y + bottom * h, right ? cell.w - w : w,
                             bottom ? cell.h - h : h};
          if (!quarter.is_single()) quarters.push_back(quarter);
        }
      }
    }
    cast_wanted();
    return quarters;
  }

  /// Whether the pixels one cell further on were cast, along all four sides.
  [[nodiscard]] bool is_surrounded(const Cell& c) const {
    if (c.w < 1 || c.h < 1 || c.x < c.w || c.y < c.h) return false;
    if (c.x + 2 * c.w >= image_.width || c.y + 2 * c.h >= image_.height) return false;
    const std::uint8_t* const corner = known_.data() + offset(c.x, c.y);
    const std::ptrdiff_t w = c.w, h = std::ptrdiff_t{c.h} * image_.width;
    return corner[-h] && corner[w - h] && corner[-w] && corner[2 * w] && corner[h - w] && corner[h + 2 * w] &&
           corner[2 * h] && corner[2 * h + w];
  }

  /// Interpolates between a flat cell's corners. With kSurrounded also what cubics add to lines along rows
  /// and along columns: at most an eighth of the second differences that is_flat() holds against twice the
  /// tolerance.
  template <bool kSurrounded>
  void fill(const Cell& cell) {
    constexpr int kFirst = kSurrounded ? 0 : 1, kLast = kSurrounded ? 3 : 2;
    Colour around[4][4];  // rows of columns, without the corners
    Colour most = Colour::Zero();
    for (int r = kFirst; r <= kLast; ++r) {
      for (int c = kFirst; c <= kLast; ++c) {
        if ((r == 0 || r == 3) && (c == 0 || c == 3)) continue;
        around[r][c] = colour(cell.x + (c - 1) * cell.w, cell.y + (r - 1) * cell.h);
        most = most.max(around[r][c].abs());
      }
    }
    const Depths depths(*this, cell);
    if ((most == 0).all() && depths.none()) return;  // blank already
    const Places::Place* const across = places_.of_side(cell.w);
    const Places::Place* const down = places_.of_side(cell.h);
    // Columns and rows that the next cells open are theirs.
    const int columns = std::max(1, cell.x + cell.w < image_.width - 1 ? cell.w : cell.w + 1);
    const int rows = std::max(1, cell.y + cell.h < image_.height - 1 ? cell.h : cell.h + 1);
    for (int j = 0; j < rows; ++j) {
      const Places::Place& v = down[j];
      Colour row[4];  // of the columns: lines between the cell's rows
      for (int c = kFirst; c <= kLast; ++c) row[c] = (1 - v.t) * around[1][c] + v.t * around[2][c];
      Colour left = row[1], right = row[2];  // and their bends, of the cell's own
      for (int r = kFirst; kSurrounded && r <= kLast; ++r) {
        left += v.bend[r] * around[r][1];
        right += v.bend[r] * around[r][2];
      }
      const DepthRow depth = depths.at(v.t);
      const std::size_t begin = offset(cell.x, cell.y + j);
      for (int i = 0; i < columns; ++i) {
        const std::size_t at = begin + static_cast<std::size_t>(i);
        if (known_[at]) continue;
        const Places::Place& u = across[i];
        Colour sum = (1 - u.t) * left + u.t * right;
        for (int c = kFirst; kSurrounded && c <= kLast; ++c) sum += u.bend[c] * row[c];
        float* const to = image_.pixels.data() + at * image_.channels.size();
        Eigen::Map<Colour>{to} = sum;
        to[kDepthChannel] = depth.at(u.t);
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
    /// Whether the cell's corners show nothing that has one.
    [[nodiscard]] bool none() const {
      return std::all_of(corners_, corners_ + 4, [](float depth) { return depth == INFINITY; });
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

  const Places& places_ = all_places();
  image::Image& image_;
  float tolerance_;
  const CastPixels& cast_;
  std::vector<std::uint8_t> known_;  // cast already, or wanted
  std::vector<PixelPosition> wanted_;
  struct Leaf {
    Cell cell;
    bool surrounded;
  };
  std::vector<Leaf> leaves_;
};

}  // namespace

void cast_refined(image::Image& image, int step, double tolerance, const CastPixels& cast) {
  if (step < 1 || step > kLargestStep || (step & (step - 1)) != 0)
    throw Error("image step: a power of two from 1 to 64 is expected");
  if (!(tolerance >= 0)) throw Error("image tolerance is not a number >= 0");
  Refinement(image, tolerance, cast).run(step);
}

}  // namespace vol::render
