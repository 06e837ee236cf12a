#include "render/footprint_part.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/rng.h"
#include "render/footprint_taps.h"

namespace vol::render {
namespace {

std::size_t other(int axis, int which) {
  return static_cast<std::size_t>((axis + which) % 3);
}

/// Support of a part's function in u, cut off at its limit.
Box3 support(const FootprintPart& part, int axis, bool below) {
  Box3 box{part.band->lower, part.band->upper};
  if (part.cut >= 0) (below ? box.max : box.min)[axis] = part.limit;
  return box;
}

int phase_count(const FootprintPart& part, std::size_t direction, double step) {
  const double across = std::max(std::abs(part.matrix[0][direction]), std::abs(part.matrix[1][direction]));
  return static_cast<int>(std::clamp(std::ceil(across / step), 1.0, 4096.0));
}

/// How phases are sampled: cubic ones twice as far apart have the error of linear ones. They
/// take four times the additions a pixel, of a quarter of the memory, which counts more where planes are read
/// once.
struct Sampling {
  double step;
  Taps taps;
};
Sampling sampling(const FootprintPart& part, const FootprintQuality& quality) {
  if (quality.taps == Taps::cubic) return {quality.step, quality.taps};
  const double places =
      static_cast<double>(phase_count(part, 0, quality.step)) * phase_count(part, 1, quality.step);
  if (static_cast<double>(part.terms().size()) > 4 * places) return {quality.step, Taps::linear};
  return {2 * quality.step, Taps::cubic};
}

struct Window {
  int first_column, first_row, columns, rows;
};
/// Pixels n with n - place in reach, for places in [0, 1).
Window window(const FootprintPart& part) {
  const int column = ceil_pixel(part.reach[0]), row = ceil_pixel(part.reach[2]);
  return {column, row, floor_pixel(part.reach[1]) + 2 - column, floor_pixel(part.reach[3]) + 2 - row};
}

/// Values of all phases.
double phase_values(const FootprintPart& part, double step) {
  const Window w = window(part);
  return static_cast<double>(phase_count(part, 0, step)) * phase_count(part, 1, step) * (w.columns + 12.0) *
         (w.rows + 4.0);
}

/// Few terms look into the table themselves.
bool wants_phases(const FootprintPart& part, const FootprintQuality& quality) {
  const double step = sampling(part, quality).step;
  const double places = static_cast<double>(phase_count(part, 0, step)) * phase_count(part, 1, step);
  return static_cast<double>(part.terms().size()) > 0.05 * places;
}

void make_runs(FootprintPhases& phases, double negligible) {
  float largest = 0;
  for (const float v : phases.values) largest = std::max(largest, std::abs(v));
  const auto least = static_cast<float>(negligible) * largest;
  const std::int64_t plane = phases.stride * (phases.rows + 2 * kRowMargin);
  const int planes = phases.column_phases * phases.row_phases;
  phases.runs.assign(static_cast<std::size_t>(phases.rows), {phases.columns, 0});
  for (int p = 0; p < planes; ++p) {
    for (int row = 0; row < phases.rows; ++row) {
      const float* line =
          phases.values.data() + p * plane + (row + kRowMargin) * phases.stride + kColumnMargin;
      auto& run = phases.runs[static_cast<std::size_t>(row)];
      for (int i = 0; i < run.begin && i < phases.columns; ++i) {
        if (std::abs(line[i]) > least) run.begin = i;
      }
      for (int i = phases.columns; i > run.end && i > 0; --i) {
        if (std::abs(line[i - 1]) > least) run.end = i;
      }
    }
  }
  int longest = 0;
  for (auto& run : phases.runs) {
    if (run.begin >= run.end) run = {0, 0};
    longest = std::max(longest, run.end - run.begin);
  }
  phases.chunk = longest <= 8 ? 8 : 16;
  for (const auto& run : phases.runs) {
    const int count = (run.end - run.begin + phases.chunk - 1) / phases.chunk;
    // What is beyond the columns on the left is margin, that on the right too, up to the stride.
    const int last = static_cast<int>(phases.stride) - 2 * kColumnMargin - count * phases.chunk;
    phases.chunks.push_back({std::min(run.begin, last), count});
  }
}

FootprintPhases make_phases(const FootprintPart& part, const wavelet::FootprintTable& table,
                            const FootprintQuality& quality, double negligible) {
  FootprintPhases phases;
  const Sampling samples = sampling(part, quality);
  phases.taps = samples.taps;
  phases.column_phases = phase_count(part, 0, samples.step);
  phases.row_phases = phase_count(part, 1, samples.step);
  const Window w = window(part);
  phases.first_column = w.first_column;
  phases.first_row = w.first_row;
  phases.columns = w.columns;
  phases.rows = w.rows;
  phases.stride = (w.columns <= 8 ? 8 : (w.columns + 15) / 16 * 16) + 2 * kColumnMargin;
  const std::int64_t plane = phases.stride * (w.rows + 2 * kRowMargin);
  phases.values.assign(
      static_cast<std::size_t>(plane * phases.column_phases * phases.row_phases + kFootprintPadding), 0.0F);
  const auto& m = part.matrix;
  parallel_for(0, phases.row_phases, 1, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t q = from; q < to; ++q) {
      for (int p = 0; p < phases.column_phases; ++p) {
        float* out = phases.values.data() + (q * phases.column_phases + p) * plane;
        for (int row = 0; row < w.rows; ++row) {
          const double j = w.first_row + row - static_cast<double>(q) / phases.row_phases;
          float* line = out + (row + kRowMargin) * phases.stride + kColumnMargin;
          // Columns that can lie in the table.
          double low = 0, high = w.columns - 1;
          const double shift = static_cast<double>(p) / phases.column_phases - w.first_column;
          for (std::size_t c = 0; c < 2; ++c) {
            const double at = part.centre[c] + m[c][1] * j - m[c][0] * shift;
            const double least = c == 0 ? table.x0 : table.y0, most = c == 0 ? table.x1() : table.y1();
            if (m[c][0] == 0) continue;
            const double s = (least - at) / m[c][0], t = (most - at) / m[c][0];
            low = std::max(low, std::min(s, t));
            high = std::min(high, std::max(s, t));
          }
          for (int column = low <= high ? static_cast<int>(std::ceil(low)) : w.columns; column <= high;
               ++column) {
            const double i = column - shift;
            line[column] = static_cast<float>(table.value(part.centre[0] + m[0][0] * i + m[0][1] * j,
                                                          part.centre[1] + m[1][0] * i + m[1][1] * j));
          }
        }
      }
    }
  });
  make_runs(phases, negligible);
  return phases;
}

/// Deviation of what is drawn from the truth, at lines through random places of the function.
void measure(const wavelet::Expansion& expansion, const ParallelView& view, FootprintGroup& group) {
  const std::size_t count = group.cut < 0 ? 160 : 32;
  const Vec3& direction = view.direction();
  std::vector<double> squares(group.parts.size()), largest(group.parts.size());
  parallel_for(0, static_cast<std::int64_t>(group.parts.size()), 1, [&](std::int64_t from, std::int64_t to) {
    for (auto n = static_cast<std::size_t>(from); n < static_cast<std::size_t>(to); ++n) {
      const FootprintPart& part = group.parts[n];
      const wavelet::Band& band = *part.band;
      const Box3 box = support(part, group.axis, group.below);
      const double scale = band.scale[group.axis];
      const double far = 4 * scale * (band.upper - band.lower).sum() / direction.norm();
      Rng rng(n + 1);
      for (std::size_t s = 0; s < count; ++s) {
        Vec3 u;
        for (int a = 0; a < 3; ++a) u[a] = rng.uniform(box.min[a], box.max[a]);
        const Vec3 place = u.cwiseProduct(band.scale) - band.shift;
        double begin = -far, end = far;
        if (part.cut >= 0) {
          const double t = (part.limit - u[group.axis]) * scale / direction[group.axis];
          (t > 0 ? end : begin) = t;
        }
        const double truth =
            wavelet::line_integral(expansion, band, {1, {0, 0, 0}}, place, direction, begin, end) *
            std::abs(direction[group.axis]) / scale;
        const auto at = view.pixel(place);
        const double column = at[0] - part.first[0], row = at[1] - part.first[1];  // from the centre
        double drawn = 0;
        if (part.phases) {
          const auto& phases = *part.phases;
          const double i = std::floor(column) + 1, j = std::floor(row) + 1;
          const Splat splat{1, 0, 0, static_cast<float>((i - column) * phases.column_phases),
                            static_cast<float>((j - row) * phases.row_phases)};
          drawn = splat_value(phases, splat, static_cast<int>(i), static_cast<int>(j));
        } else {
          const auto& m = part.matrix;
          drawn = group.tables[part.table].value(part.centre[0] + m[0][0] * column + m[0][1] * row,
                                                 part.centre[1] + m[1][0] * column + m[1][1] * row);
        }
        squares[n] += (drawn - truth) * (drawn - truth);
        largest[n] = std::max(largest[n], std::abs(drawn - truth));
      }
    }
  });
  group.rms = group.largest = 0;
  for (std::size_t n = 0; n < group.parts.size(); ++n) {
    group.rms = std::max(group.rms, std::sqrt(squares[n] / static_cast<double>(count)));
    group.largest = std::max(group.largest, largest[n]);
  }
}

}  // namespace

FootprintQuality footprint_quality(int number) {
  static constexpr FootprintQuality kSteps[kFootprintQualities] = {
      {1.0 / 16, Taps::linear}, {1.0 / 32, Taps::linear}, {1.0 / 64, Taps::linear}, {1.0 / 64, Taps::cubic},
      {1.0 / 128, Taps::cubic}, {1.0 / 256, Taps::cubic}, {1.0 / 512, Taps::cubic}};
  return kSteps[number];
}

std::int64_t FootprintGroup::bytes() const {
  std::int64_t sum = 0;
  for (const auto& table : tables) sum += table.bytes();
  for (const auto& part : parts) sum += part.phases ? part.phases->bytes() : 0;
  return sum;
}

FootprintPart make_part(const ParallelView& view, const wavelet::Band& band, int axis, int cut,
                        double limit) {
  FootprintPart part;
  part.band = &band;
  part.cut = cut;
  part.limit = limit;
  const Vec3& d = view.direction();
  const std::size_t a = static_cast<std::size_t>(axis), b = other(axis, 1), c = other(axis, 2);
  const auto at = [](const Vec3& v, std::size_t i) { return v[static_cast<Eigen::Index>(i)]; };
  part.amplitude = (cut < 0 ? 1 : -1) * at(band.scale, a) / std::abs(at(d, a));
  // The centre: u = 0 along the axis of integration, where tables have their coordinates, and where the line
  // through the middle of the support passes.
  const bool below = cut < 0 || (cut == 0) == (at(d, a) > 0);
  const Box3 box = support(part, axis, below);
  Vec3 centre = box.centre();
  const double back = centre[axis] * at(band.scale, a) / at(d, a);
  for (const std::size_t i : {b, c}) {
    centre[static_cast<Eigen::Index>(i)] -= back * at(d, i) / at(band.scale, i);
  }
  centre[axis] = 0;
  part.centre = {at(centre, b), at(centre, c)};
  const std::size_t across[2] = {b, c};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto along = [&](const Vec3& pixel) {
      return (at(pixel, across[i]) - at(d, across[i]) * at(pixel, a) / at(d, a)) / at(band.scale, across[i]);
    };
    part.matrix[i] = {along(view.right()), along(view.down())};
  }
  const auto pixel = [&](const Vec3& u) { return view.pixel(u.cwiseProduct(band.scale) - band.shift); };
  part.first = pixel(centre);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto moved = pixel(centre + Vec3::Unit(static_cast<Eigen::Index>(i)));
    part.step[i] = {moved[0] - part.first[0], moved[1] - part.first[1]};
  }
  part.reach = {1e300, -1e300, 1e300, -1e300};
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 u;
    for (int i = 0; i < 3; ++i) u[i] = (corner >> i & 1) != 0 ? box.max[i] : box.min[i];
    const auto p = pixel(u);
    for (std::size_t i = 0; i < 2; ++i) {
      part.reach[2 * i] = std::min(part.reach[2 * i], p[i] - part.first[i]);
      part.reach[2 * i + 1] = std::max(part.reach[2 * i + 1], p[i] - part.first[i]);
    }
  }
  return part;
}

FootprintPrice price(const FootprintGroup& group, int quality) {
  const FootprintQuality q = footprint_quality(quality);
  const auto cost = wavelet::footprint_cost(group.lines, group.limits, group.below, q.step);
  FootprintPrice sum{0.15 * cost.multiplications, cost.bytes};
  for (const auto& part : group.parts) {
    if (!wants_phases(part, q)) continue;
    const double values = phase_values(part, sampling(part, q).step);
    sum.time += 15 * values;
    sum.bytes += static_cast<std::int64_t>(std::min(values, 1e15) * sizeof(float));
  }
  return sum;
}

void make_tables(const wavelet::Expansion& expansion, const ParallelView& view, int quality,
                 double negligible, FootprintGroup& group) {
  const FootprintQuality q = footprint_quality(quality);
  group.quality = quality;
  group.tables = wavelet::make_footprints(group.lines, group.limits, group.below, q.step);
  for (auto& part : group.parts) {
    part.phases.reset();
    if (wants_phases(part, q)) part.phases = make_phases(part, group.tables[part.table], q, negligible);
  }
  measure(expansion, view, group);
}

}  // namespace vol::render
