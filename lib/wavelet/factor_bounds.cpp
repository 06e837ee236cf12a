#include "wavelet/factor_bounds.h"

#include <algorithm>
#include <cmath>

namespace vol::wavelet {
namespace {

constexpr double kRounding = 1e-13;
constexpr double kReach = 1e-9;  // intervals are widened by that many knots, so that none is lost to rounding

/// Largest |f|, |f'|, |f''| of a piece, exactly.
std::array<double, 3> largest_of(const std::array<double, 4>& a) {
  const auto value = [&](double v) { return std::abs(a[0] + v * (a[1] + v * (a[2] + v * a[3]))); };
  const auto slope = [&](double v) { return std::abs(a[1] + v * (2 * a[2] + v * 3 * a[3])); };
  std::array<double, 3> result{std::max(value(0), value(1)), std::max(slope(0), slope(1)),
                               std::max(std::abs(2 * a[2]), std::abs(2 * a[2] + 6 * a[3]))};
  const double flat = -a[2] / (3 * a[3]);  // where f'' = 0
  if (flat > 0 && flat < 1) result[1] = std::max(result[1], slope(flat));
  // f' = 0: 3 a3 v^2 + 2 a2 v + a1, by the form that cancels nothing.
  const double under = a[2] * a[2] - 3 * a[3] * a[1];
  if (under >= 0) {
    const double q = -(a[2] + std::copysign(std::sqrt(under), a[2]));
    for (const double v : {q / (3 * a[3]), a[1] / q}) {
      if (v > 0 && v < 1) result[0] = std::max(result[0], value(v));
    }
  }
  return result;
}

double value_at_end(const std::array<double, 4>& a) {
  return a[0] + a[1] + a[2] + a[3];
}
double slope_at_end(const std::array<double, 4>& a) {
  return a[1] + 2 * a[2] + 3 * a[3];
}

std::ptrdiff_t wrapped(std::ptrdiff_t i, std::ptrdiff_t n) {
  return (i % n + n) % n;
}

}  // namespace

FactorBounds::FactorBounds(const PiecewiseCubic& f, bool periodic)
    : f_(&f), periodic_(periodic), count_(static_cast<std::ptrdiff_t>(f.pieces.size())) {
  const std::size_t n = f.pieces.size();
  largest_.assign(2 * n, {0, 0, 0});
  for (std::size_t i = 0; i < n; ++i) largest_[n + i] = largest_of(f.pieces[i]);
  for (std::size_t i = n; i-- > 1;) {
    for (std::size_t k = 0; k < 3; ++k) {
      largest_[i][k] = std::max(largest_[2 * i][k], largest_[2 * i + 1][k]);
    }
  }
  widen(whole_, 0, count_ - 1);
  // Knot i is where piece i begins; a periodic function's last knot is its first again.
  jumps_.push_back({0, 0});
  for (std::size_t i = 0; i <= n - (periodic ? 1 : 0); ++i) {
    const std::array<double, 4> nothing{};
    const auto& before = i > 0 ? f.pieces[i - 1] : periodic ? f.pieces[n - 1] : nothing;
    const auto& behind = i < n ? f.pieces[i] : nothing;
    const double jump = std::abs(behind[0] - value_at_end(before));
    const double kink = std::abs(behind[1] - slope_at_end(before));
    jumps_.push_back({jumps_.back()[0] + (jump > kRounding * whole_.value ? jump : 0),
                      jumps_.back()[1] + (kink > kRounding * whole_.slope ? kink : 0)});
  }
  whole_.jump = jumps_.back()[0];
  whole_.kink = jumps_.back()[1];
}

const std::array<double, 4>* FactorBounds::piece(double q, double& v) const {
  const double i = std::floor(q);
  v = q - i;
  const auto n = static_cast<double>(count_);
  if (periodic_) {
    const double at = i - n * std::floor(i / n);
    return &f_->pieces[static_cast<std::size_t>(std::min(at, n - 1))];
  }
  if (!(i >= 0 && i < n)) return nullptr;
  return &f_->pieces[static_cast<std::size_t>(i)];
}

void FactorBounds::widen(FactorBound& bound, std::ptrdiff_t first, std::ptrdiff_t last) const {
  const auto take = [&](std::ptrdiff_t node) {
    const Largest& l = largest_[static_cast<std::size_t>(node)];
    bound.value = std::max(bound.value, l[0]);
    bound.slope = std::max(bound.slope, l[1]);
    bound.bend = std::max(bound.bend, l[2]);
  };
  std::ptrdiff_t low = first + count_, high = last + 1 + count_;
  for (; low < high; low /= 2, high /= 2) {
    if (low % 2 == 1) take(low++);
    if (high % 2 == 1) take(--high);
  }
}

void FactorBounds::widen_by_part(FactorBound& bound, std::ptrdiff_t piece, double from, double to) const {
  const auto& a = f_->pieces[static_cast<std::size_t>(piece)];
  const double v = 0.5 * (from + to), r = 0.5 * (to - from);
  const double c0 = std::abs(a[0] + v * (a[1] + v * (a[2] + v * a[3])));
  const double c1 = std::abs(a[1] + v * (2 * a[2] + v * 3 * a[3]));
  const double c2 = std::abs(a[2] + v * 3 * a[3]);
  const double c3 = std::abs(a[3]);
  const Largest& all = largest_[static_cast<std::size_t>(piece + count_)];
  bound.value = std::max(bound.value, std::min(all[0], c0 + r * (c1 + r * (c2 + r * c3))));
  bound.slope = std::max(bound.slope, std::min(all[1], c1 + r * (2 * c2 + r * 3 * c3)));
  bound.bend = std::max(bound.bend, std::min(all[2], 2 * c2 + r * 6 * c3));
}

void FactorBounds::add_jumps(FactorBound& bound, std::ptrdiff_t first, std::ptrdiff_t last) const {
  const auto knots = static_cast<std::ptrdiff_t>(jumps_.size()) - 1;
  first = std::max<std::ptrdiff_t>(first, 0);
  last = std::min(last, knots - 1);
  if (first > last) return;
  const auto& before = jumps_[static_cast<std::size_t>(first)];
  const auto& behind = jumps_[static_cast<std::size_t>(last + 1)];
  bound.jump += behind[0] - before[0];
  bound.kink += behind[1] - before[1];
}

FactorBound FactorBounds::on(double from, double to) const {
  from -= kReach;
  to += kReach;
  FactorBound bound;
  const auto n = static_cast<double>(count_);
  if (!periodic_) {
    if (!(to >= 0) || !(from <= n)) return bound;
    if (from <= 0 && to >= n) return whole_;
  } else if (!(to - from < n - 1)) {
    const double periods = std::ceil((to - from) / n);
    bound = whole_;
    bound.jump *= periods;
    bound.kink *= periods;
    return bound;
  }
  const auto first = static_cast<std::ptrdiff_t>(std::floor(from));
  const auto last = static_cast<std::ptrdiff_t>(std::floor(to));
  const auto part = [&](std::ptrdiff_t i) {
    if (!periodic_ && (i < 0 || i >= count_)) return;
    const auto start = static_cast<double>(i);
    widen_by_part(bound, wrapped(i, count_), std::max(from - start, 0.0), std::min(to - start, 1.0));
  };
  part(first);
  if (last > first) part(last);
  // Whole pieces between, and knots: of a periodic function in two parts where they go over its end.
  const auto ranges = [&](std::ptrdiff_t low, std::ptrdiff_t high, const auto& f) {
    if (low > high) return;
    const std::ptrdiff_t begin = wrapped(low, count_), end = begin + (high - low);
    f(begin, std::min(end, count_ - 1));
    if (end >= count_) f(0, end - count_);
  };
  if (periodic_) {
    ranges(first + 1, last - 1, [&](std::ptrdiff_t b, std::ptrdiff_t e) { widen(bound, b, e); });
    ranges(first + 1, last, [&](std::ptrdiff_t b, std::ptrdiff_t e) { add_jumps(bound, b, e); });
  } else {
    widen(bound, std::max<std::ptrdiff_t>(first + 1, 0), std::min(last - 1, count_ - 1));
    add_jumps(bound, first + 1, last);
  }
  return bound;
}

}  // namespace vol::wavelet
