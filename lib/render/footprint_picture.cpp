#include "render/footprint_picture.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace vol::render {
namespace {

constexpr int kBlockRows = 32;

/// Columns x of a row with low <= a + b x <= high.
PixelRun columns_within(PixelRun run, double a, double b, double low, double high) {
  if (b == 0) return a >= low && a <= high ? run : PixelRun{};
  const double s = (low - a) / b, t = (high - a) / b;
  return {std::max(run.begin, ceil_pixel(std::min(s, t))),
          std::min(run.end, floor_pixel(std::max(s, t)) + 1)};
}

/// +1 where the rectangle of a term's footprint begins in a row, -1 behind its end.
void count_reach(const FootprintPart& part, int width, int first, int count, std::int64_t stride,
                 std::int32_t* ends) {
  for (const auto& term : part.terms()) {
    const auto p = part.centre_of(term);
    const auto& reach = part.reach;
    const int begin = std::max(ceil_pixel(p[0] + reach[0]), 0),
              end = std::min(floor_pixel(p[0] + reach[1]) + 1, width);
    const int top = std::max(ceil_pixel(p[1] + reach[2]), first);
    const int bottom = std::min(floor_pixel(p[1] + reach[3]) + 1, first + count);
    for (int y = top; y < bottom && begin < end; ++y) {
      ++ends[(y - first) * stride + begin];
      --ends[(y - first) * stride + end];
    }
  }
}

}  // namespace

FootprintPicture::FootprintPicture(const wavelet::Expansion& e, const camera::View& seen, int w, int h)
    : expansion(e), width(w), height(h), view(e.geometry(), seen, w, h), xray(e) {
  rays.resize(static_cast<std::size_t>(height));
  parallel_for(0, height, 8, [&](std::int64_t from, std::int64_t to) {
    for (auto y = from; y < to; ++y) view.row(static_cast<int>(y), rays[static_cast<std::size_t>(y)]);
  });
  std::vector<std::array<int, 2>> beside;
  for (std::size_t which = 0; which < 2; ++which) {
    for (std::size_t a = 0; a < 3; ++a) {
      auto& rows = windows.rows[which][a];
      rows.assign(rays.size(), {0, 0});
      for (std::size_t y = 0; y < rays.size(); ++y) {
        const auto& face = rays[y].face[which];
        for (int x = 0; x < width; ++x) {
          if (face[static_cast<std::size_t>(x)] != static_cast<int>(a)) continue;
          PixelRun& run = rows[y];
          if (run.begin == run.end) {
            run = {x, x + 1};
          } else if (run.end == x) {
            run.end = x + 1;
          } else {  // a face is convex: along an edge of the box rounding let another one in
            beside.push_back({x, static_cast<int>(y)});
          }
        }
        windows.pixels[which][a] += rows[y].end - rows[y].begin;
      }
    }
  }
  draw_exactly(beside);
}

void FootprintPicture::draw_exactly(const std::vector<std::array<int, 2>>& pixels) {
  exact_pixels.insert(exact_pixels.end(), pixels.begin(), pixels.end());
  std::sort(exact_pixels.begin(), exact_pixels.end());
  exact_pixels.erase(std::unique(exact_pixels.begin(), exact_pixels.end()), exact_pixels.end());
}

/// Some rows of the picture in the making: first .. first + count - 1, a stride apart.
struct FootprintPicture::Rows {
  int first = 0, count = 0;
  std::int64_t stride = 0;
  double* values = nullptr;
  std::int32_t* ends = nullptr;  ///< if given, +1 where a footprint begins in a row, -1 behind its end
};

/// A part without planes: each pixel looks into the table.
void FootprintPicture::add_look_ups(const FootprintGroup& group, const FootprintPart& part,
                                    const Rows& rows) const {
  const auto& table = group.tables[part.table];
  const auto& m = part.matrix;
  const auto& reach = part.reach;
  const std::vector<PixelRun>* window =
      part.cut < 0 ? nullptr
                   : &windows.rows[static_cast<std::size_t>(part.cut)][static_cast<std::size_t>(group.axis)];
  for (const auto& term : part.terms()) {
    const auto [column, row] = part.centre_of(term);
    const int low = std::max(rows.first, ceil_pixel(row + reach[2]));
    for (int y = low; y < rows.first + rows.count && y <= row + reach[3]; ++y) {
      const double j = y - row;
      PixelRun run =
          columns_within(window == nullptr ? PixelRun{0, width} : (*window)[static_cast<std::size_t>(y)],
                         -column, 1, reach[0], reach[1]);
      for (std::size_t c = 0; c < 2; ++c) {
        const double at = part.centre[c] + m[c][1] * j - m[c][0] * column;
        run =
            columns_within(run, at, m[c][0], c == 0 ? table.x0 : table.y0, c == 0 ? table.x1() : table.y1());
      }
      for (int x = run.begin; x < run.end; ++x) {
        const double i = x - column;
        rows.values[(y - rows.first) * rows.stride + x] +=
            term.c * part.amplitude *
            table.value(part.centre[0] + m[0][0] * i + m[0][1] * j,
                        part.centre[1] + m[1][0] * i + m[1][1] * j);
      }
    }
  }
}

/// A cut without tables: from the chord's end to behind all that a term reaches.
void FootprintPicture::add_exact_cuts(const FootprintGroup& group, const FootprintPart& part,
                                      const Rows& rows) const {
  const auto& window = windows.rows[static_cast<std::size_t>(part.cut)][static_cast<std::size_t>(group.axis)];
  const auto& reach = part.reach;
  const Vec3& d = view.direction();
  const double beyond =
      4 * part.band->scale[group.axis] * (part.band->upper - part.band->lower).sum() / d.norm();
  for (const auto& term : part.terms()) {
    const auto p = part.centre_of(term);
    const int low = std::max(rows.first, ceil_pixel(p[1] + reach[2]));
    for (int y = low; y < rows.first + rows.count && y <= p[1] + reach[3]; ++y) {
      const PixelRun run = columns_within(window[static_cast<std::size_t>(y)], -p[0], 1, reach[0], reach[1]);
      const PixelRow& ray = rays[static_cast<std::size_t>(y)];
      for (int x = run.begin; x < run.end; ++x) {
        const auto i = static_cast<std::size_t>(x);
        const Vec3 middle(ray.middle[0][i], ray.middle[1][i], ray.middle[2][i]);
        const double begin = part.cut == 0 ? -ray.half[i] - beyond : ray.half[i];
        const double end = part.cut == 0 ? -ray.half[i] : ray.half[i] + beyond;
        rows.values[(y - rows.first) * rows.stride + x] -=
            wavelet::line_integral(expansion, *part.band, term, middle, d, begin, end);
      }
    }
  }
}

/// All but splats and exact bands.
void FootprintPicture::add_without_planes(const Rows& rows) const {
  for (const auto& group : groups) {
    for (const auto& part : group.parts) {
      if (rows.ends != nullptr && part.cut < 0) {
        count_reach(part, width, rows.first, rows.count, rows.stride, rows.ends);
      }
      if (group.exact) {
        add_exact_cuts(group, part, rows);
      } else if (!part.phases) {
        add_look_ups(group, part, rows);
      }
    }
  }
  for (const auto& level : cells) {
    add_cells(level, view, rays, rows.first, rows.count, rows.stride, rows.values, rows.ends);
  }
  if (products) products->add(rays, rows.first, rows.count, rows.stride, rows.values, rows.ends);
}

std::vector<double> FootprintPicture::values(std::vector<std::int32_t>* met) const {
  auto picture = sum_of_splats(groups, windows, width, height, in_float);
  if (met != nullptr) met->assign(picture.size(), 0);
  const std::int64_t blocks = (height + kBlockRows - 1) / kBlockRows;
  parallel_for(0, blocks, 1, [&](std::int64_t from_block, std::int64_t to_block) {
    for (auto block = from_block; block < to_block; ++block) {
      Rows rows{static_cast<int>(block) * kBlockRows, 0, std::int64_t{width} + kFootprintPadding, nullptr,
                nullptr};
      rows.count = std::min(kBlockRows, height - rows.first);
      std::vector<double> other(static_cast<std::size_t>(rows.stride * rows.count));
      std::vector<std::int32_t> ends(met != nullptr ? other.size() : 0);
      rows.values = other.data();
      if (met != nullptr) rows.ends = ends.data();
      add_without_planes(rows);
      for (int y = 0; y < rows.count; ++y) {
        std::int32_t cover = 0;
        for (int x = 0; x < width; ++x) {
          const auto at = static_cast<std::size_t>(y * rows.stride + x);
          const auto out = static_cast<std::size_t>(rows.first + y) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(x);
          if (met != nullptr) cover += ends[at];
          if (misses(x, rows.first + y)) {
            picture[out] = 0;
            continue;
          }
          if (met != nullptr) (*met)[out] = cover;
          picture[out] += other[at];
          if (exact_bands.empty()) continue;
          const auto cast = view.cast(x, rows.first + y);
          std::int64_t terms = 0, pieces = 0;
          picture[out] += xray.integral(cast->ray, cast->chord, exact_bands, terms, pieces);
          if (met != nullptr) (*met)[out] += static_cast<std::int32_t>(terms);
        }
      }
    }
  });
  parallel_for(0, static_cast<std::int64_t>(exact_pixels.size()), 1, [&](std::int64_t from, std::int64_t to) {
    for (auto n = from; n < to; ++n) {
      const auto [x, y] = exact_pixels[static_cast<std::size_t>(n)];
      const auto cast = view.cast(x, y);
      std::int64_t terms = 0, more = 0;
      const auto out =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      picture[out] = xray.integral(cast->ray, cast->chord, terms, more);
      if (met != nullptr) (*met)[out] = static_cast<std::int32_t>(terms);
    }
  });
  return picture;
}

}  // namespace vol::render
