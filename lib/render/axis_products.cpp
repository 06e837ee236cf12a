#include "render/axis_products.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "render/footprint_kernel.h"
#include "render/picture_tiles.h"
#include "wavelet/footprint.h"

namespace vol::render {
namespace {

struct Bounds {
  double value = 0, slope = 0;
};
/// Of |f| and |f'|, by the coefficients of its pieces.
Bounds bounds_of(const wavelet::PiecewiseCubic& f) {
  Bounds b;
  for (const auto& a : f.pieces) {
    b.value = std::max(b.value, std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]) + std::abs(a[3]));
    b.slope = std::max(b.slope, (std::abs(a[1]) + 2 * std::abs(a[2]) + 3 * std::abs(a[3])) / f.spacing);
  }
  return b;
}

}  // namespace

std::optional<AxisProducts> AxisProducts::make(const wavelet::Expansion& expansion, const ParallelView& view,
                                               const std::vector<PixelRow>& rays, double allowed) {
  AxisProducts result;
  result.width_ = view.width();
  result.direction_ = view.direction();
  const Vec3& d = view.direction();
  d.cwiseAbs().maxCoeff(&result.axis_);
  const int a = result.axis_, across[2] = {(a + 1) % 3, (a + 2) % 3};
  const auto number = [](int axis) { return static_cast<std::size_t>(axis); };
  const PictureTiles tiles(view.width(), view.height());
  auto sums = tiles.none();
  // First what they would be off by, then, if that is little enough, the items: of most views there are none.
  for (const bool keep : {false, true}) {
    for (const auto& band : expansion.bands()) {
      const auto& f = expansion.function(band.factor[number(a)]);
      // How far, in units of the other functions, a ray moves within half the support.
      double error = 0;
      const Bounds along = bounds_of(f);
      for (int i = 0; i < 2; ++i) {
        const int b = across[i], c = across[1 - i];
        const double moved =
            std::abs(d[b] / d[a]) * 0.5 * (f.upper() - f.lower) * band.scale[a] / band.scale[b];
        if (moved <= 1e-12) continue;
        const auto& g = expansion.function(band.factor[number(b)]);
        if (!wavelet::continuous(g)) return std::nullopt;
        error += moved * bounds_of(g).slope * bounds_of(expansion.function(band.factor[number(c)])).value;
      }
      const double length = band.scale[a] / std::abs(d[a]);
      error *= along.value * (f.upper() - f.lower) * length;

      std::map<std::int32_t, double> integrals;
      const double from = (std::min(view.face(0, a), view.face(1, a)) + band.shift[a]) / band.scale[a];
      const double to = (std::max(view.face(0, a), view.face(1, a)) + band.shift[a]) / band.scale[a];
      for (const auto& term : band.terms) {
        const auto k = term.k[number(a)];
        const auto [at, fresh] = integrals.try_emplace(k, 0.0);
        if (fresh) at->second = wavelet::integral(f, from - k, to - k);
        Item item{&band, &term, {}, term.c * at->second * length, 0, {}};
        Vec3 middle = 0.5 * (band.lower + band.upper);
        for (int i = 0; i < 3; ++i)
          middle[i] = (middle[i] + term.k[number(i)]) * band.scale[i] - band.shift[i];
        item.plane = middle[a];
        const auto p = view.pixel(middle);
        double columns = 0, rows = 0;  // to the corners of the two supports
        for (std::size_t i = 0; i < 2; ++i) {
          const int b = across[i];
          item.factor[i] = &expansion.function(band.factor[number(b)]);
          const auto edge =
              view.pixel(middle + 0.5 * (band.upper[b] - band.lower[b]) * band.scale[b] * Vec3::Unit(b));
          columns += std::abs(edge[0] - p[0]);
          rows += std::abs(edge[1] - p[1]);
        }
        item.reach = {p[0] - columns, p[0] + columns, p[1] - rows, p[1] + rows};
        if (keep) {
          result.items_.push_back(item);
        } else if (error > 0) {
          tiles.visit(item.reach[0], item.reach[1], item.reach[2], item.reach[3],
                      [&](std::size_t tile, double) { sums[tile].one += std::abs(term.c) * error; });
        }
      }
    }
    if (keep) break;
    for (const auto& sum : sums) result.estimate_ = std::max(result.estimate_, sum.one);
    if (result.estimate_ > allowed) return std::nullopt;
  }

  for (std::size_t y = 0; y < rays.size(); ++y) {
    for (std::size_t x = 0; x < rays[y].half.size(); ++x) {
      if (rays[y].half[x] < 0) continue;
      result.hit_column_ = static_cast<int>(x);
      result.hit_row_ = static_cast<int>(y);
    }
  }
  // Index-space displacement over the whole picture, at a fixed place on the axis.
  const auto moves = [&](const Vec3& pixel, int b, int pixels) {
    return std::abs(pixel[b] - d[b] * pixel[a] / d[a]) * pixels > 1e-11;
  };
  for (std::size_t i = 0; i < 2; ++i) {
    const bool tilted = std::abs(d[across[i]] / d[a]) > 1e-14;
    if (tilted || moves(view.down(), across[i], view.height()) ||
        moves(view.right(), across[1 - i], view.width())) {
      continue;
    }
    result.columns_ = i;
  }
  return result;
}

double AxisProducts::factor_at(const Item& item, std::size_t which, const PixelRow& row,
                               std::size_t x) const {
  const auto i = static_cast<std::size_t>((axis_ + 1 + static_cast<int>(which)) % 3);
  const auto b = static_cast<Eigen::Index>(i);
  double place = row.middle[i][x];
  if (direction_[b] != 0) {
    place +=
        direction_[b] / direction_[axis_] * (item.plane - row.middle[static_cast<std::size_t>(axis_)][x]);
  }
  return item.factor[which]->value((place + item.band->shift[b]) / item.band->scale[b], item.term->k[i]);
}

void AxisProducts::add(const std::vector<PixelRow>& rays, int first, int count, std::int64_t stride,
                       double* values, std::int32_t* met) const {
  std::vector<double> across(static_cast<std::size_t>(width_));
  constexpr double kRounding = 1e-6;  // of a pixel
  for (const Item& item : items_) {
    const int begin = std::max(ceil_pixel(item.reach[0] - kRounding), 0);
    const int end = std::min(floor_pixel(item.reach[1] + kRounding) + 1, width_);
    const int top = std::max(ceil_pixel(item.reach[2] - kRounding), first);
    const int bottom = std::min(floor_pixel(item.reach[3] + kRounding) + 1, first + count);
    if (begin >= end || top >= bottom) continue;
    if (columns_ < 2) {
      for (int x = begin; x < end; ++x) {
        const auto i = static_cast<std::size_t>(x);
        across[i] = factor_at(item, columns_, rays[static_cast<std::size_t>(hit_row_)], i);
      }
    }
    for (int y = top; y < bottom; ++y) {
      const PixelRow& row = rays[static_cast<std::size_t>(y)];
      double* out = values + (y - first) * stride;
      if (met != nullptr) {
        ++met[(y - first) * stride + begin];
        --met[(y - first) * stride + end];
      }
      if (columns_ < 2) {
        const double down =
            item.amplitude * factor_at(item, 1 - columns_, row, static_cast<std::size_t>(hit_column_));
        if (down == 0) continue;
        for (int x = begin; x < end; ++x) out[x] += down * across[static_cast<std::size_t>(x)];
        continue;
      }
      for (int x = begin; x < end; ++x) {
        const auto i = static_cast<std::size_t>(x);
        if (row.half[i] < 0) continue;
        out[x] += item.amplitude * factor_at(item, 0, row, i) * factor_at(item, 1, row, i);
      }
    }
  }
}

}  // namespace vol::render
