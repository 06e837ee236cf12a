#include "render/footprint_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "base/parallel.h"
#include "render/picture_tiles.h"
#include "wavelet/footprint.h"

namespace vol::render {
namespace {

constexpr int kChecks = 40;
/// Tables of more memory than this are not made.
constexpr std::int64_t kTableBytes = std::int64_t{1} << 30;
/// Standard deviations that none of 1e6 pixels exceeds; how many times the largest error of a single term;
/// and what the largest error of a term is taken for, of the largest one found at some hundred places:
/// footprints of rough functions have spikes that samples miss.
constexpr double kDeviations = 5, kLargest = 1.5, kMissed = 1.7;
/// Float's unit of rounding. Sums in float are off by some kFloat times the sum of their terms' magnitudes,
/// for which the largest values of footprints are taken: measured, 8 to 120 times less. What terms cancel, as
/// those of a constant do, does not make it less. Within kFloatShare of what is allowed, terms are added in
/// float.
constexpr double kFloat = 0x1p-24, kFloatShare = 0.1;
/// What exact integrals cost, nanoseconds a polynomial piece.
constexpr double kPieceTime = 25;
/// Of a footprint's largest value what is left out, as a share of the error asked for: the rest of a
/// footprint whose values have the size of its error is not worth the time; what that costs is measured with
/// the tables.
constexpr double kNegligible = 0.3;

/// Tables are made finer until their estimate is within this share of what is allowed, by what finer ones are
/// expected to have.
constexpr double kAim = 0.9;

/// Whether a term of a part may reach a pixel of a face.
bool reaches(const FootprintPart& part, const wavelet::Term& term, const std::vector<PixelRun>& face) {
  const auto p = part.centre_of(term);
  const int low = std::max(ceil_pixel(p[1] + part.reach[2]), 0);
  const int high = std::min(floor_pixel(p[1] + part.reach[3]), static_cast<int>(face.size()) - 1);
  for (int y = low; y <= high; ++y) {
    const PixelRun& run = face[static_cast<std::size_t>(y)];
    if (std::max(run.begin, ceil_pixel(p[0] + part.reach[0])) <
        std::min(run.end, floor_pixel(p[0] + part.reach[1]) + 1)) {
      return true;
    }
  }
  return false;
}

/// Groups of bands whose functions are continuous: their footprints, and those that are cut off at the faces.
void add_groups(const std::vector<const wavelet::Band*>& bands, FootprintPicture& picture) {
  const ParallelView& view = picture.view;
  const wavelet::Expansion& expansion = picture.expansion;
  auto& groups = picture.groups;
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
  std::map<std::array<int, 3>, double> peaks;
  for (const wavelet::Band* band : bands) {
    const auto [at, fresh] = by_functions.try_emplace(band->factor, groups.size());
    if (fresh) {
      FootprintGroup& group = groups.emplace_back();
      group.axis = along;
      group.lines = lines(*band, along);
      group.limits = {group.lines.z->upper()};
    }
    FootprintGroup& group = groups[at->second];
    if (fresh) peaks[band->factor] = peak_of(group.lines);
    group.parts.push_back(make_part(view, *band, along, -1, 0));
    group.parts.back().peak = peaks[band->factor];
  }
  for (const wavelet::Band* band : bands) {
    for (int cut = 0; cut < 2; ++cut) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto side = static_cast<std::size_t>(cut), across = static_cast<std::size_t>(axis);
        if (picture.windows.pixels[side][across] == 0) continue;
        FootprintGroup group;
        group.axis = axis;
        group.cut = cut;
        group.below = (cut == 0) == (d[axis] > 0);
        group.lines = lines(*band, axis);
        const double place = (view.face(cut, axis) + band->shift[axis]) / band->scale[axis];
        const double lower = band->lower[axis], upper = band->upper[axis];
        std::map<double, std::vector<wavelet::Term>> by_limit;
        for (const auto& term : band->terms) {
          const double limit = place - term.k[static_cast<std::size_t>(axis)];
          // A term that ends at the face is all of it outside: coiflets have their nodes on the grid.
          if (group.below ? limit > lower : limit < upper) {
            by_limit[std::clamp(limit, lower, upper)].push_back(term);
          }
        }
        for (auto& [limit, terms] : by_limit) {
          FootprintPart part = make_part(view, *band, axis, cut, limit);
          part.peak = peaks[band->factor] * std::abs(d[axis] / d[along]);
          part.table = group.limits.size();
          std::erase_if(terms, [&](const wavelet::Term& term) {
            return !reaches(part, term, picture.windows.rows[side][across]);
          });
          if (terms.empty()) continue;
          part.own_terms = std::move(terms);
          group.limits.push_back(limit);
          group.parts.push_back(std::move(part));
        }
        if (!group.parts.empty()) groups.push_back(std::move(group));
      }
    }
  }
}

/// What a picture of that error is likely to need at least.
int first_quality(double error) {
  return error >= 5e-3 ? 0 : error >= 5e-4 ? 2 : 3;
}

/// Exact integrals in place of a group's tables.
void give_up(FootprintGroup& group) {
  group.exact = true;
  group.tables.clear();
  for (auto& part : group.parts) part.drop_phases();
  group.rms = group.largest = 0;
}

/// Makes tables finer until the estimate is within what is allowed; groups for which that costs more than
/// exact integrals become exact. Whether there is a table left.
bool refine(double error, double allowed, FootprintPicture& picture, FootprintReport& report) {
  auto& groups = picture.groups;
  const PictureTiles tiles(picture.width, picture.height);
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
      const double face =
          group.cut < 0 ? 1e300
                        : static_cast<double>(picture.windows.pixels[static_cast<std::size_t>(group.cut)]
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
          pixels += std::min(face, 0.7 * within(p[0] + reach[0], p[0] + reach[1], picture.width) *
                                       within(p[1] + reach[2], p[1] + reach[3], picture.height));
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
  std::vector<int> wanted(groups.size(), first_quality(error));
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
        if (due[g]) make_tables(picture.expansion, picture.view, wanted[g], kNegligible * error, groups[g]);
      }
    });
    std::int64_t bytes = 0;
    for (const auto& group : groups) bytes += group.bytes();
    report.estimate = 0;
    std::fill(due.begin(), due.end(), false);
    for (std::size_t t = 0; t < tiles.none().size(); ++t) {
      double one = 0, two = 0, largest = 0;
      for (std::size_t g = 0; g < groups.size(); ++g) {
        one += sums[g][t].one * kMissed * groups[g].largest;
        two += sums[g][t].two * groups[g].rms * groups[g].rms;
        largest = std::max(largest, sums[g][t].largest * kMissed * groups[g].largest);
      }
      const double estimate = std::min(one, kDeviations * std::sqrt(two) + kLargest * largest);
      report.estimate = std::max(report.estimate, estimate);
      if (estimate <= allowed) continue;
      // Finer by one step the error is about a third. Those that matter most in this part of the picture.
      constexpr double kFiner = 1.0 / 3;
      std::vector<double> own(groups.size()), peak(groups.size());
      for (std::size_t g = 0; g < groups.size(); ++g) {
        const double finer = due[g] ? kFiner : 1;
        own[g] = sums[g][t].two * std::pow(finer * groups[g].rms, 2);
        peak[g] = finer * sums[g][t].largest * kMissed * groups[g].largest;
      }
      for (;;) {
        const auto most = std::max_element(own.begin(), own.end());
        const auto highest = std::max_element(peak.begin(), peak.end());
        const double spread = kDeviations * std::sqrt(std::accumulate(own.begin(), own.end(), 0.0));
        if (spread + kLargest * *highest <= kAim * allowed) break;
        const auto g = static_cast<std::size_t>(spread > kLargest * *highest ? most - own.begin()
                                                                             : highest - peak.begin());
        if (due[g]) break;  // it would take two steps
        due[g] = true;
        own[g] *= kFiner * kFiner;
        peak[g] *= kFiner;
      }
    }
    if (std::none_of(due.begin(), due.end(), [](bool b) { return b; })) break;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!due[g]) continue;
      wanted[g] = groups[g].quality + 1;
      if (bytes > kTableBytes) wanted[g] = kFootprintQualities;
    }
  }
  report.rounding = 0;
  for (std::size_t t = 0; t < tiles.none().size(); ++t) {
    double magnitudes = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (groups[g].exact) continue;
      magnitudes += sums[g][t].one * groups[g].parts[0].peak;
    }
    report.rounding = std::max(report.rounding, kFloat * magnitudes);
  }
  picture.in_float = report.rounding <= kFloatShare * report.allowed;
  return std::any_of(groups.begin(), groups.end(), [](const auto& group) { return !group.exact; });
}

/// Pixels integrated exactly, to find the picture's range and to compare it with.
class Checks {
 public:
  /// By a sequence that fills the picture evenly (Roberts 2018: powers of 1 / the plastic number).
  explicit Checks(const FootprintPicture& picture) : width_(picture.width) {
    for (int n = 1; n <= 50 * kChecks && checks_.size() < kChecks; ++n) {
      const auto place = [n](double step, int size) {
        const double p = 0.5 + step * n;
        return static_cast<int>((p - std::floor(p)) * size);
      };
      const int x = place(0.7548776662466927, picture.width), y = place(0.5698402909980532, picture.height);
      if (picture.misses(x, y)) {
        misses_ = true;
      } else {
        checks_.push_back({x, y, 0});
      }
    }
    parallel_for(0, static_cast<std::int64_t>(checks_.size()), 1, [&](std::int64_t from, std::int64_t to) {
      for (auto n = from; n < to; ++n) {
        Check& check = checks_[static_cast<std::size_t>(n)];
        const auto cast = picture.view.cast(check.x, check.y);
        std::int64_t terms = 0, pieces = 0;
        check.value = picture.xray.integral(cast->ray, cast->chord, terms, pieces);
      }
    });
  }

  [[nodiscard]] double range() const {
    double least = misses_ ? 0 : std::numeric_limits<double>::infinity(), most = misses_ ? 0 : -least;
    for (const Check& check : checks_) {
      least = std::min(least, check.value);
      most = std::max(most, check.value);
    }
    return most > least ? most - least : 0;
  }
  /// Largest error of a picture at these pixels.
  [[nodiscard]] double worst(const FootprintPicture& picture) const {
    const auto values = picture.values(nullptr);
    double found = 0;
    for (const Check& check : checks_) {
      const auto at = static_cast<std::size_t>(check.y) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(check.x);
      found = std::max(found, std::abs(values[at] - check.value));
    }
    return found;
  }

 private:
  struct Check {
    int x, y;
    double value;
  };
  int width_;
  std::vector<Check> checks_;
  bool misses_ = false;
};

std::int64_t count_terms(const std::vector<const wavelet::Band*>& bands) {
  std::int64_t sum = 0;
  for (const auto* band : bands) sum += static_cast<std::int64_t>(band->terms.size());
  return sum;
}

/// Whether products of two functions can draw the picture.
bool plan_products(const Checks& checks, FootprintPicture& picture, FootprintReport& report) {
  picture.products = AxisProducts::make(picture.expansion, picture.view, picture.rays, report.allowed);
  if (!picture.products) return false;
  const auto beside_faces = picture.exact_pixels;
  std::vector<std::array<int, 2>> beside_axis;
  report.estimate = picture.products->estimate();
  for (int y = 0; y < picture.height; ++y) {  // rays that pass a face beside the axis
    const PixelRow& row = picture.rays[static_cast<std::size_t>(y)];
    for (int x = 0; x < picture.width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      const int axis = picture.products->axis();
      if (row.half[i] >= 0 && (row.face[0][i] != axis || row.face[1][i] != axis)) {
        beside_axis.push_back({x, y});
      }
    }
  }
  picture.draw_exactly(beside_axis);
  report.found = checks.worst(picture);
  if (report.found <= report.allowed || report.allowed == 0) return true;
  picture.products.reset();  // its bound is not kept at a pixel that was integrated: tables, then
  picture.exact_pixels = beside_faces;
  report.estimate = report.found = 0;
  return false;
}

/// Tables for the groups there are; exact bands for those that are not worth it.
void plan_tables(double error, const Checks& checks, FootprintPicture& picture, FootprintReport& report) {
  auto& groups = picture.groups;
  auto& exact_bands = picture.exact_bands;
  double allowed = report.allowed;
  for (int trial = 0; !groups.empty(); ++trial, allowed /= 4) {
    if (trial == 3 || !refine(error, allowed, picture, report)) {
      for (auto& group : groups) give_up(group);
      report.estimate = 0;
    }
    // Bands that are exact as a whole need no cuts.
    for (const auto& group : groups) {
      if (group.cut >= 0 || !group.exact) continue;
      for (const auto& part : group.parts) exact_bands.push_back(part.band);
    }
    std::erase_if(groups, [&](const FootprintGroup& group) {
      if (group.cut < 0) return group.exact;
      return std::find(exact_bands.begin(), exact_bands.end(), group.parts[0].band) != exact_bands.end();
    });
    report.found = checks.worst(picture);
    if (report.found > report.allowed && picture.in_float) {  // double is cheaper than finer tables
      picture.in_float = false;
      report.found = checks.worst(picture);
    }
    if (report.found <= report.allowed) break;
  }
  for (auto& group : groups) {
    report.tables += static_cast<std::int64_t>(group.tables.size());
    const auto has_phases = [](const FootprintPart& part) { return part.phases.has_value(); };
    if (std::all_of(group.parts.begin(), group.parts.end(), has_phases)) group.tables.clear();
    report.table_bytes += group.bytes();
    for (auto& part : group.parts) {
      part.even_lines = part.rough_lines = {};
      if (group.cut < 0) report.terms_tables += static_cast<std::int64_t>(part.terms().size());
    }
  }
}

}  // namespace

FootprintReport plan_footprints(double error, FootprintPicture& picture) {
  FootprintReport report;
  const wavelet::Expansion& expansion = picture.expansion;
  std::vector<const wavelet::Band*> all;
  for (const auto& band : expansion.bands()) all.push_back(&band);
  if (is_haar(expansion)) {
    picture.cells = make_octant_cells(expansion);
    report.terms_boxes = count_terms(all);
    return report;
  }
  const Checks checks(picture);
  report.range = checks.range();
  report.allowed = error * report.range;
  if (plan_products(checks, picture, report)) {
    report.terms_products = count_terms(all);
    return report;
  }
  std::vector<const wavelet::Band*> bands;
  for (const auto* band : all) {
    bool smooth = true;
    for (std::size_t a = 0; a < 3; ++a) {
      smooth &= band->scale[static_cast<Eigen::Index>(a)] == band->scale[0];
      smooth &= wavelet::continuous(expansion.function(band->factor[a]));
    }
    (smooth && report.allowed > 0 ? bands : picture.exact_bands).push_back(band);
  }
  add_groups(bands, picture);
  plan_tables(error, checks, picture, report);
  report.terms_exact = count_terms(picture.exact_bands);
  return report;
}

}  // namespace vol::render
