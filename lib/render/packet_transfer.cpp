#include "render/packet_transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

namespace vol::render {
namespace {

constexpr std::int32_t kFewestBuckets = 1024;
constexpr std::int32_t kMostBuckets = 65536;
constexpr std::int32_t kMostForExtinction = 16384;

/// Smallest number of buckets >= kFewestBuckets that is a multiple of the number of integers in the range.
std::int32_t first_count(double range, bool integral) {
  if (!integral || range < 1 || range > kMostForExtinction) return kFewestBuckets;
  const auto integers = static_cast<std::int32_t>(range);
  return integers * ((kFewestBuckets + integers - 1) / integers);
}

struct Line {
  double opacity0, opacity1;  ///< extrapolated to the bucket's ends
  double y0, y1;              ///< chord of log2(1 - opacity), the same
  Vec3 colour0, colour1;
  double used0, used1;  ///< opacities at the ends of the part in use
  bool straight;        ///< y is accurate enough as the chord
};

/// The interval's line over a bucket [a, b] of values, used in [from, to] of it.
Line line_over(const OpticsInterval& interval, double a, double b, double from, double to) {
  const auto extrapolated = [&](double v0, double v1) {  // values at from, to
    const double w0 = (a - from) / (to - from), w1 = (b - from) / (to - from);
    return std::pair(v0 + w0 * (v1 - v0), v0 + w1 * (v1 - v0));
  };
  Line line{};
  const double o0 = interval.opacity(from), o1 = interval.opacity(to);
  if (to > from) {
    std::tie(line.opacity0, line.opacity1) = extrapolated(o0, o1);
    const Vec3 c0 = interval.colour(from), c1 = interval.colour(to);
    for (int c = 0; c < 3; ++c) std::tie(line.colour0[c], line.colour1[c]) = extrapolated(c0[c], c1[c]);
    // The chord of -log(1 - a) errs by an eighth of its second derivative, at most q^2, q = da / (1 - a).
    std::tie(line.y0, line.y1) = extrapolated(std::log2(1 - o0), std::log2(1 - o1));
    line.used0 = o0;
    line.used1 = o1;
    const double most = extinction_error(0.5 * (o0 + o1));
    const double q = (o1 - o0) / (1 - std::max(o0, o1));
    line.straight = std::max(o0, o1) < 1 && q * q / 8 <= most;
  } else {
    const double y = std::log2(1 - o0);
    line = {o0, o0, y, y, interval.colour(from), interval.colour(from), o0, o0, o0 < 1};
  }
  return line;
}

/// False where a bucket would hold two points. `fine` tells whether extinctions may be stored as lines.
bool fill(const Optics& optics, double lo, double hi, std::int32_t buckets, PacketTransfer& table,
          bool& fine) {
  const double width = (hi - lo) / buckets;
  const auto& points = optics.transfer().breakpoints();
  table.split = false;
  table.splits.assign(static_cast<std::size_t>(buckets), std::numeric_limits<float>::infinity());
  std::vector<Line> lines(static_cast<std::size_t>(2 * buckets));
  for (std::int32_t b = 0; b < buckets; ++b) {
    const double from = lo + b * width, to = b + 1 < buckets ? lo + (b + 1) * width : hi;
    const auto inside = std::upper_bound(points.begin(), points.end(), from);
    const bool has_point = inside != points.end() && *inside < to;
    if (has_point && inside + 1 != points.end() && *(inside + 1) < to) return false;
    const auto k = static_cast<std::size_t>(inside - points.begin());
    const double split = has_point ? *inside : to;
    auto& left = lines[static_cast<std::size_t>(b)];
    auto& right = lines[static_cast<std::size_t>(b + buckets)];
    left = right = line_over(optics.intervals()[k], from, to, from, split);
    if (has_point) {
      right = line_over(optics.intervals()[k + 1], from, to, split, to);
      table.splits[static_cast<std::size_t>(b)] = static_cast<float>(split);
      table.split = true;
    } else if (b + 1 == buckets && inside != points.end() && *inside == to) {
      // The largest value is a point itself: there the interval above holds.
      right = line_over(optics.intervals()[k + 1], from, to, to, to);
      table.splits[static_cast<std::size_t>(b)] = static_cast<float>(to);
      table.split = optics.intervals()[k + 1].opacity_lo != optics.intervals()[k].opacity_hi ||
                    optics.intervals()[k + 1].colour_lo != optics.intervals()[k].colour_hi || table.split;
    }
  }
  fine = std::all_of(lines.begin(), lines.end(), [](const Line& line) { return line.straight; });
  const std::size_t stride = fine ? 2 : 4;
  table.logarithm = !fine;
  table.extinctions = Buffer<float>(stride * lines.size());
  table.colours = Buffer<float>(6 * lines.size());
  table.opaque = table.dense = false;
  double steepest = 0;
  const auto put = [](float* at, double v0, double v1) {
    at[0] = static_cast<float>(v0);
    at[1] = static_cast<float>(v1 - v0);
  };
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const Line& line = lines[l];
    float* at = table.extinctions.data() + stride * l;
    if (fine) {
      const double e = table.exponent;
      put(at, line.y0 * e, line.y1 * e);
    } else {
      put(at, line.opacity0, line.opacity1);
      put(at + 2, 1 - line.opacity0, 1 - line.opacity1);
    }
    table.opaque = table.opaque || std::max(line.opacity0, line.opacity1) >= 1;
    table.dense = table.dense || std::max(line.opacity0, line.opacity1) > 0.9;
    const double most = std::max({line.used0, line.used1, 0.0});
    steepest = std::min(steepest, most < 1 ? std::log2(1 - most) : -1e30);
    for (int c = 0; c < 3; ++c) put(table.colours.data() + 6 * l + 2 * c, line.colour0[c], line.colour1[c]);
  }
  table.steepest = static_cast<float>(std::max(-1e30, steepest)) * table.exponent;
  return true;
}

/// Colour as one line over the whole range, if it is one.
void find_affine(const Optics& optics, double lo, double hi, PacketTransfer& table) {
  const auto& transfer = optics.transfer();
  const Vec3 c0 = transfer.colour(lo);
  const Vec3 c1 =
      hi > lo ? Vec3(optics.intervals()[optics.interval_of(std::nextafter(hi, lo))].colour(hi)) : c0;
  table.affine = transfer.colour(hi) == c1;
  for (const auto& point : transfer.colours()) {
    if (point.value <= lo || point.value >= hi) continue;
    const Vec3 on_line = c0 + (point.value - lo) / (hi - lo) * (c1 - c0);
    if ((point.rgb - on_line).cwiseAbs().maxCoeff() > 1e-12) table.affine = false;
  }
  for (int c = 0; c < 3; ++c) {
    table.colour0[c] = static_cast<float>(c0[c]);
    table.colour1[c] = static_cast<float>((c1[c] - c0[c]) / table.buckets);
  }
}

/// The first float that is not below a value.
float float_from(double value) {
  const auto nearest = static_cast<float>(value);
  return nearest < value ? std::nextafter(nearest, INFINITY) : nearest;
}

/// Extinction in few pieces, where it has few and single precision holds them.
void find_ramps(const Optics& optics, double lo, double hi, PacketTransfer& table) {
  const std::vector<ExtinctionPiece> found = extinction_pieces(optics, lo, hi, kMaxLanes);
  table.ramps = static_cast<int>(found.size());
  table.ramp_scale = static_cast<float>(1 / (hi - lo));
  std::fill(std::begin(table.ramp_from), std::end(table.ramp_from), INFINITY);
  bool finite = true;
  for (std::size_t k = 0; k < found.size(); ++k) {
    table.ramp_from[k] = float_from(found[k].from);
    table.ramp_origin[k] = static_cast<float>(found[k].origin);
    // The coefficients are those around the rounded origin.
    const auto origin = static_cast<double>(table.ramp_origin[k]);
    const ExtinctionPiece piece = found[k].around(origin, (origin - found[k].origin) / (hi - lo));
    for (int j = 0; j <= ExtinctionPiece::kDegree; ++j) {
      table.ramp[j][k] = static_cast<float>(piece.coefficient[j] * table.exponent);
      finite = finite && std::isfinite(table.ramp[j][k]);
    }
  }
  if (!finite) table.ramps = 0;
}

/// The pieces of a colour that has few; the largest value, if it is a point, has one of its own.
void find_pieces(const transfer::TransferFunction& transfer, double lo, double hi, PacketTransfer& table) {
  std::vector<double> starts{lo};
  for (const auto& point : transfer.colours()) {
    if (point.value > starts.back() && point.value <= hi) starts.push_back(point.value);
  }
  table.pieces = 0;
  if (table.affine || starts.size() > PacketTransfer::kFewPieces) return;
  table.pieces = static_cast<int>(starts.size());
  std::fill(std::begin(table.from), std::end(table.from), INFINITY);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    // From two places inside: at its ends the colour may jump.
    const double third = ((k + 1 < starts.size() ? starts[k + 1] : hi) - starts[k]) / 3;
    const Vec3 first = transfer.colour(starts[k] + third), second = transfer.colour(starts[k] + 2 * third);
    const Vec3 slope = third > 0 ? Vec3((second - first) / third) : Vec3::Zero();
    // The first float of the piece, and its colour there.
    table.from[k] = float_from(starts[k]);
    const double before = starts[k] + third - static_cast<double>(table.from[k]);
    for (int c = 0; c < 3; ++c) {
      table.at[c][k] = static_cast<float>(first[c] - before * slope[c]);
      table.slope[c][k] = static_cast<float>(slope[c]);
    }
  }
}

/// 1 - opacity at the cuts of an interval, from end to end: each at most kRatio times its neighbour. A ramp
/// that reaches opacity 1 has one more piece, below kLeast, where extinction goes to infinity as a logarithm
/// does.
std::vector<double> clear_at_cuts(double clear0, double clear1) {
  constexpr double kRatio = 1.5, kLeast = 0x1p-20;
  if (std::max(clear0, clear1) < kLeast) return {clear0, clear1};
  std::vector<double> clear;
  if (clear0 < kLeast) clear.push_back(clear0);
  const double from = std::max(clear0, kLeast), to = std::max(clear1, kLeast);
  const int pieces =
      std::max(1, static_cast<int>(std::ceil(std::abs(std::log(to / from)) / std::log(kRatio) - 1e-9)));
  for (int p = 0; p <= pieces; ++p) clear.push_back(from * std::pow(to / from, double(p) / pieces));
  clear1 < kLeast ? clear.push_back(clear1) : void(clear.back() = clear1);
  return clear;
}

/// Where preintegrated segments and the cells of split are cut, from every interval that meets the data's
/// range.
void set_cuts(const Optics& optics, double lo, double hi, PacketTransfer& table) {
  constexpr double kDensest =
      -26;  // log2(1 - opacity), mean over the last piece of a ramp up to 1 and beyond
  std::vector<float> cuts, clarity;
  table.densest = static_cast<float>(kDensest * table.exponent);
  for (const OpticsInterval& interval : optics.intervals()) {
    if (interval.hi < lo) continue;
    // Only what the data reach: beyond, opacity may be 1.
    const double from = std::max(interval.lo, lo), to = std::min(interval.hi, hi);
    const double opacity0 = interval.opacity(from), opacity1 = interval.opacity(to);
    if (interval.opaque()) {
      clarity.push_back(0);
      cuts.push_back(static_cast<float>(interval.hi));
    } else {
      const std::vector<double> clear = clear_at_cuts(1 - opacity0, 1 - opacity1);
      for (std::size_t p = 0; p + 1 < clear.size(); ++p) {
        const double steepest =
            table.exponent * std::max(kDensest, std::log2(std::min(clear[p], clear[p + 1])));
        clarity.push_back(steepest < 0 ? static_cast<float>(std::min(1e30, -1 / steepest)) : 1e30F);
        const double place = (1 - clear[p + 1] - opacity0) / (opacity1 - opacity0);
        cuts.push_back(static_cast<float>(p + 2 < clear.size() ? from + place * (to - from) : interval.hi));
      }
    }
    if (interval.hi > hi) break;
  }
  const auto& intervals = optics.intervals();
  table.peaks.clear();
  for (std::size_t k = 0; k + 1 < intervals.size(); ++k) {
    if ((intervals[k].opacity_hi == 1 || intervals[k + 1].opacity_lo == 1) && !intervals[k].opaque() &&
        !intervals[k + 1].opaque()) {
      table.peaks.push_back(static_cast<float>(intervals[k].hi));
    }
  }
  cuts.back() = std::numeric_limits<float>::infinity();
  table.cuts.assign(cuts.begin(), cuts.end());
  table.clarity.assign(clarity.begin(), clarity.end());
  table.intervals = cuts.size() <= kMaxLanes ? static_cast<int>(cuts.size()) : 0;
  std::fill(std::begin(table.beneath), std::end(table.beneath), INFINITY);
  table.beneath[0] = -INFINITY;
  for (std::size_t k = 0; k < static_cast<std::size_t>(table.intervals); ++k) {
    if (k > 0) table.beneath[k] = cuts[k - 1];
    table.above[k] = cuts[k];
    table.clear_for[k] = clarity[k];
  }
  table.first_cut = Buffer<std::int32_t>(static_cast<std::size_t>(table.buckets));
  std::int32_t k = 0;
  for (std::int32_t b = 0; b < table.buckets; ++b) {
    // A value's bucket is found by float arithmetic: start one bucket early.
    const double start = lo + (b - 1) * (hi - lo) / table.buckets;
    while (cuts[static_cast<std::size_t>(k)] <= start) ++k;
    table.first_cut[static_cast<std::size_t>(b)] = k;
  }
}

}  // namespace

bool tabulate(const Optics& optics, const index::Macrocells::Range& range, bool integral, double steps,
              PacketRule rule, PacketTransfer& table) {
  const bool trapezoid = rule == PacketRule::trapezoid;
  const double lo = range.min;
  // A constant volume gets a range of its own, so that a bucket has a width.
  const double hi = range.max > range.min ? double(range.max) : lo + std::max(1.0, std::abs(lo));
  table.exponent = static_cast<float>(trapezoid ? 0.5 * steps : steps);
  const std::int32_t fewest = first_count(hi - lo, integral);
  std::int32_t buckets = 0;
  bool fine = false;
  for (buckets = fewest; buckets <= kMostForExtinction; buckets *= 2) {
    if (fill(optics, lo, hi, buckets, table, fine) && fine) break;
  }
  if (buckets > kMostForExtinction) {  // logarithms: as coarse as the points allow
    buckets = fewest;
    while (!fill(optics, lo, hi, buckets, table, fine)) {
      buckets *= 2;
      if (buckets > kMostBuckets) return false;
    }
  }
  table.buckets = buckets;
  table.lo = range.min;
  table.hi = range.max;
  table.scale = static_cast<float>(buckets / (hi - lo));
  table.last = std::nextafterf(static_cast<float>(buckets), 0.0F);
  if (trapezoid) table.steepest *= 2;
  find_affine(optics, lo, hi, table);
  if (table.affine) table.colours = Buffer<float>();
  find_pieces(optics.transfer(), lo, hi, table);
  find_ramps(optics, lo, hi, table);
  if (!std::isfinite(table.scale)) return false;
  if (rule != PacketRule::preintegrated && rule != PacketRule::split) return true;
  if (table.opaque && rule == PacketRule::preintegrated) return false;
  set_cuts(optics, lo, hi, table);
  return true;
}

}  // namespace vol::render
