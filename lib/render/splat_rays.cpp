#include "render/splat_rays.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "render/bernstein.h"
#include "render/isosurface_rays.h"

namespace vol::render {
namespace {

/// Adds (w0 + w1 x + w2 x^2)^3, the cube of Bernstein coefficients w0, w1 / 2, w2 with x = u / (1 - u), to
/// coefficients of degree 6 that are each still to be divided by C(6, k).
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

std::optional<double> SplatRays::first_crossing_in(const camera::Ray& ray, double a, double b, bool inside,
                                                   Work& work, bool* undecided) const {
  const double r2 = field_.support() * field_.support();
  const double middle = 0.5 * (a + b);
  const Vec3 from = ray.origin + middle * ray.direction;  // near by: distances keep their digits
  work.spans.clear();
  work.ends = {a, b};
  double most = 0;
  field_.for_splats(ray.origin + a * ray.direction, ray.origin + b * ray.direction,
                    [&](std::uint8_t, const Vec3& centre) {
                      const Vec3 to = centre - from;
                      const double along = to.dot(ray.direction);
                      const double distance2 = (to - along * ray.direction).squaredNorm();
                      if (!(distance2 < r2)) return;
                      const double half = std::sqrt(r2 - distance2), t = middle + along;
                      if (t + half <= a || t - half >= b) return;
                      const double beside = t - std::clamp(t, a, b);
                      const double g = 1 - (distance2 + beside * beside) / r2;
                      most += g * g * g;
                      work.spans.push_back({t, distance2, t - half, t + half});
                    });
  if (!inside && most < threshold_) return std::nullopt;
  for (const Span& span : work.spans) {
    if (span.begin > a) work.ends.push_back(span.begin);
    if (span.end < b) work.ends.push_back(span.end);
  }
  std::sort(work.ends.begin(), work.ends.end());
  for (std::size_t n = 0; n + 1 < work.ends.size(); ++n) {
    const double t0 = work.ends[n], t1 = work.ends[n + 1], t = 0.5 * (t0 + t1);
    if (!(t1 > t0)) continue;
    std::array<double, 7> sum{};
    for (const Span& s : work.spans) {
      if (!(s.begin < t && t < s.end)) continue;
      const double u0 = t0 - s.centre, u1 = t1 - s.centre;
      add_cube(1 - (s.distance2 + u0 * u0) / r2, 2 * (1 - (s.distance2 + u0 * u1) / r2),
               1 - (s.distance2 + u1 * u1) / r2, sum);
    }
    constexpr double kBinomial[7] = {1, 6, 15, 20, 15, 6, 1};
    Bernstein p;
    p.degree = 6;
    for (std::size_t k = 0; k < 7; ++k) p.b[k] = sum[k] / kBinomial[k];
    if ((p.b[0] >= threshold_) != inside) return t0;  // between two pieces, where rounding put it
    if (const auto u = first_crossing(p, threshold_, undecided)) return t0 + *u * (t1 - t0);
  }
  return std::nullopt;
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
  // Short stretches: their bounds are tight, and few splats end in each.
  const double step = 0.25 * field_.support();
  const double stretches = std::ceil(chord->length() / step);
  if (!(stretches < 1e8)) throw Error("splats are too small for this volume");
  Work work;
  const bool inside = chord->entry == t_min && field_.value(ray.origin + t_min * ray.direction) >= threshold_;
  for (std::int64_t n = 0; n < static_cast<std::int64_t>(stretches); ++n) {
    const double a = chord->entry + static_cast<double>(n) * step, b = std::min(a + step, chord->exit);
    if (!(b > a)) break;
    if (const auto t = first_crossing_in(ray, a, b, inside, work, undecided)) return hit_at(ray, *t);
  }
  return std::nullopt;
}

}  // namespace vol::render
