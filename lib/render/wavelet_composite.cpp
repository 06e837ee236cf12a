#include "render/wavelet_composite.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "base/error.h"
#include "render/extinction_integral.h"
#include "render/line_meets.h"
#include "render/reference_integral.h"

namespace vol::render {

WaveletComposite::WaveletComposite(const wavelet::Expansion& expansion, const Scene& scene,
                                   const RenderOptions& options, const CompositeOptions& composite)
    : expansion_(expansion), scene_(scene), options_(options), composite_(composite), terms_(expansion) {
  require_valid(options);
  if (!(composite.extinction >= 0) || !std::isfinite(composite.extinction)) {
    throw Error("extinction is not a positive number");
  }
  if (composite.linearised != Linearised::none && (composite.transfer || scene.shading)) {
    throw Error("the linearised integral knows neither transfer function nor shading");
  }
  if (composite.transfer) {
    optics_.emplace(scene.transfer,
                    resolved_reference_length(scene, expansion.geometry().spacing.minCoeff()));
  }
  if (scene.shading) shading_.emplace(*scene.shading);
}

Pixel WaveletComposite::cast(const camera::Ray& ray, const Chord& chord, RenderCounts& spent,
                             CompositeCounts& counts) const {
  ExpansionLine line(terms_);
  const Pixel pixel = composite_.linearised != Linearised::none ? linearised(line, ray, chord, counts)
                      : composite_.transfer ? through_transfer(line, ray, chord, spent, counts)
                                            : by_extinction(line, ray, chord, spent, counts);
  spent.samples += line.terms_met();
  if (composite_.linearised == Linearised::none) counts.pieces += line.pieces();
  return pixel;
}

Pixel WaveletComposite::through_transfer(ExpansionLine& line, const camera::Ray& ray, const Chord& chord,
                                         RenderCounts& spent, CompositeCounts& counts) const {
  ReferenceIntegral::Light light;
  double brightest = optics_->brightest();
  if (shading_) {
    brightest = shading_->brightest()(Vec3::Constant(brightest)).maxCoeff();
    light = [&](double t) {
      ++spent.gradients;
      return (*shading_)(line.gradient(t), ray.direction);
    };
  }
  brightest = std::max(brightest, scene_.background.maxCoeff());
  const bool headlight = scene_.shading && !scene_.shading->light;
  ReferenceIntegral integral(*optics_, options_.tolerance, chord.length(), brightest, light, headlight);
  line.visit(ray, chord, [&](const RayPiece& piece) { return integral.add(piece); });
  counts.evaluations += integral.evaluations();
  return integral.pixel();
}

Pixel WaveletComposite::by_extinction(ExpansionLine& line, const camera::Ray& ray, const Chord& chord,
                                      RenderCounts& spent, CompositeCounts& counts) const {
  ExtinctionIntegral::Options options{.keep_negative = composite_.keep_negative,
                                      .tolerance = options_.tolerance};
  ExtinctionIntegral::Light light;
  if (shading_) {
    options.brightest = shading_->brightest()(Vec3::Ones()).maxCoeff();
    options.headlight = !scene_.shading->light;
    light = [&](double t) {
      ++spent.gradients;
      return (*shading_)(line.gradient(t), ray.direction);
    };
  }
  ExtinctionIntegral integral(options, chord.length(), light);
  line.visit(ray, chord, [&](RayPiece piece) {
    for (double& b : piece.p.b) b *= composite_.extinction;
    return integral.add(piece);
  });
  counts.clamped_pieces += integral.clamped_pieces();
  counts.clamped_depth = std::max(counts.clamped_depth, integral.clamped_depth());
  return integral.pixel();
}

Pixel WaveletComposite::linearised(ExpansionLine& line, const camera::Ray& ray, const Chord& chord,
                                   CompositeCounts& counts) const {
  // Pieces of f: where they end, their optical depth, and the product of what ends there of basis functions.
  std::vector<double> ends, depths;
  line.visit(ray, chord, [&](const RayPiece& piece) {
    ends.push_back(piece.t1);
    depths.push_back(composite_.extinction * (piece.t1 - piece.t0) * piece.p.integral());
    return true;
  });
  std::vector<double> factors(ends.size(), 1.0);
  const auto end_at = [&](double t, double integral) {
    // Knots are where they are to rounding.
    const auto end = std::lower_bound(ends.begin(), ends.end(), t - 1e-9 * chord.length());
    const auto n = std::min<std::ptrdiff_t>(end - ends.begin(), static_cast<std::ptrdiff_t>(ends.size()) - 1);
    factors[static_cast<std::size_t>(n)] *= 1 - composite_.extinction * integral;
    ++counts.pieces;
  };
  const auto& geometry = expansion_.geometry();
  const Vec3 direction = geometry.world_to_index_matrix() * ray.direction;
  const double middle = 0.5 * (chord.entry + chord.exit), half = 0.5 * chord.length();
  const Vec3 origin = geometry.world_to_index(ray.origin + middle * ray.direction);
  const LineMeets meets(origin, direction, -half, half);
  std::vector<wavelet::LineInterval> intervals;
  for (const auto& band : expansion_.bands()) {
    band.visit(meets, [&](const wavelet::Term& term) {
      wavelet::line_intervals(expansion_, band, term, origin, direction, -half, half, intervals);
      if (intervals.empty()) return;
      if (composite_.linearised == Linearised::interval) {
        for (const auto& interval : intervals) end_at(middle + interval.to, interval.integral);
      } else {
        double whole = 0;
        for (const auto& interval : intervals) whole += interval.integral;
        end_at(middle + intervals.back().to, whole);
      }
    });
  }
  Pixel pixel;
  double transmittance = 1, sum = 0;
  for (std::size_t n = 0; n < ends.size(); ++n) {
    sum += depths[n] * transmittance;
    transmittance *= factors[n];
    if (transmittance <= 0.5) pixel.depth = std::min(pixel.depth, ends[n]);
  }
  pixel.colour = Vec3::Constant(sum);
  pixel.alpha = 1 - transmittance;
  return pixel;
}

RenderResult WaveletComposite::draw(CompositeCounts* counts) const {
  CompositeCounts total;
  std::mutex mutex;
  const auto cast_ray = [&](const camera::Ray& ray, const Chord& chord, RenderCounts& spent) {
    CompositeCounts here;
    const Pixel pixel = cast(ray, chord, spent, here);
    const std::lock_guard lock(mutex);
    total.pieces += here.pieces;
    total.evaluations += here.evaluations;
    total.clamped_pieces += here.clamped_pieces;
    total.clamped_depth = std::max(total.clamped_depth, here.clamped_depth);
    return pixel;
  };
  RenderResult result = render::draw(expansion_.bounds(), scene_, options_, cast_ray);
  result.caster = "exact";
  if (counts != nullptr) *counts = total;
  return result;
}

}  // namespace vol::render
