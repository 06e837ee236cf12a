#include "render/wavelet_footprints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "render/axis_products.h"
#include "render/footprint_part.h"
#include "render/octant_cells.h"
#include "render/picture.h"
#include "render/picture_tiles.h"
#include "render/wavelet_xray.h"

namespace vol::render {
namespace {

using Run = FootprintPhases::Run;

constexpr int kBlockRows = 32;
constexpr int kChecks = 40;
/// Tables of more memory than this are not made.
constexpr std::int64_t kTableBytes = std::int64_t{1} << 30;
/// Standard deviations that none of 1e6 pixels exceeds, and how many times the largest error of a single
/// term.
constexpr double kDeviations = 5, kLargest = 1.5;
/// What exact integrals cost, nanoseconds a polynomial piece.
constexpr double kPieceTime = 25;

/// Columns of a row whose rays pass the face of an axis; which: entry, exit.
struct FaceWindows {
  std::array<std::array<std::vector<Run>, 3>, 2> rows;
  std::array<std::array<std::int64_t, 3>, 2> pixels{};
};

}  // namespace

struct WaveletFootprints::State {
  const wavelet::Expansion& expansion;
  RenderOptions options;
  ParallelView view;
  WaveletXray xray;
  double error;
  FootprintReport report;

  std::vector<PixelRow> rays;
  FaceWindows windows;
  std::vector<std::array<int, 2>> exact_pixels;  ///< that no footprint can draw: (x, y)

  std::vector<OctantCells> cells;
  std::optional<AxisProducts> products;
  std::vector<FootprintGroup> groups;
  std::vector<const wavelet::Band*> exact_bands;
  std::vector<std::int32_t> covers;  ///< footprints over each pixel, once counted

  State(const wavelet::Expansion& e, const Scene& scene, const RenderOptions& o, double allowed)
      : expansion(e),
        options(o),
        view(e.geometry(), scene.view, o.width, o.height),
        xray(e),
        error(allowed) {}

  void prepare_rays();
  void plan();
  void add_groups(const std::vector<const wavelet::Band*>& bands);
  bool refine(double allowed);
  void give_up_tables();
  template <class T>
  std::vector<double> values(std::vector<std::int32_t>* met) const;
  std::vector<double> drawn(std::vector<std::int32_t>* met) const {
    // Sums of some thousand terms in float are within 1e-6 of the largest of them.
    return error >= 2e-5 ? values<float>(met) : values<double>(met);
  }
};

void WaveletFootprints::State::prepare_rays() {
  rays.resize(static_cast<std::size_t>(options.height));
  parallel_for(0, options.height, 8, [&](std::int64_t from, std::int64_t to) {
    for (auto y = from; y < to; ++y) view.row(static_cast<int>(y), rays[static_cast<std::size_t>(y)]);
  });
  for (std::size_t which = 0; which < 2; ++which) {
    for (std::size_t a = 0; a < 3; ++a) {
      auto& rows = windows.rows[which][a];
      rows.assign(rays.size(), {0, 0});
      for (std::size_t y = 0; y < rays.size(); ++y) {
        const auto& face = rays[y].face[which];
        for (int x = 0; x < options.width; ++x) {
          if (face[static_cast<std::size_t>(x)] != static_cast<int>(a)) continue;
          Run& run = rows[y];
          if (run.begin == run.end) {
            run = {x, x + 1};
          } else if (run.end == x) {
            run.end = x + 1;
          } else {  // a face is convex: along an edge of the box rounding let another one in
            exact_pixels.push_back({x, static_cast<int>(y)});
          }
        }
        windows.pixels[which][a] += rows[y].end - rows[y].begin;
      }
    }
  }
}

void WaveletFootprints::State::add_groups(const std::vector<const wavelet::Band*>& bands) {
  const Vec3& d = view.direction();
  int along = 0;
  d.cwiseAbs().maxCoeff(&along);
  const auto lines = [&](const wavelet::Band& band, int axis) {
    const auto f = [&](int which) {
      return &expansion.function(band.factor[static_cast<std::size_t>((axis + which) % 3)]);
    };
    return wavelet::FootprintLines{f(1), f(2), f(0), d[(axis + 1) % 3] / d[axis],
                                   d[(axis + 2) % 3] / d[axis]};
  };
  std::map<std::array<int, 3>, std::size_t> by_functions;
  for (const wavelet::Band* band : bands) {
    const auto [at, fresh] = by_functions.try_emplace(band->factor, groups.size());
    if (fresh) {
      FootprintGroup& group = groups.emplace_back();
      group.axis = along;
      group.lines = lines(*band, along);
      group.limits = {group.lines.z->upper()};
    }
    groups[at->second].parts.push_back(make_part(view, *band, along, -1, 0));
  }
  for (const wavelet::Band* band : bands) {
    for (int cut = 0; cut < 2; ++cut) {
      for (int axis = 0; axis < 3; ++axis) {
        if (windows.pixels[static_cast<std::size_t>(cut)][static_cast<std::size_t>(axis)] == 0) continue;
        const double place = (view.face(cut, axis) + band->shift[axis]) / band->scale[axis];
        std::map<double, std::vector<wavelet::Term>> by_limit;
        for (const auto& term : band->terms) {
          const double limit = place - term.k[static_cast<std::size_t>(axis)];
          if (limit > band->lower[axis] && limit < band->upper[axis]) by_limit[limit].push_back(term);
        }
        if (by_limit.empty()) continue;
        FootprintGroup& group = groups.emplace_back();
        group.axis = axis;
        group.cut = cut;
        group.below = (cut == 0) == (d[axis] > 0);
        group.lines = lines(*band, axis);
        for (auto& [limit, terms] : by_limit) {
          FootprintPart part = make_part(view, *band, axis, cut, limit);
          part.table = group.limits.size();
          part.own_terms = std::move(terms);
          group.limits.push_back(limit);
          group.parts.push_back(std::move(part));
        }
      }
    }
  }
}

namespace {

/// Exact integrals in place of a group's tables.
void give_up(FootprintGroup& group) {
  group.exact = true;
  group.tables.clear();
  for (auto& part : group.parts) part.phases.reset();
  group.rms = group.largest = 0;
}

}  // namespace

/// Makes tables finer until the estimate is within what is allowed; groups for which that costs more than
/// exact integrals become exact. Whether there is a table left.
bool WaveletFootprints::State::refine(double allowed) {
  const PictureTiles tiles(options.width, options.height);
  std::vector<std::vector<PictureTiles::Sums>> sums(groups.size());
  std::vector<double> exact_time(groups.size());
  parallel_for(0, static_cast<std::int64_t>(groups.size()), 1, [&](std::int64_t from, std::int64_t to) {
    for (auto g = static_cast<std::size_t>(from); g < static_cast<std::size_t>(to); ++g) {
      const FootprintGroup& group = groups[g];
      sums[g] = tiles.none();
      double pieces = 0, pixels = 0;
      for (const auto* f : {group.lines.x, group.lines.y, group.lines.z}) {
        pieces += 0.5 * static_cast<double>(f->pieces.size());
      }
      const double face = group.cut < 0
                              ? 1e300
                              : static_cast<double>(windows.pixels[static_cast<std::size_t>(group.cut)]
                                                                  [static_cast<std::size_t>(group.axis)]);
      for (const auto& part : group.parts) {
        const auto& reach = part.reach;
        for (const auto& term : part.terms()) {
          const auto p = part.centre_of(term);
          const double amplitude = std::abs(term.c * part.amplitude);
          tiles.visit(p[0] + reach[0], p[0] + reach[1], p[1] + reach[2], p[1] + reach[3],
                      [&](std::size_t t, double share) {
                        PictureTiles::Sums& sum = sums[g][t];
                        sum.one += share * amplitude;
                        sum.two += share * amplitude * amplitude;
                        sum.largest = std::max(sum.largest, amplitude);
                      });
          const auto within = [](double low, double high, int size) {
            return std::max(0.0, std::min(high, size - 1.0) - std::max(low, 0.0));
          };
          pixels += std::min(face, 0.7 * within(p[0] + reach[0], p[0] + reach[1], options.width) *
                                       within(p[1] + reach[2], p[1] + reach[3], options.height));
        }
      }
      exact_time[g] = kPieceTime * pieces * pixels;
    }
  });

  // The first quality a group gets is what its error is likely to need; of the finer ones what it proves to.
  const auto worth = [&](std::size_t g, int quality) {
    if (quality >= kFootprintQualities) return false;
    const FootprintPrice p = price(groups[g], quality);
    return p.time < exact_time[g] && p.bytes < kTableBytes / 4;
  };
  std::vector<int> wanted(groups.size(), error >= 5e-3 ? 0 : error >= 5e-4 ? 1 : 2);
  std::vector<bool> due(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    due[g] = groups[g].tables.empty() && !groups[g].exact;
    if (!groups[g].tables.empty()) wanted[g] = groups[g].quality;
  }
  const auto make_exact = [&](std::size_t g) {
    give_up(groups[g]);
    due[g] = false;
  };
  for (;;) {
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (due[g] && !worth(g, wanted[g])) make_exact(g);
    }
    // Together within kTableBytes, before any is made: the largest give way to exact integrals.
    const auto planned = [&](std::size_t g) {
      return due[g] ? price(groups[g], wanted[g]).bytes : groups[g].bytes();
    };
    std::vector<std::int64_t> plans(groups.size());
    std::int64_t together = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) together += plans[g] = planned(g);
    while (together > kTableBytes) {
      const auto g = static_cast<std::size_t>(std::max_element(plans.begin(), plans.end()) - plans.begin());
      together -= std::exchange(plans[g], 0);
      make_exact(g);
    }
    parallel_for(0, static_cast<std::int64_t>(groups.size()), 1, [&](std::int64_t from, std::int64_t to) {
      for (auto g = static_cast<std::size_t>(from); g < static_cast<std::size_t>(to); ++g) {
        if (due[g]) make_tables(expansion, view, wanted[g], 0.03 * error, groups[g]);
      }
    });
    std::int64_t bytes = 0;
    for (const auto& group : groups) bytes += group.bytes();
    report.estimate = 0;
    std::fill(due.begin(), due.end(), false);
    for (std::size_t t = 0; t < tiles.none().size(); ++t) {
      double one = 0, two = 0, largest = 0;
      for (std::size_t g = 0; g < groups.size(); ++g) {
        one += sums[g][t].one * groups[g].largest;
        two += sums[g][t].two * groups[g].rms * groups[g].rms;
        largest = std::max(largest, sums[g][t].largest * groups[g].largest);
      }
      const double estimate = std::min(one, kDeviations * std::sqrt(two) + kLargest * largest);
      report.estimate = std::max(report.estimate, estimate);
      if (estimate <= allowed) continue;
      for (std::size_t g = 0; g < groups.size(); ++g) {
        const double own = sums[g][t].two * groups[g].rms * groups[g].rms;
        const double peak = sums[g][t].largest * groups[g].largest;
        // What does not matter in the worst sum is left as it is.
        if (own > 0.02 * two || kLargest * peak > 0.3 * allowed) due[g] = true;
      }
    }
    if (std::none_of(due.begin(), due.end(), [](bool b) { return b; })) break;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!due[g]) continue;
      wanted[g] = groups[g].quality + 1;
      if (bytes > kTableBytes) wanted[g] = kFootprintQualities;
    }
  }
  return std::any_of(groups.begin(), groups.end(), [](const auto& group) { return !group.exact; });
}

void WaveletFootprints::State::give_up_tables() {
  for (auto& group : groups) give_up(group);
  report.estimate = 0;
}

void WaveletFootprints::State::plan() {
  prepare_rays();
  std::vector<const wavelet::Band*> all;
  for (const auto& band : expansion.bands()) all.push_back(&band);
  const auto count_terms = [](const std::vector<const wavelet::Band*>& bands) {
    std::int64_t sum = 0;
    for (const auto* band : bands) sum += static_cast<std::int64_t>(band->terms.size());
    return sum;
  };
  if (is_haar(expansion)) {
    cells = make_octant_cells(expansion);
    report.terms_boxes = count_terms(all);
    return;
  }

  // Some exact pixels, by a sequence that fills the picture evenly (Roberts 2018: powers of 1 / the plastic
  // number).
  struct Check {
    int x, y;
    double value;
  };
  std::vector<Check> checks;
  bool misses = false;
  for (int n = 1; n <= 50 * kChecks && checks.size() < kChecks; ++n) {
    const auto place = [n](double step, int size) {
      const double p = 0.5 + step * n;
      return static_cast<int>((p - std::floor(p)) * size);
    };
    const int x = place(0.7548776662466927, options.width), y = place(0.5698402909980532, options.height);
    if (rays[static_cast<std::size_t>(y)].half[static_cast<std::size_t>(x)] < 0) {
      misses = true;
    } else {
      checks.push_back({x, y, 0});
    }
  }
  parallel_for(0, static_cast<std::int64_t>(checks.size()), 1, [&](std::int64_t from, std::int64_t to) {
    for (auto n = from; n < to; ++n) {
      Check& check = checks[static_cast<std::size_t>(n)];
      const auto cast = view.cast(check.x, check.y);
      std::int64_t terms = 0, pieces = 0;
      check.value = xray.integral(cast->ray, cast->chord, terms, pieces);
    }
  });
  double least = misses ? 0 : std::numeric_limits<double>::infinity(), most = misses ? 0 : -least;
  for (const Check& check : checks) {
    least = std::min(least, check.value);
    most = std::max(most, check.value);
  }
  report.range = most > least ? most - least : 0;
  report.allowed = error * report.range;
  const auto worst = [&] {
    const auto picture = drawn(nullptr);
    double found = 0;
    for (const Check& check : checks) {
      const auto at = static_cast<std::size_t>(check.y) * static_cast<std::size_t>(options.width) +
                      static_cast<std::size_t>(check.x);
      found = std::max(found, std::abs(picture[at] - check.value));
    }
    return found;
  };

  if (auto axis = AxisProducts::make(expansion, view, rays, report.allowed)) {
    const auto beside_faces = exact_pixels;
    products = std::move(axis);
    report.terms_products = count_terms(all);
    report.estimate = products->estimate();
    for (int y = 0; y < options.height; ++y) {  // rays that pass a face beside the axis
      const PixelRow& row = rays[static_cast<std::size_t>(y)];
      for (int x = 0; x < options.width; ++x) {
        const auto i = static_cast<std::size_t>(x);
        if (row.half[i] >= 0 && (row.face[0][i] != products->axis() || row.face[1][i] != products->axis())) {
          exact_pixels.push_back({x, y});
        }
      }
    }
    report.found = worst();
    if (report.found <= report.allowed || report.allowed == 0) return;
    products.reset();  // its bound is not kept at a pixel that was integrated: tables, then
    exact_pixels = beside_faces;
    report.terms_products = 0;
  }

  std::vector<const wavelet::Band*> bands;
  for (const auto* band : all) {
    bool smooth = true;
    for (std::size_t a = 0; a < 3; ++a) {
      smooth &= band->scale[static_cast<Eigen::Index>(a)] == band->scale[0];
      smooth &= wavelet::continuous(expansion.function(band->factor[a]));
    }
    (smooth ? bands : exact_bands).push_back(band);
  }
  if (report.allowed > 0) add_groups(bands);
  double allowed = report.allowed;
  for (int trial = 0; report.allowed > 0 && !groups.empty(); ++trial, allowed /= 4) {
    const bool tables = trial < 3 && refine(allowed);
    if (!tables) give_up_tables();
    // Bands that are exact as a whole need no cuts.
    for (const auto& group : groups) {
      if (group.cut >= 0 || !group.exact) continue;
      for (const auto& part : group.parts) exact_bands.push_back(part.band);
    }
    std::erase_if(groups, [&](const FootprintGroup& group) {
      if (group.cut < 0) return group.exact;
      return std::find(exact_bands.begin(), exact_bands.end(), group.parts[0].band) != exact_bands.end();
    });
    report.found = worst();
    if (report.found <= report.allowed) break;
  }
  if (report.allowed == 0) exact_bands = all;
  report.terms_exact = count_terms(exact_bands);
  for (const auto& group : groups) {
    report.table_bytes += group.bytes();
    report.tables += static_cast<std::int64_t>(group.tables.size());
    for (const auto& part : group.parts) {
      if (group.cut < 0) report.terms_tables += static_cast<std::int64_t>(part.terms().size());
    }
  }
}

namespace {

/// Terms of a part as splats, those at the same place between pixels together: they read the same planes.
std::vector<Splat> make_splats(const FootprintPart& part, double unit) {
  const auto terms = part.terms();
  std::vector<Splat> splats(terms.size());
  const int across = part.phases ? part.phases->column_phases : 1,
            down = part.phases ? part.phases->row_phases : 1;
  std::vector<std::uint32_t> begin(static_cast<std::size_t>(across * down) + 1);
  std::vector<std::uint32_t> place(terms.size());
  for (std::size_t n = 0; n < terms.size(); ++n) {
    const auto p = part.centre_of(terms[n]);
    Splat& s = splats[n];
    s.amplitude = terms[n].c * part.amplitude / unit;
    s.column = floor_pixel(p[0]);
    s.row = floor_pixel(p[1]);
    const double column = s.column, row = s.row;
    s.u = static_cast<float>(std::clamp(p[0] - column, 0.0, 1.0) * across);
    s.v = static_cast<float>(std::clamp(p[1] - row, 0.0, 1.0) * down);
    place[n] = static_cast<std::uint32_t>(std::min(static_cast<int>(s.v), down - 1) * across +
                                          std::min(static_cast<int>(s.u), across - 1));
    ++begin[place[n] + 1];
  }
  if (!part.phases) return splats;
  for (std::size_t c = 1; c < begin.size(); ++c) begin[c] += begin[c - 1];
  std::vector<Splat> sorted(terms.size());
  for (std::size_t n = 0; n < terms.size(); ++n) sorted[begin[place[n]]++] = splats[n];
  return sorted;
}

/// Columns x of a row with low <= a + b x <= high.
Run columns_within(Run run, double a, double b, double low, double high) {
  if (b == 0) return a >= low && a <= high ? run : Run{0, 0};
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

template <class T>
std::vector<double> WaveletFootprints::State::values(std::vector<std::int32_t>* met) const {
  const auto width = static_cast<std::size_t>(options.width);
  std::vector<double> picture(width * static_cast<std::size_t>(options.height));
  if (met != nullptr) met->assign(picture.size(), 0);

  struct Layer {
    const FootprintGroup* group;
    const FootprintPart* part;
    std::vector<Splat> splats;
  };
  std::vector<Layer> layers;
  double unit = 0;  // of amplitudes: float holds their ratios
  for (const auto& group : groups) {
    for (const auto& part : group.parts) {
      layers.push_back({&group, &part, {}});
      for (const auto& term : part.terms()) unit = std::max(unit, std::abs(term.c * part.amplitude));
    }
  }
  if (!(unit > 0)) unit = 1;
  parallel_for(0, static_cast<std::int64_t>(layers.size()), 1, [&](std::int64_t from, std::int64_t to) {
    for (auto n = static_cast<std::size_t>(from); n < static_cast<std::size_t>(to); ++n) {
      if (!layers[n].group->exact) layers[n].splats = make_splats(*layers[n].part, unit);
    }
  });

  const Vec3& d = view.direction();
  const std::int64_t blocks = (options.height + kBlockRows - 1) / kBlockRows;
  parallel_for(0, blocks, 1, [&](std::int64_t from_block, std::int64_t to_block) {
    for (auto block = from_block; block < to_block; ++block) {
      const int first = static_cast<int>(block) * kBlockRows;
      const int count = std::min(kBlockRows, options.height - first);
      const auto stride = static_cast<std::int64_t>(width) + kFootprintPadding;
      std::vector<T> sums(static_cast<std::size_t>(stride * count));
      std::vector<double> other(static_cast<std::size_t>(stride * count));
      std::vector<std::int32_t> ends(static_cast<std::size_t>(met != nullptr ? stride * count : 0));
      PictureRows<T> rows{sums.data(), stride, options.width, first, count, nullptr};
      for (const Layer& layer : layers) {
        const FootprintPart& part = *layer.part;
        const std::vector<Run>* window =
            part.cut < 0
                ? nullptr
                : &windows
                       .rows[static_cast<std::size_t>(part.cut)][static_cast<std::size_t>(layer.group->axis)];
        rows.window = window == nullptr ? nullptr : window->data() + first;
        if (met != nullptr && part.cut < 0)
          count_reach(part, options.width, first, count, stride, ends.data());
        if (part.phases) {
          add_splats(*part.phases, layer.splats.data(), layer.splats.size(), rows);
          continue;
        }
        const auto run_of = [&](int y) {
          return window == nullptr ? Run{0, options.width} : (*window)[static_cast<std::size_t>(y)];
        };
        const auto& reach = part.reach;
        if (layer.group->exact) {
          for (const auto& term : part.terms()) {
            const auto p = part.centre_of(term);
            const int low = std::max(first, ceil_pixel(p[1] + reach[2]));
            for (int y = low; y < first + count && y <= p[1] + reach[3]; ++y) {
              const Run run = columns_within(run_of(y), -p[0], 1, reach[0], reach[1]);
              const PixelRow& ray = rays[static_cast<std::size_t>(y)];
              for (int x = run.begin; x < run.end; ++x) {
                const auto i = static_cast<std::size_t>(x);
                const Vec3 middle(ray.middle[0][i], ray.middle[1][i], ray.middle[2][i]);
                // From the chord's end to behind all that the term reaches.
                const double far = ray.half[i] + 4 * part.band->scale[layer.group->axis] *
                                                     (part.band->upper - part.band->lower).sum() / d.norm();
                const double begin = part.cut == 0 ? -far : ray.half[i];
                const double end = part.cut == 0 ? -ray.half[i] : far;
                other[static_cast<std::size_t>((y - first) * stride + x)] -=
                    wavelet::line_integral(expansion, *part.band, term, middle, d, begin, end);
              }
            }
          }
          continue;
        }
        const auto& table = layer.group->tables[part.table];
        const auto& m = part.matrix;
        for (const Splat& splat : layer.splats) {
          const double column = splat.column + static_cast<double>(splat.u),
                       row = splat.row + static_cast<double>(splat.v);
          const int low = std::max(first, ceil_pixel(row + reach[2]));
          for (int y = low; y < first + count && y <= row + reach[3]; ++y) {
            const double j = y - row;
            Run run = columns_within(run_of(y), -column, 1, reach[0], reach[1]);
            for (std::size_t c = 0; c < 2; ++c) {
              const double at = part.centre[c] + m[c][1] * j - m[c][0] * column;
              run = columns_within(run, at, m[c][0], c == 0 ? table.x0 : table.y0,
                                   c == 0 ? table.x1() : table.y1());
            }
            for (int x = run.begin; x < run.end; ++x) {
              const double i = x - column;
              other[static_cast<std::size_t>((y - first) * stride + x)] +=
                  unit * splat.amplitude *
                  table.value(part.centre[0] + m[0][0] * i + m[0][1] * j,
                              part.centre[1] + m[1][0] * i + m[1][1] * j);
            }
          }
        }
      }
      for (const auto& level : cells) {
        add_cells(level, view, rays, first, count, stride, other.data(),
                  met != nullptr ? ends.data() : nullptr);
      }
      if (products)
        products->add(rays, first, count, stride, other.data(), met != nullptr ? ends.data() : nullptr);
      for (int y = 0; y < count; ++y) {
        const PixelRow& ray = rays[static_cast<std::size_t>(first + y)];
        std::int32_t cover = 0;
        for (std::size_t x = 0; x < width; ++x) {
          const auto at = static_cast<std::size_t>(y * stride) + x;
          const auto out = static_cast<std::size_t>(first + y) * width + x;
          if (met != nullptr) cover += ends[at];
          if (ray.half[x] < 0) continue;
          if (met != nullptr) (*met)[out] = cover;
          picture[out] = unit * static_cast<double>(sums[at]) + other[at];
          if (exact_bands.empty()) continue;
          const auto cast = view.cast(static_cast<int>(x), first + y);
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
      const auto out = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
      picture[out] = xray.integral(cast->ray, cast->chord, terms, more);
      if (met != nullptr) (*met)[out] = static_cast<std::int32_t>(terms);
    }
  });
  return picture;
}

WaveletFootprints::WaveletFootprints(const wavelet::Expansion& expansion, const Scene& scene,
                                     const RenderOptions& options, double error) {
  if (!(error > 0) || !std::isfinite(error))
    throw Error("footprint error: a positive share of the range is expected");
  require_valid(options);
  state_ = std::make_unique<State>(expansion, scene, options, error);
  state_->plan();
}

WaveletFootprints::~WaveletFootprints() = default;

const FootprintReport& WaveletFootprints::report() const {
  return state_->report;
}

RenderResult WaveletFootprints::draw() {
  // Counting is no part of drawing, but where rays do it by the way.
  const bool count = state_->covers.empty() || !state_->exact_bands.empty();
  const auto picture = state_->drawn(count ? &state_->covers : nullptr);
  const auto& met = state_->covers;
  RenderResult result{blank_image(state_->options), {}, 0};
  std::size_t at = 0;
  for (int y = 0; y < state_->options.height; ++y) {
    for (int x = 0; x < state_->options.width; ++x, ++at) {
      if (state_->rays[static_cast<std::size_t>(y)].half[static_cast<std::size_t>(x)] < 0) continue;
      const auto value = static_cast<float>(picture[at]);
      if (!std::isfinite(value)) {
        throw Error("channel R reaches a value that float cannot hold; scale the volume");
      }
      for (int c = 0; c < 3; ++c) result.image.at(x, y, c) = value;
      result.image.at(x, y, 3) = 1;
      result.image.at(x, y, 4) = static_cast<float>(met[at]);
      ++result.counts.rays;
      result.counts.samples += met[at];
    }
  }
  result.error_estimate = state_->report.estimate;
  result.caster = "footprints";
  return result;
}

}  // namespace vol::render
