#include "render/expansion_surface.h"

#include <cmath>
#include <limits>

#include "base/error.h"
#include "render/surface_picture.h"

namespace vol::render {
namespace {

using wavelet::LineField;

}  // namespace

ExpansionSurface::Counts& ExpansionSurface::Counts::operator+=(const Counts& other) {
  rays += other.rays;
  hits += other.hits;
  evaluations += other.evaluations;
  bounds += other.bounds;
  polynomials += other.polynomials;
  terms += other.terms;
  undecided += other.undecided;
  return *this;
}

ExpansionSurface::ExpansionSurface(const wavelet::Expansion& expansion, double isovalue,
                                   const ExpansionSurfaceOptions& options)
    : expansion_(expansion),
      terms_(expansion),
      global_(terms_.global()),
      box_(expansion.bounds()),
      isovalue_(isovalue),
      options_(options),
      tolerance_(options.tolerance.value_or(1e-3 * expansion.geometry().spacing.minCoeff())) {
  if (!std::isfinite(isovalue)) throw Error("an isovalue must be finite");
  if (!(tolerance_ > 0) || !std::isfinite(tolerance_)) throw Error("a tolerance must be positive and finite");
}

/// One ray's search. t counts from the chord's middle.
class ExpansionSurface::Search {
 public:
  Search(const ExpansionSurface& surface, Counts& counts)
      : surface_(surface), counts_(counts), line_(surface.terms_) {}

  /// Side where the line begins and, after run(), where it ends.
  [[nodiscard]] bool begins_inside() const { return begin_.inside(); }
  [[nodiscard]] bool ends_inside() const { return *inside_; }
  [[nodiscard]] bool undecided() const { return undecided_; }

  void set(const Vec3& origin, const Vec3& direction, double half) {
    speed_ = direction.norm();
    line_.set(origin, direction, -half, half);
    for (std::uint32_t n = 0; n < line_.size(); ++n) list_.push_back(n);
    half_ = half;
    begin_ = sample(-half, 0, list_.size());
  }

  /// Where the side first changes.
  std::optional<double> run() {
    const Point end = sample(half_, 0, list_.size());
    visit(begin_, end, 0, list_.size());
    counts_.terms += line_.terms_visited();
    return hit_;
  }

  /// Index space gradient at the hit.
  [[nodiscard]] Vec3 gradient(double t) {
    list_.clear();
    for (std::uint32_t n = 0; n < line_.size(); ++n) list_.push_back(n);
    return line_.gradient(t, list_, 0, list_.size());
  }

 private:
  struct Point {
    double t = 0;
    double f = 0;  ///< less the isovalue
    double slope = 0;
    [[nodiscard]] bool inside() const { return f >= 0; }
  };

  Point sample(double t, std::size_t from, std::size_t to) {
    ++counts_.evaluations;
    const LineField::Sample s = line_.at(t, list_, from, to);
    return {t, s.f - surface_.isovalue_, s.slope};
  }

  LineField::Bound bound(double a, double b, std::size_t from, std::size_t to) {
    if (surface_.options_.bound == SurfaceBound::global) {
      const auto& g = surface_.global_;
      return {g.slope * speed_, g.bend * speed_ * speed_, g.jump, g.kink * speed_, g.size};
    }
    ++counts_.bounds;
    return line_.bound(a, b, list_, from, to);
  }

  /// A part of the ray is decided: the sides of its ends, and a change between. \returns whether to go on
  bool decided(double a, bool starts_inside, std::optional<double> crossing, bool ends_inside) {
    if (inside_ && *inside_ != starts_inside) {
      hit_ = a;  // between this part and the one before it
      return false;
    }
    hit_ = crossing;
    inside_ = ends_inside;
    return !crossing;
  }
  bool none(const Point& a) { return decided(a.t, a.inside(), std::nullopt, a.inside()); }

  /// \returns whether to go on
  bool visit(const Point& a, const Point& b, std::size_t from, std::size_t to);
  bool look_at_polynomial(const Point& a, const Point& b, std::size_t from, std::size_t to);
  double root(Point a, Point b, double least_slope, std::size_t from, std::size_t to);

  const ExpansionSurface& surface_;
  Counts& counts_;
  LineField line_;
  LineField::List list_;
  double half_ = 0, speed_ = 0;
  Point begin_;
  std::optional<bool> inside_;  // where the last part ended
  std::optional<double> hit_;
  bool undecided_ = false;
};

bool ExpansionSurface::Search::visit(const Point& a, const Point& b, std::size_t from, std::size_t to) {
  const double w = b.t - a.t;
  const bool one_side = a.inside() == b.inside();
  const LineField::Bound e = bound(a.t, b.t, from, to);
  if (e.slope == 0 && e.jump == 0) return none(a);  // constant: the same terms, and the same rounding
  // Each value is a sum rounded as often as it has terms, of what the bounds are sums of.
  const double ulps = 0x1p-48 + 0x1p-52 * static_cast<double>(to - from);
  const double rounding = ulps * (e.size + std::abs(surface_.isovalue_));
  if (one_side && std::abs(a.f + b.f) > e.slope * w + e.jump + rounding) return none(a);
  if (e.jump <= rounding) {
    const double least = std::min(std::abs(a.f), std::abs(b.f));
    const bool published = surface_.options_.bound == SurfaceBound::global;
    const double sag = w * (w * e.bend / 8 + e.kink / 4);
    if (!published && one_side && least > sag + rounding) return none(a);
    const double slope = std::abs(a.slope + b.slope) - w * e.bend - e.kink - 2 * ulps * e.slope;
    if (slope > 0) {
      if (one_side) return none(a);
      return decided(a.t, a.inside(), root(a, b, 0.5 * slope, from, to), b.inside());
    }
  }
  double middle = 0.5 * (a.t + b.t);
  if (surface_.options_.bound == SurfaceBound::bernstein) {
    const auto knot = line_.middle_knot(a.t, b.t, list_, from, to);
    if (!knot) return look_at_polynomial(a, b, from, to);
    middle = *knot;
  }
  if (w <= surface_.tolerance_ || !(middle > a.t && middle < b.t)) {
    if (!one_side) return decided(a.t, a.inside(), root(a, b, 0, from, to), b.inside());
    undecided_ = true;
    return none(a);
  }
  const Point m = sample(middle, from, to);
  for (const bool first : {true, false}) {
    const Point &low = first ? a : m, &high = first ? m : b;
    const std::size_t top = list_.size();
    line_.narrow(list_, from, to, low.t, high.t);
    const bool go_on = visit(low, high, top, list_.size());
    list_.resize(top);
    if (!go_on) return false;
  }
  return true;
}

bool ExpansionSurface::Search::look_at_polynomial(const Point& a, const Point& b, std::size_t from,
                                                  std::size_t to) {
  ++counts_.polynomials;
  Bernstein p = bernstein_of_powers(line_.polynomial(a.t, b.t, list_, from, to));
  for (double& c : p.b) c -= surface_.isovalue_;
  const auto u = first_crossing(p, 0, &undecided_);
  std::optional<double> crossing;
  if (u) crossing = a.t + *u * (b.t - a.t);
  return decided(a.t, p.b[0] >= 0, crossing, p.b[Bernstein::kMaxDegree] >= 0);
}

/// The change of side between ends on different sides; where f is monotone, its slope at least that much.
double ExpansionSurface::Search::root(Point a, Point b, double least_slope, std::size_t from,
                                      std::size_t to) {
  const double accuracy = 1e-6 * surface_.tolerance_;
  Point best = std::abs(a.f) < std::abs(b.f) ? a : b;
  for (int n = 0; n < 100; ++n) {
    if (std::abs(best.f) <= accuracy * least_slope) return best.t;
    double t = least_slope > 0 && n % 4 != 3 ? best.t - best.f / best.slope : a.t;
    if (!(t > a.t && t < b.t)) t = 0.5 * (a.t + b.t);
    if (b.t - a.t <= accuracy || !(t > a.t && t < b.t)) return t;
    best = sample(t, from, to);
    (best.inside() == a.inside() ? a : b) = best;
  }
  return 0.5 * (a.t + b.t);
}

std::optional<ExpansionSurface::Hit> ExpansionSurface::first_hit(const camera::Ray& ray, const Chord& chord,
                                                                 Counts& counts) const {
  ++counts.rays;
  const auto& geometry = expansion_.geometry();
  const Mat3 to_index = geometry.world_to_index_matrix();
  // From the chord's middle on, so that far eyes cost no digits.
  const double middle = 0.5 * (chord.entry + chord.exit);
  const auto hit_at = [&](double t, const Vec3& normal) {
    ++counts.hits;
    return Hit{t, ray.origin + t * ray.direction, normal};
  };
  const auto border = [&](double t) {
    return hit_at(t, outward_normal(box_, ray.origin + t * ray.direction));
  };
  Search search(*this, counts);
  const Vec3 direction = to_index * ray.direction;
  const Vec3 origin = geometry.world_to_index(ray.origin + middle * ray.direction);
  search.set(origin, direction, 0.5 * chord.length());
  if (options_.close && search.begins_inside()) {
    const auto whole = box_.chord(ray, -std::numeric_limits<double>::infinity());
    if (whole && chord.entry == whole->entry) return border(chord.entry);
  }
  const auto t = search.run();
  if (!t) {
    if (options_.close && search.ends_inside()) return border(chord.exit);
    counts.undecided += search.undecided();
    return std::nullopt;
  }
  Vec3 gradient = search.gradient(*t);
  if (gradient.isZero(0)) {
    const Vec3 p = origin + *t * direction;
    for (int a = 0; a < 3; ++a) {
      const Vec3 step = 1e-3 * Vec3::Unit(a);
      gradient[a] = expansion_.value_index(p + step) - expansion_.value_index(p - step);
    }
  }
  gradient = to_index.transpose() * gradient;
  const double length = gradient.stableNorm();
  return hit_at(middle + *t, length > 0 ? Vec3(-gradient / length) : Vec3(Vec3::Zero()));
}

ExpansionSurfaceImage draw_expansion_surface(const ExpansionSurface& surface, const Scene& scene,
                                             const Vec3& colour, int width, int height) {
  ExpansionSurfaceImage result;
  result.image = draw_first_hits(surface, scene, colour, width, height, result.counts);
  return result;
}

}  // namespace vol::render
