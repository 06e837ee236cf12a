#include "render/refinement.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::render {
namespace {

constexpr int kDepthChannel = 5;

/// Corners at (x, y) and (x + w, y + h); the last cells of a row or column are smaller, down to one pixel.
struct Cell {
  std::int32_t x, y, w, h;
  [[nodiscard]] bool is_single() const { return w <= 1 && h <= 1; }
  /// Nodes 0, 1, 2 of a side: its ends and its middle.
  [[nodiscard]] std::int32_t node_x(int i) const { return i == 0 ? x : i == 1 ? x + w / 2 : x + w; }
  [[nodiscard]] std::int32_t node_y(int j) const { return j == 0 ? y : j == 1 ? y + h / 2 : y + h; }
};

/// The centre of a cell and the middles of its sides.
constexpr std::pair<int, int> kMiddles[] = {{1, 1}, {1, 0}, {0, 1}, {2, 1}, {1, 2}};

class Refinement {
 public:
  Refinement(image::Image& image, double tolerance, const CastPixels& cast)
      : image_(image),
        tolerance_(tolerance),
        cast_(cast),
        known_(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {}

  void run(int step) {
    std::vector<Cell> cells = first_cells(step);
    for (const Cell& cell : cells) want_corners(cell);
    while (!cells.empty()) {
      for (const Cell& cell : cells) {
        if (!cell.is_single()) want_middles(cell);
      }
      cast_wanted();
      cells = divide(cells);
    }
    parallel_for(0, static_cast<std::int64_t>(leaves_.size()), 256,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t i = begin; i < end; ++i) fill(leaves_[static_cast<std::size_t>(i)]);
                 });
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
  void want_middles(const Cell& c) {
    for (const auto& [i, j] : kMiddles) want(c.node_x(i), c.node_y(j));
  }
  void cast_wanted() {
    if (!wanted_.empty()) cast_(wanted_);
    wanted_.clear();
  }

  [[nodiscard]] double node(const Cell& cell, int i, int j, int channel) const {
    return double(image_.at(cell.node_x(i), cell.node_y(j), channel));
  }
  [[nodiscard]] double bilinear(const Cell& cell, int x, int y, int channel) const {
    const double u = cell.w > 0 ? double(x - cell.x) / cell.w : 0,
                 v = cell.h > 0 ? double(y - cell.y) / cell.h : 0;
    const auto at = [&](int i, int j) { return node(cell, 2 * i, 2 * j, channel); };
    return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
  }

  /// Weights of the three nodes of a side, of length n, at a pixel: the parabola through them, a line for n
  /// = 1.
  struct Weights {
    double w[3];
    Weights(int at, int n) {
      const double x = at, m = n / 2, e = n;
      if (n <= 1) {
        w[0] = n == 0 ? 1 : 1 - x;
        w[1] = 0;
        w[2] = n == 0 ? 0 : x;
      } else {
        w[0] = (x - m) * (x - e) / (m * e);
        w[1] = x * (x - e) / (m * (m - e));
        w[2] = x * (x - m) / (e * (e - m));
      }
    }
  };
  [[nodiscard]] double biquadratic(const Cell& cell, int x, int y, int channel) const {
    const Weights across(x - cell.x, cell.w), down(y - cell.y, cell.h);
    double sum = 0;
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        const double weight = across.w[i] * down.w[j];
        if (weight != 0) sum += weight * node(cell, i, j, channel);
      }
    }
    return sum;
  }

  [[nodiscard]] bool is_flat(const Cell& cell) const {
    for (const auto& [i, j] : kMiddles) {
      const int x = cell.node_x(i), y = cell.node_y(j);
      for (int c = 0; c < 4; ++c) {
        if (!(std::abs(bilinear(cell, x, y, c) - double(image_.at(x, y, c))) <= tolerance_)) return false;
      }
    }
    return true;
  }

  /// Flat cells become leaves; the quarters of the others are returned, their corners wanted.
  [[nodiscard]] std::vector<Cell> divide(const std::vector<Cell>& cells) {
    std::vector<Cell> quarters;
    for (const Cell& cell : cells) {
      if (cell.is_single()) continue;
      if (is_flat(cell)) {
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
    return quarters;
  }

  void fill(const Cell& cell) {
    for (int y = cell.y; y <= cell.y + cell.h; ++y) {
      for (int x = cell.x; x <= cell.x + cell.w; ++x) {
        if (known_[offset(x, y)]) continue;
        // A pixel on the border of two cells belongs to the one it opens.
        const bool closes =
            (x == cell.x + cell.w && x < image_.width - 1) || (y == cell.y + cell.h && y < image_.height - 1);
        if (closes) continue;
        for (int c = 0; c < 4; ++c) image_.at(x, y, c) = static_cast<float>(biquadratic(cell, x, y, c));
        const double depth = bilinear(cell, x, y, kDepthChannel);
        const int near_x = 2 * (x - cell.x) > cell.w ? cell.x + cell.w : cell.x;
        const int near_y = 2 * (y - cell.y) > cell.h ? cell.y + cell.h : cell.y;
        image_.at(x, y, kDepthChannel) =
            std::isfinite(depth) ? static_cast<float>(depth) : image_.at(near_x, near_y, kDepthChannel);
      }
    }
  }

  image::Image& image_;
  double tolerance_;
  const CastPixels& cast_;
  std::vector<std::uint8_t> known_;  // cast already, or wanted
  std::vector<PixelPosition> wanted_;
  std::vector<Cell> leaves_;
};

}  // namespace

void cast_refined(image::Image& image, int step, double tolerance, const CastPixels& cast) {
  if (step < 1 || step > 64 || (step & (step - 1)) != 0)
    throw Error("image step: a power of two from 1 to 64 is expected");
  if (!(tolerance >= 0)) throw Error("image tolerance is not a number >= 0");
  Refinement(image, tolerance, cast).run(step);
}

}  // namespace vol::render
