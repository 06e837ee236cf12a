#include "wavelet/line_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vol::wavelet {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where a line is in a box, on the axes that count; in > out: nowhere.
struct Stretch {
  double in, out;
};
Stretch clipped(const Box3& box, const std::array<bool, 3>& counts, const Vec3& origin, const Vec3& direction,
                double begin, double end) {
  Stretch s{begin, end};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    if (!counts[i]) continue;
    if (direction[a] == 0) {
      if (origin[a] < box.min[a] || origin[a] > box.max[a]) return {kInfinity, -kInfinity};
      continue;
    }
    const double near = (box.min[a] - origin[a]) / direction[a];
    const double far = (box.max[a] - origin[a]) / direction[a];
    s.in = std::max(s.in, std::min(near, far));
    s.out = std::min(s.out, std::max(near, far));
  }
  return s;
}

}  // namespace

LineField::LineField(const LineTerms& terms) : terms_(terms) {}

void LineField::set(const Vec3& origin, const Vec3& direction, double begin, double end) {
  active_.clear();
  slots_.clear();
  tracks_.clear();
  now_ = 0;
  for (std::uint32_t b = 0; b < terms_.bands().size(); ++b) gather(b, origin, direction, begin, end);
}

void LineField::gather(std::uint32_t number, const Vec3& origin, const Vec3& direction, double begin,
                       double end) {
  const LineTerms::BandTerms& own = terms_.bands()[number];
  std::array<bool, 3> counts{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    const LineTerms::Axis& axis = own.axes[i];
    counts[i] = !axis.factor->periodic();
    tracks_.push_back({axis.factor, axis.first + origin[a] * axis.per_index, direction[a] * axis.per_index});
  }
  // Rounding takes no term from its own ends: they are 1e-9 of the line longer.
  const double reach = 1e-9 * (end - begin);
  std::array<std::int32_t, 3> least, most;
  least.fill(std::numeric_limits<std::int32_t>::max());
  most.fill(std::numeric_limits<std::int32_t>::min());
  const auto first = active_.size();
  std::vector<std::array<std::int32_t, 3>> places;
  const auto take = [&](const Term& term) {
    const Stretch s = clipped(own.band->box(term), counts, origin, direction, begin, end);
    active_.push_back({term.c, number, {}, s.in - reach, s.out + reach});
    places.push_back(term.k);
    for (std::size_t a = 0; a < 3; ++a) {
      least[a] = std::min(least[a], term.k[a]);
      most[a] = std::max(most[a], term.k[a]);
    }
  };
  const auto meets = [&](const Box3& box) {
    const Stretch s = clipped(box, counts, origin, direction, begin, end);
    return s.in <= s.out;
  };
  if (own.periodic()) {
    for (const Term& term : own.terms) {
      if (meets(own.band->box(term))) take(term);
    }
  } else {
    own.band->visit(meets, take);
  }
  visited_ += static_cast<std::int64_t>(places.size());
  if (places.empty()) return;
  // A slot for every k in between, whether a term has it or not: as many as the line is long.
  std::array<std::size_t, 3> start{};
  for (std::size_t a = 0; a < 3; ++a) {
    start[a] = slots_.size();
    for (std::int64_t k = least[a]; k <= most[a]; ++k) {
      Slot& slot = slots_.emplace_back();
      slot.band_axis = 3 * number + static_cast<std::uint32_t>(a);
      slot.q0 = tracks_[slot.band_axis].q0 - static_cast<double>(k) * own.axes[a].knots;
    }
  }
  for (std::size_t n = 0; n < places.size(); ++n) {
    for (std::size_t a = 0; a < 3; ++a) {
      active_[first + n].factor[a] =
          static_cast<std::uint32_t>(start[a] + static_cast<std::size_t>(places[n][a] - least[a]));
    }
  }
}

void LineField::narrow(List& list, std::size_t from, std::size_t to, double a, double b) const {
  for (std::size_t n = from; n < to; ++n) {
    const Active& term = active_[list[n]];
    if (term.in <= b && term.out >= a) list.push_back(list[n]);
  }
}

const LineField::Slot& LineField::sampled(std::uint32_t number, double t) {
  Slot& slot = slots_[number];
  if (slot.sampled == now_) return slot;
  slot.sampled = now_;
  const Track& track = tracks_[slot.band_axis];
  double v = 0;
  const auto* a = track.factor->piece(slot.q0 + t * track.dq, v);
  if (a == nullptr) {
    slot.value = slot.slope = 0;
  } else {
    const auto& c = *a;
    slot.value = c[0] + v * (c[1] + v * (c[2] + v * c[3]));
    slot.slope = c[1] + v * (2 * c[2] + v * 3 * c[3]);  // a knot
  }
  return slot;
}

LineField::Sample LineField::at(double t, const List& list, std::size_t from, std::size_t to) {
  ++now_;
  visited_ += static_cast<std::int64_t>(to - from);
  Sample sum;
  for (std::size_t n = from; n < to; ++n) {
    const Active& term = active_[list[n]];
    const Slot& x = sampled(term.factor[0], t);
    const Slot& y = sampled(term.factor[1], t);
    const Slot& z = sampled(term.factor[2], t);
    const Track* track = &tracks_[std::size_t{3} * term.band];
    const double yz = y.value * z.value;
    sum.f += term.c * x.value * yz;
    sum.slope += term.c * (track[0].dq * x.slope * yz +
                           x.value * (track[1].dq * y.slope * z.value + track[2].dq * y.value * z.slope));
  }
  return sum;
}

Vec3 LineField::gradient(double t, const List& list, std::size_t from, std::size_t to, Vec3* size) {
  ++now_;
  visited_ += static_cast<std::int64_t>(to - from);
  Vec3 sum = Vec3::Zero();
  if (size != nullptr) *size = Vec3::Zero();
  for (std::size_t n = from; n < to; ++n) {
    const Active& term = active_[list[n]];
    const Slot& x = sampled(term.factor[0], t);
    const Slot& y = sampled(term.factor[1], t);
    const Slot& z = sampled(term.factor[2], t);
    const auto& axes = terms_.bands()[term.band].axes;
    const Vec3 slope = term.c * Vec3(axes[0].per_index * x.slope * y.value * z.value,
                                     axes[1].per_index * x.value * y.slope * z.value,
                                     axes[2].per_index * x.value * y.value * z.slope);
    sum += slope;
    if (size != nullptr) *size += slope.cwiseAbs();
  }
  return sum;
}

const LineField::Slot& LineField::bounded(std::uint32_t number, double a, double b) {
  Slot& slot = slots_[number];
  if (slot.bounded == now_) return slot;
  slot.bounded = now_;
  const Track& track = tracks_[slot.band_axis];
  const double p = slot.q0 + a * track.dq, q = slot.q0 + b * track.dq;
  slot.bound = track.factor->on(std::min(p, q), std::max(p, q));
  const double speed = std::abs(track.dq);
  slot.bound.slope *= speed;
  slot.bound.bend *= speed * speed;
  slot.bound.kink *= speed;
  if (speed == 0) slot.bound.jump = 0;  // along a knot nothing jumps
  return slot;
}

LineField::Bound LineField::bound(double a, double b, const List& list, std::size_t from, std::size_t to) {
  ++now_;
  visited_ += static_cast<std::int64_t>(to - from);
  Bound sum;
  for (std::size_t n = from; n < to; ++n) {
    const Active& term = active_[list[n]];
    const FactorBound& x = bounded(term.factor[0], a, b).bound;
    const FactorBound& y = bounded(term.factor[1], a, b).bound;
    const FactorBound& z = bounded(term.factor[2], a, b).bound;
    const double c = std::abs(term.c);
    const double yz = y.value * z.value, y_z = y.slope * z.value + y.value * z.slope;
    sum.size += c * x.value * yz;
    sum.slope += c * (x.slope * yz + x.value * y_z);
    sum.bend += c * (x.bend * yz + 2 * x.slope * y_z +
                     x.value * (y.bend * z.value + 2 * y.slope * z.slope + y.value * z.bend));
    sum.jump += c * (x.jump * yz + x.value * (y.jump * z.value + y.value * z.jump));
    sum.kink += c * (x.kink * yz + x.value * (y.kink * z.value + y.value * z.kink));
  }
  return sum;
}

std::optional<double> LineField::middle_knot(double a, double b, const List& list, std::size_t from,
                                             std::size_t to) const {
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  double nearest = kInfinity;
  std::uint32_t last = std::numeric_limits<std::uint32_t>::max();
  for (std::size_t n = from; n < to; ++n) {
    const std::uint32_t band = active_[list[n]].band;
    if (band == last) continue;  // the knots of all k are the same
    last = band;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Track& track = tracks_[std::size_t{3} * band + axis];
      if (track.dq == 0) continue;
      const double q = track.q0 + middle * track.dq;
      const double away = (std::round(q) - q) / track.dq;
      // What is within 1e-9 knots of an end is that end.
      if ((half - std::abs(away)) * std::abs(track.dq) > 1e-9 && std::abs(away) < std::abs(nearest))
        nearest = away;
    }
  }
  if (nearest == kInfinity) return std::nullopt;
  return middle + nearest;
}

const LineField::Slot& LineField::expanded(std::uint32_t number, double a, double b) {
  Slot& slot = slots_[number];
  if (slot.expanded == now_) return slot;
  slot.expanded = now_;
  const Track& track = tracks_[slot.band_axis];
  double v = 0;
  const auto* piece = track.factor->piece(slot.q0 + 0.5 * (a + b) * track.dq, v);
  slot.cubic = {0, 0, 0, 0};
  if (piece != nullptr) {
    const auto& c = *piece;
    const double h = track.dq * (b - a);
    slot.cubic = {c[0] + v * (c[1] + v * (c[2] + v * c[3])), h * (c[1] + v * (2 * c[2] + v * 3 * c[3])),
                  h * h * (c[2] + v * 3 * c[3]), h * h * h * c[3]};
  }
  return slot;
}

std::array<double, 10> LineField::polynomial(double a, double b, const List& list, std::size_t from,
                                             std::size_t to) {
  ++now_;
  visited_ += static_cast<std::int64_t>(to - from);
  std::array<double, 10> sum{};
  for (std::size_t n = from; n < to; ++n) {
    const Active& term = active_[list[n]];
    const auto& x = expanded(term.factor[0], a, b).cubic;
    const auto& y = expanded(term.factor[1], a, b).cubic;
    const auto& z = expanded(term.factor[2], a, b).cubic;
    std::array<double, 7> xy{};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) xy[i + j] += x[i] * y[j];
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const double cz = term.c * z[k];
      for (std::size_t i = 0; i < 7; ++i) sum[i + k] += cz * xy[i];
    }
  }
  return sum;
}

}  // namespace vol::wavelet
