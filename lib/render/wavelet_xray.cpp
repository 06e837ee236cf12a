#include "render/wavelet_xray.h"

#include <atomic>
#include <limits>
#include <vector>

#include "render/line_meets.h"
#include "render/picture.h"

namespace vol::render {

double WaveletXray::integral(const camera::Ray& ray, const Chord& chord, std::int64_t& terms,
                             std::int64_t& pieces) const {
  std::vector<const wavelet::Band*> all;
  for (const auto& band : expansion_.bands()) all.push_back(&band);
  return integral(ray, chord, all, terms, pieces);
}

double WaveletXray::integral(const camera::Ray& ray, const Chord& chord,
                             std::span<const wavelet::Band* const> bands, std::int64_t& terms,
                             std::int64_t& pieces) const {
  const auto& geometry = expansion_.geometry();
  const Vec3 direction = geometry.world_to_index_matrix() * ray.direction;
  // From the chord's middle on, so that far eyes cost no digits.
  const double middle = 0.5 * (chord.entry + chord.exit), half = 0.5 * chord.length();
  const Vec3 origin = geometry.world_to_index(ray.origin + middle * ray.direction);
  const LineMeets meets(origin, direction, -half, half);
  double sum = 0;
  for (const wavelet::Band* band : bands) {
    band->visit(meets, [&](const wavelet::Term& term) {
      ++terms;
      sum += wavelet::line_integral(expansion_, *band, term, origin, direction, -half, half, &pieces);
    });
  }
  return sum;
}

RenderResult WaveletXray::draw(const Scene& scene, const RenderOptions& options,
                               WaveletCounts* counts) const {
  std::atomic<std::int64_t> pieces = 0;
  const auto cast = [&](const camera::Ray& ray, const Chord& chord, RenderCounts& spent) {
    std::int64_t here = 0;
    Pixel pixel;
    pixel.colour = Vec3::Constant(integral(ray, chord, spent.samples, here));
    pixel.alpha = 1;
    pieces += here;
    return pixel;
  };
  RenderResult result = render::draw(expansion_.bounds(), scene, options, cast);
  result.caster = "exact";
  if (counts != nullptr) counts->pieces = pieces;
  return result;
}

}  // namespace vol::render
