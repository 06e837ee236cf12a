#include "render/footprint_part.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/rng.h"

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

/// How phases are sampled: cubic ones twice as far apart have the error of linear ones. They take four times
/// the additions a pixel, of a quarter of the memory and of the time to make them, which counts where there
/// are few terms.
struct Sampling {
  double step;
  Taps taps;
};
Sampling sampling(const FootprintPart& part, const FootprintQuality& quality) {
  if (quality.taps == Taps::cubic) return {quality.step, quality.taps};
  const double places =
      static_cast<double>(phase_count(part, 0, quality.step)) * phase_count(part, 1, quality.step);
  if (static_cast<double>(part.terms().size()) > 0.5 * places) return {quality.step, Taps::linear};
  return {2 * quality.step, Taps::cubic};
}

struct Window {
  int first_column, first_row, columns, rows;
};
/// Pixels n with n - place in reach, for all places that planes are of.
Window window(const FootprintPart& part, const Sampling& sampling) {
  const auto range = [&](std::size_t direction) {
    const double beyond =
        sampling.taps == Taps::cubic ? 1.0 / phase_count(part, direction, sampling.step) : 0;
    const int first = ceil_pixel(part.reach[2 * direction] - beyond);
    return std::array{first, floor_pixel(part.reach[2 * direction + 1] + 1 + beyond) + 1 - first};
  };
  const auto columns = range(0), rows = range(1);
  return {columns[0], rows[0], columns[1], rows[1]};
}

/// Values of all phases.
double phase_values(const FootprintPart& part, const Sampling& sampling) {
  const Window w = window(part, sampling);
  const double beyond = sampling.taps == Taps::cubic ? 3 : 1;
  return (phase_count(part, 0, sampling.step) + beyond) * (phase_count(part, 1, sampling.step) + beyond) *
         (w.columns + 8.0) * w.rows;
}

/// Few terms look into the table themselves.
bool wants_phases(const FootprintPart& part, const FootprintQuality& quality) {
  const double step = sampling(part, quality).step;
  const double places = static_cast<double>(phase_count(part, 0, step)) * phase_count(part, 1, step);
  return static_cast<double>(part.terms().size()) > 0.05 * places;
}

/// Columns begin .. end - 1 of a row.
struct Run {
  int begin, end;
};

/// A footprint at the pixels of a window, for the places p / column_phases, q / row_phases below 1.
struct Planes {
  int across = 1, down = 1;
  Window window{};
  Buffer<float> values;   ///< [q][p][row][column]
  std::vector<Run> runs;  ///< [q][p][row]: columns that are not negligible

  [[nodiscard]] std::size_t at(int q, int p, int row) const {
    return static_cast<std::size_t>((std::int64_t{q} * across + p) * window.rows + row);
  }
};

Planes sample_planes(const FootprintPart& part, const wavelet::FootprintTable& table, const Sampling& samples,
                     double least) {
  Planes planes{
      phase_count(part, 0, samples.step), phase_count(part, 1, samples.step), window(part, samples), {}, {}};
  const Window& w = planes.window;
  planes.runs.resize(planes.at(planes.down, 0, 0));
  planes.values = Buffer<float>(planes.runs.size() * static_cast<std::size_t>(w.columns), 0.0F);
  const auto& m = part.matrix;
  parallel_for(0, planes.down, 1, [&](std::int64_t from, std::int64_t to) {
    for (auto q = static_cast<int>(from); q < to; ++q) {
      for (int p = 0; p < planes.across; ++p) {
        for (int row = 0; row < w.rows; ++row) {
          const double j = w.first_row + row - static_cast<double>(q) / planes.down;
          const std::size_t at = planes.at(q, p, row);
          float* line = planes.values.data() + at * static_cast<std::size_t>(w.columns);
          // Columns that can lie in the table.
          double low = 0, high = w.columns - 1;
          const double shift = static_cast<double>(p) / planes.across - w.first_column;
          for (std::size_t c = 0; c < 2; ++c) {
            const double begin = part.centre[c] + m[c][1] * j - m[c][0] * shift;
            const double first = c == 0 ? table.x0 : table.y0, last = c == 0 ? table.x1() : table.y1();
            if (m[c][0] == 0) continue;
            const double s = (first - begin) / m[c][0], t = (last - begin) / m[c][0];
            low = std::max(low, std::min(s, t));
            high = std::min(high, std::max(s, t));
          }
          Run run{w.columns, 0};
          for (int column = low <= high ? static_cast<int>(std::ceil(low)) : w.columns; column <= high;
               ++column) {
            const double i = column - shift;
            line[column] = static_cast<float>(table.value(part.centre[0] + m[0][0] * i + m[0][1] * j,
                                                          part.centre[1] + m[1][0] * i + m[1][1] * j));
            if (std::abs(static_cast<double>(line[column])) <= least) continue;
            run.begin = std::min(run.begin, column);
            run.end = column + 1;
          }
          planes.runs[at] = run;
        }
      }
    }
  });
  return planes;
}

FootprintPhases make_phases(const FootprintPart& part, const wavelet::FootprintTable& table,
                            const FootprintQuality& quality, double negligible) {
  const Sampling samples = sampling(part, quality);
  const Planes planes = sample_planes(part, table, samples, negligible * part.peak);
  const Window& w = planes.window;
  FootprintPhases phases;
  phases.taps = samples.taps;
  phases.column_phases = planes.across;
  phases.row_phases = planes.down;
  phases.first_column = w.first_column;
  phases.first_row = w.first_row;
  phases.rows = w.rows;
  // A place below 0 or from 1 on is that of another plane, some pixels away.
  const auto each_plane = [&](const auto& f) {
    for (int q = -phases.before(); q <= planes.down + phases.before(); ++q) {
      const int rows = q < 0 ? -1 : q / planes.down;
      for (int p = -phases.before(); p <= planes.across + phases.before(); ++p) {
        const int columns = p < 0 ? -1 : p / planes.across;
        f(q - rows * planes.down, p - columns * planes.across, rows, columns);
      }
    }
  };
  std::vector<Run> runs(static_cast<std::size_t>(w.rows), {w.columns, 0});
  each_plane([&](int q, int p, int rows, int columns) {
    for (int row = std::max(rows, 0); row < w.rows + std::min(rows, 0); ++row) {
      const Run& own = planes.runs[planes.at(q, p, row - rows)];
      if (own.begin >= own.end) continue;
      Run& run = runs[static_cast<std::size_t>(row)];
      run.begin = std::min(run.begin, std::max(own.begin + columns, 0));
      run.end = std::max(run.end, std::min(own.end + columns, w.columns));
    }
  });
  int longest = 0;
  for (const Run& run : runs) longest = std::max(longest, run.end - run.begin);
  phases.chunk = longest <= 8 ? 8 : 16;
  for (const Run& run : runs) {
    phases.begin.push_back(static_cast<std::int32_t>(phases.columns.size()));
    for (int column = run.begin; column < run.end; column += phases.chunk) {
      phases.columns.push_back(column);
      phases.columns_reached = std::max(phases.columns_reached, column + phases.chunk);
    }
  }
  phases.begin.push_back(static_cast<std::int32_t>(phases.columns.size()));

  phases.values = Buffer<float>(
      static_cast<std::size_t>(phases.plane()) * static_cast<std::size_t>(phases.across() * phases.down()),
      0.0F);
  float* out = phases.values.data();
  each_plane([&](int q, int p, int rows, int columns) {
    for (int row = 0; row < w.rows; ++row) {
      const int from = row - rows;
      const float* line =
          from < 0 || from >= w.rows
              ? nullptr
              : planes.values.data() + planes.at(q, p, from) * static_cast<std::size_t>(w.columns);
      const Run& run = runs[static_cast<std::size_t>(row)];
      for (auto c = phases.begin[static_cast<std::size_t>(row)];
           c < phases.begin[static_cast<std::size_t>(row) + 1]; ++c, out += phases.chunk) {
        if (line == nullptr) continue;
        const int first = phases.columns[static_cast<std::size_t>(c)];
        const int begin = std::max(first, columns);
        const int end = std::min({first + phases.chunk, run.end, w.columns + columns});
        for (int column = begin; column < end; ++column) out[column - first] = line[column - columns];
      }
    }
  });
  return phases;
}

std::vector<std::uint32_t> order_by_place(const FootprintPart& part) {
  const auto terms = part.terms();
  const int across = part.phases->column_phases, down = part.phases->row_phases;
  std::vector<std::uint32_t> place, begin(static_cast<std::size_t>(across * down) + 1), order(terms.size());
  for (const auto& term : terms) {
    const Splat s = part.splat(term, 1);
    const int p = std::min(static_cast<int>(s.u), across - 1), q = std::min(static_cast<int>(s.v), down - 1);
    place.push_back(static_cast<std::uint32_t>(q * across + p));
    ++begin[place.back() + 1];
  }
  for (std::size_t c = 1; c < begin.size(); ++c) begin[c] += begin[c - 1];
  for (std::size_t n = 0; n < terms.size(); ++n) order[begin[place[n]]++] = static_cast<std::uint32_t>(n);
  return order;
}

/// The line through a place of a part's function, in its own coordinates.
FootprintLine line_through(const wavelet::Expansion& expansion, const ParallelView& view,
                           const FootprintGroup& group, const FootprintPart& part, const Vec3& u) {
  const Vec3& direction = view.direction();
  const wavelet::Band& band = *part.band;
  const double scale = band.scale[group.axis];
  const Vec3 place = u.cwiseProduct(band.scale) - band.shift;
  // Where the line is within the support, or the part of it that is not cut off, along the axis.
  const double d = direction[group.axis];
  const Box3 box = support(part, group.axis, group.below);
  const double a = (box.min[group.axis] - u[group.axis]) * scale / d,
               b = (box.max[group.axis] - u[group.axis]) * scale / d;
  const auto at = view.pixel(place);
  return {at[0] - part.first[0], at[1] - part.first[1],
          wavelet::line_integral(expansion, band, {1, {0, 0, 0}}, place, direction, std::min(a, b),
                                 std::max(a, b)) *
              std::abs(d) / scale};
}

/// Lines through places spread evenly over a part's function.
std::vector<FootprintLine> even_lines(const wavelet::Expansion& expansion, const ParallelView& view,
                                      const FootprintGroup& group, const FootprintPart& part,
                                      std::uint64_t seed) {
  std::vector<FootprintLine> lines(group.cut < 0 ? 400 : 80);
  const Box3 box = support(part, group.axis, group.below);
  Rng rng(seed);
  for (auto& line : lines) {
    Vec3 u;
    for (int a = 0; a < 3; ++a) u[a] = rng.uniform(box.min[a], box.max[a]);
    line = line_through(expansion, view, group, part, u);
  }
  return lines;
}

/// Sum of the squared fourth differences along both axes around a sample, which is what a cubic through four
/// samples misses there, but for a factor.
double roughness(const wavelet::FootprintTable& table, std::int64_t i, std::int64_t j) {
  const auto fourth = [&](std::int64_t step) {
    const float* f = table.values.data() + i * table.ny + j;
    return static_cast<double>(f[-2 * step] - 4 * f[-step] + 6 * f[0] - 4 * f[step] + f[2 * step]);
  };
  const double x = fourth(table.ny), y = fourth(1);
  return x * x + y * y;
}

/// Lines near samples of the table drawn with the square of what interpolation is likely to miss: rough
/// functions have their largest errors in few places, which evenly spread lines do not find (test_footprints,
/// KeepTheErrorNearPlanesOfAxes).
std::vector<FootprintLine> rough_lines(const wavelet::Expansion& expansion, const ParallelView& view,
                                       const FootprintGroup& group, const FootprintPart& part,
                                       std::uint64_t seed) {
  const wavelet::FootprintTable& table = group.tables[part.table];
  std::vector<double> below{0};  // of the rows of samples up to one
  for (std::int64_t i = 2; i < table.nx - 2; ++i) {
    double row = 0;
    for (std::int64_t j = 2; j < table.ny - 2; ++j) row += roughness(table, i, j);
    below.push_back(below.back() + row);
  }
  if (!(below.back() > 0)) return {};
  std::vector<FootprintLine> lines(group.cut < 0 ? 200 : 40);
  Rng rng(seed);
  for (auto& line : lines) {
    double left = rng.uniform(0, below.back());
    const auto row = std::prev(std::upper_bound(below.begin(), below.end() - 1, left));
    left -= *row;
    const std::int64_t i = 2 + (row - below.begin());
    std::int64_t j = 2;
    while (j < table.ny - 3 && (left -= roughness(table, i, j)) > 0) ++j;
    Vec3 u = Vec3::Zero();
    u[static_cast<Eigen::Index>(other(group.axis, 1))] =
        table.x0 + table.h * (static_cast<double>(i) + rng.uniform(-1, 1));
    u[static_cast<Eigen::Index>(other(group.axis, 2))] =
        table.y0 + table.h * (static_cast<double>(j) + rng.uniform(-1, 1));
    line = line_through(expansion, view, group, part, u);
  }
  return lines;
}

/// What is drawn of a footprint, at a place from its centre.
double drawn_value(const FootprintGroup& group, const FootprintPart& part, double column, double row) {
  if (!part.phases) {
    const auto& m = part.matrix;
    return group.tables[part.table].value(part.centre[0] + m[0][0] * column + m[0][1] * row,
                                          part.centre[1] + m[1][0] * column + m[1][1] * row);
  }
  const auto& phases = *part.phases;
  const double i = std::floor(column) + 1, j = std::floor(row) + 1;
  const Splat splat{1, 0, 0, static_cast<float>((i - column) * phases.column_phases),
                    static_cast<float>((j - row) * phases.row_phases)};
  return splat_value(phases, splat, static_cast<int>(i), static_cast<int>(j));
}

/// Deviation of what is drawn from the truth.
void measure(const wavelet::Expansion& expansion, const ParallelView& view, FootprintGroup& group) {
  std::vector<double> squares(group.parts.size()), largest(group.parts.size());
  parallel_for(0, static_cast<std::int64_t>(group.parts.size()), 1, [&](std::int64_t from, std::int64_t to) {
    for (auto n = static_cast<std::size_t>(from); n < static_cast<std::size_t>(to); ++n) {
      FootprintPart& part = group.parts[n];
      if (part.even_lines.empty()) part.even_lines = even_lines(expansion, view, group, part, n + 1);
      const auto more = rough_lines(expansion, view, group, part,
                                    1000 * (n + 1) + static_cast<std::uint64_t>(group.quality));
      part.rough_lines.insert(part.rough_lines.end(), more.begin(), more.end());
      const auto error = [&](const FootprintLine& line) {
        return std::abs(drawn_value(group, part, line.column, line.row) - line.integral);
      };
      for (const auto& line : part.even_lines) {
        const double off = error(line);
        squares[n] += off * off;
        largest[n] = std::max(largest[n], off);
      }
      for (const auto& line : part.rough_lines) largest[n] = std::max(largest[n], error(line));
    }
  });
  group.rms = group.largest = 0;
  for (std::size_t n = 0; n < group.parts.size(); ++n) {
    const auto count = static_cast<double>(group.parts[n].even_lines.size());
    group.rms = std::max(group.rms, std::sqrt(squares[n] / count));
    group.largest = std::max(group.largest, largest[n]);
  }
}

}  // namespace

FootprintQuality footprint_quality(int number) {
  static constexpr FootprintQuality kSteps[kFootprintQualities] = {
      {1.0 / 8, Taps::linear}, {1.0 / 16, Taps::linear}, {1.0 / 32, Taps::linear}, {1.0 / 64, Taps::linear},
      {1.0 / 64, Taps::cubic}, {1.0 / 128, Taps::cubic}, {1.0 / 256, Taps::cubic}, {1.0 / 512, Taps::cubic}};
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

double peak_of(const wavelet::FootprintLines& lines) {
  const double end = lines.z->upper();
  const auto tables = wavelet::make_footprints(lines, std::span(&end, 1), true, 0.125);
  double peak = 0;
  for (const float v : tables[0].values) peak = std::max(peak, std::abs(static_cast<double>(v)));
  return peak;
}

FootprintPrice price(const FootprintGroup& group, int quality) {
  const FootprintQuality q = footprint_quality(quality);
  const auto cost = wavelet::footprint_cost(group.lines, group.limits, group.below, q.step);
  FootprintPrice sum{0.15 * cost.multiplications, cost.bytes};
  for (const auto& part : group.parts) {
    if (!wants_phases(part, q)) continue;
    const double values = phase_values(part, sampling(part, q));
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
    part.drop_phases();
    if (!wants_phases(part, q)) continue;
    part.phases = make_phases(part, group.tables[part.table], q, negligible);
    part.order = order_by_place(part);
  }
  measure(expansion, view, group);
}

}  // namespace vol::render
