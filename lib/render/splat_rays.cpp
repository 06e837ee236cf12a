#include "render/splat_rays.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/error.h"
#include "render/bernstein.h"
#include "render/isosurface_rays.h"

namespace vol::render {
namespace {

/// Bernstein coefficients over [t0, t1] of the cube of g(t) = 1 - (distance2 + (t - centre)^2) / R^2 are
/// added to those of a sum of degree 6, each still to be divided by C(6, k). That of g are w0, w1 / 2, w2,
/// and with x = u / (1 - u) the cube is that of w0 + w1 x + w2 x^2.
void add_cube(double w0, double w1, double w2, std::array<double, 7>& sum) {
  const double s0 = w0 * w0, s1 = 2 * w0 * w1, s2 = 2 * w0 * w2 + w1 * w1, s3 = 2 * w1 * w2, s4 = w2 * w2;
  sum[0] += s0 * w0;
  sum[1] += s1 * w0 + s0 * w1;
  sum[2] += s2 * w0 + s1 * w1 + s0 * w2;
  sum[3] += s3 * w0 + s2 * w1 + s1 * w2;
  sum[4] += s4 * w0 + s3 * w1 + s2 * w2;
  sum[5] += s4 * w1 + s3 * w2;
  sum[6] += s4 * w2;
}

}  // namespace

SplatRays::SplatRays(volume::SplatField field, const std::vector<LabelLook>& looks, double threshold)
    : field_(std::move(field)), box_(field_.bounds()), threshold_(threshold) {
  if (!(threshold > 0) || !std::isfinite(threshold)) {
    throw Error("the threshold of splats is a positive number");
  }
  colours_.fill(Vec3::Ones());
  for (std::size_t l = 0; l < looks.size() && l < colours_.size(); ++l) {
    colours_[l] = looks[l].colour;
    brightest_ = brightest_.cwiseMax(looks[l].colour);
  }
}

struct SplatRays::Stretch {
  /// A splat on the ray: g(t)^3, g(t) = 1 - (distance2 + (t - centre)^2) / R^2, for begin < t < end.
  struct Span {
    double centre, distance2, begin, end;
  };
  const SplatRays& rays;
  bool inside = false;  // at the start of the ray, and so up to its first crossing
  bool* undecided = nullptr;
  double r2 = 0;
  std::vector<Span> spans = {};
  std::vector<double> ends = {};         // of the spans, ascending
  std::vector<std::uint32_t> open = {};  // numbers of spans: a stack of lists

  void gather(const camera::Ray& ray, double a, double b);
  std::optional<double> first_crossing_in(std::size_t first, std::size_t last, Bernstein sum,
                                          std::size_t from);

 private:
  [[nodiscard]] double largest(const Span& s, double a, double b) const {
    const double beside = s.centre - std::clamp(s.centre, a, b);
    const double g = 1 - (s.distance2 + beside * beside) / r2;
    return g * g * g;
  }
};

/// The splats on [a, b], all of them open, and where they end.
void SplatRays::Stretch::gather(const camera::Ray& ray, double a, double b) {
  const double middle = 0.5 * (a + b);
  const Vec3 from = ray.origin + middle * ray.direction;  // near by: distances keep their digits
  spans.clear();
  open.clear();
  ends = {a, b};
  rays.field_.for_splats(ray.origin + a * ray.direction, ray.origin + b * ray.direction,
                         [&](std::uint8_t, const Vec3& centre) {
                           const Vec3 to = centre - from;
                           const double along = to.dot(ray.direction);
                           const double distance2 = (to - along * ray.direction).squaredNorm();
                           if (!(distance2 < r2)) return;
                           const double half = std::sqrt(r2 - distance2), t = middle + along;
                           if (t + half <= a || t - half >= b) return;
                           open.push_back(static_cast<std::uint32_t>(spans.size()));
                           spans.push_back({t, distance2, t - half, t + half});
                         });
  for (const Span& span : spans) {
    if (span.begin > a) ends.push_back(span.begin);
    if (span.end < b) ends.push_back(span.end);
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
}

/// The first change of side between two of the ends.
/// \param sum   of the splats that go on beyond both, and are not open
/// \param from  of the open ones, the first that may be met here
std::optional<double> SplatRays::Stretch::first_crossing_in(std::size_t first, std::size_t last,
                                                            Bernstein sum, std::size_t from) {
  const double t0 = ends[first], t1 = ends[last];
  const std::size_t own = open.size();
  std::array<double, 7> cubes{};
  double still_open = 0;
  for (std::size_t n = from; n < own; ++n) {
    const Span& s = spans[open[n]];
    if (s.begin <= t0 && s.end >= t1) {
      const double u0 = t0 - s.centre, u1 = t1 - s.centre;
      add_cube(1 - (s.distance2 + u0 * u0) / r2, 2 * (1 - (s.distance2 + u0 * u1) / r2),
               1 - (s.distance2 + u1 * u1) / r2, cubes);
    } else if (s.begin < t1 && s.end > t0) {
      still_open += largest(s, t0, t1);
      open.push_back(open[n]);
    }
  }
  constexpr double kBinomial[7] = {1, 6, 15, 20, 15, 6, 1};
  for (std::size_t k = 0; k < 7; ++k) sum.b[k] += cubes[k] / kBinomial[k];

  const double threshold = rays.threshold_;
  std::optional<double> found;
  if (inside ? sum.min() >= threshold : sum.max() + still_open < threshold) {
    // All on one side: no splat is below 0.
  } else if (open.size() == own) {
    if ((sum.b[0] >= threshold) != inside) {
      found = t0;  // between two pieces, where rounding put it
    } else if (const auto u = first_crossing(sum, threshold, undecided)) {
      found = t0 + *u * (t1 - t0);
    }
  } else {
    const std::size_t middle = first + (last - first) / 2;
    Bernstein left, right;
    sum.split((ends[middle] - t0) / (t1 - t0), left, right);
    found = first_crossing_in(first, middle, left, own);
    if (!found) found = first_crossing_in(middle, last, right, own);
  }
  open.resize(own);
  return found;
}

SplatRays::Hit SplatRays::hit_at(const camera::Ray& ray, double t) const {
  Hit hit{t, ray.origin + t * ray.direction, Vec3::Zero(), Vec3::Zero()};
  const Vec3 gradient = field_.gradient(hit.position);
  if (gradient.squaredNorm() > 0) hit.normal = -gradient.normalized();
  std::array<double, 256> shares;
  field_.shares(hit.position, shares);
  double all = 0;
  for (std::size_t l = 0; l < shares.size(); ++l) {
    all += shares[l];
    hit.colour += shares[l] * colours_[l];
  }
  if (all > 0) hit.colour /= all;
  return hit;
}

std::optional<SplatRays::Hit> SplatRays::first_hit(const camera::Ray& ray, double t_min,
                                                   bool* undecided) const {
  if (field_.count() == 0) return std::nullopt;
  const auto chord = box_.chord(ray, t_min);
  if (!chord) return std::nullopt;
  // Short stretches: most of them are passed as a whole.
  const double step = 0.25 * field_.support();
  const double stretches = std::ceil(chord->length() / step);
  if (!(stretches < 1e8)) throw Error("splats are too small for this volume");
  Stretch stretch{
      .rays = *this,
      .inside = chord->entry == t_min && field_.value(ray.origin + t_min * ray.direction) >= threshold_,
      .undecided = undecided,
      .r2 = field_.support() * field_.support()};
  Bernstein none;
  none.degree = 6;
  for (std::int64_t n = 0; n < static_cast<std::int64_t>(stretches); ++n) {
    const double a = chord->entry + static_cast<double>(n) * step, b = std::min(a + step, chord->exit);
    if (!(b > a)) break;
    stretch.gather(ray, a, b);
    const auto t = stretch.first_crossing_in(0, stretch.ends.size() - 1, none, 0);
    if (t) return hit_at(ray, *t);
  }
  return std::nullopt;
}

}  // namespace vol::render
