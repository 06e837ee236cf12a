#include "render/octant_cells.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace vol::render {
namespace {

/// 0: constant 1; 1: 1, then -1 on the second half; -1: another function.
int haar_kind(const wavelet::PiecewiseCubic& f) {
  const auto constant = [&](std::size_t i, double value) {
    return f.pieces[i] == std::array<double, 4>{value, 0, 0, 0};
  };
  if (f.pieces.size() == 1 && constant(0, 1)) return 0;
  return f.pieces.size() == 2 && constant(0, 1) && constant(1, -1) ? 1 : -1;
}

}  // namespace

bool is_haar(const wavelet::Expansion& expansion) {
  return std::all_of(expansion.bands().begin(), expansion.bands().end(), [&](const wavelet::Band& band) {
    return std::all_of(band.factor.begin(), band.factor.end(),
                       [&](int f) { return haar_kind(expansion.function(f)) >= 0; });
  });
}

std::vector<OctantCells> make_octant_cells(const wavelet::Expansion& expansion) {
  std::map<int, std::vector<const wavelet::Band*>> levels;
  for (const auto& band : expansion.bands()) levels[band.level].push_back(&band);
  std::vector<OctantCells> result;
  for (const auto& [number, bands] : levels) {
    OctantCells& all = result.emplace_back();
    for (std::size_t a = 0; a < 3; ++a) {
      const auto i = static_cast<Eigen::Index>(a);
      all.level.scale[a] = bands[0]->scale[i];
      all.level.shift[a] = bands[0]->shift[i];
      all.level.lower[a] = bands[0]->lower[i];
      all.level.upper[a] = bands[0]->upper[i];
    }
    struct Entry {
      wavelet::Term term;
      std::array<int, 3> detail;
    };
    std::vector<Entry> entries;
    for (const wavelet::Band* band : bands) {
      std::array<int, 3> detail{};
      for (std::size_t a = 0; a < 3; ++a) detail[a] = haar_kind(expansion.function(band->factor[a]));
      for (const wavelet::Term& term : band->terms) entries.push_back({term, detail});
    }
    // Neighbours in the picture's memory are neighbours here; equal places keep the bands' order.
    std::stable_sort(entries.begin(), entries.end(), [](const Entry& s, const Entry& t) {
      return std::tie(s.term.k[1], s.term.k[2], s.term.k[0]) <
             std::tie(t.term.k[1], t.term.k[2], t.term.k[0]);
    });
    for (std::size_t i = 0; i < entries.size();) {
      OctantCell& cell = all.cells.emplace_back();
      cell.halves.fill(1);
      const auto& k = entries[i].term.k;
      for (std::size_t a = 0; a < 3; ++a) cell.k[a] = k[a];
      for (; i < entries.size() && entries[i].term.k == k; ++i) {
        const Entry& e = entries[i];
        for (std::size_t a = 0; a < 3; ++a) cell.halves[a] = std::max(cell.halves[a], 1 + e.detail[a]);
        for (std::size_t octant = 0; octant < 8; ++octant) {
          bool minus = false;
          for (std::size_t a = 0; a < 3; ++a) minus ^= e.detail[a] == 1 && (octant >> a & 1) != 0;
          cell.value[octant] += minus ? -e.term.c : e.term.c;
        }
      }
    }
  }
  return result;
}

void add_cells(const OctantCells& all, const ParallelView& view, const std::vector<PixelRow>& rays, int first,
               int count, std::int64_t stride, double* values, std::int32_t* met) {
  const OctantLevel& level = all.level;
  const auto pixel = [&](const std::array<double, 3>& u) {
    Vec3 p;
    for (std::size_t a = 0; a < 3; ++a)
      p[static_cast<Eigen::Index>(a)] = level.scale[a] * u[a] - level.shift[a];
    return view.pixel(p);
  };
  const auto origin = pixel({0, 0, 0});
  std::array<std::array<double, 2>, 3> step{};
  std::array<double, 2> low = {0, 0}, high = {0, 0};  // of a cell's pixels, from the place of its k
  for (std::size_t a = 0; a < 3; ++a) {
    std::array<double, 3> unit{};
    unit[a] = 1;
    const auto moved = pixel(unit);
    for (std::size_t i = 0; i < 2; ++i) {
      step[a][i] = moved[i] - origin[i];
      low[i] += std::min(step[a][i] * level.lower[a], step[a][i] * level.upper[a]);
      high[i] += std::max(step[a][i] * level.lower[a], step[a][i] * level.upper[a]);
    }
  }
  constexpr double kRounding = 1e-6;  // of a pixel
  std::array<double, 3> direction{};
  for (std::size_t a = 0; a < 3; ++a) direction[a] = view.direction()[static_cast<Eigen::Index>(a)];
  for (const OctantCell& cell : all.cells) {
    std::array<double, 2> p = origin;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < 2; ++i) p[i] += step[a][i] * cell.k[a];
    }
    const auto from = [&](std::size_t i, int least) {
      return std::max(ceil_pixel(p[i] + low[i] - kRounding), least);
    };
    const auto to = [&](std::size_t i, int end) {
      return std::min(floor_pixel(p[i] + high[i] + kRounding) + 1, end);
    };
    const int begin = from(0, 0), end = to(0, view.width());
    if (begin >= end) continue;
    for (int y = from(1, first); y < to(1, first + count); ++y) {
      const PixelRow& ray = rays[static_cast<std::size_t>(y)];
      const RayRow row{
          {ray.middle[0].data(), ray.middle[1].data(), ray.middle[2].data()}, ray.half.data(), direction};
      add_octants(cell, level, row, begin, end, values + (y - first) * stride);
      if (met != nullptr) {
        ++met[(y - first) * stride + begin];
        --met[(y - first) * stride + end];
      }
    }
  }
}

}  // namespace vol::render
