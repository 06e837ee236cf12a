#include "render/wavelet_xray.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <vector>

#include "render/picture.h"

namespace vol::render {
namespace {

/// Whether a line meets boxes within [begin, end], by slabs.
class LineMeets {
 public:
  LineMeets(const Vec3& origin, const Vec3& direction, double begin, double end)
      : origin_(origin), begin_(begin), end_(end) {
    for (int a = 0; a < 3; ++a) {
      inverse_[a] = direction[a] == 0 ? std::numeric_limits<double>::infinity() : 1 / direction[a];
    }
  }

  [[nodiscard]] bool operator()(const Box3& box) const {
    double in = begin_, out = end_;
    for (int a = 0; a < 3; ++a) {
      if (inverse_[a] == std::numeric_limits<double>::infinity()) {
        if (origin_[a] < box.min[a] || origin_[a] > box.max[a]) return false;
        continue;
      }
      const double near = (box.min[a] - origin_[a]) * inverse_[a];
      const double far = (box.max[a] - origin_[a]) * inverse_[a];
      in = std::max(in, std::min(near, far));
      out = std::min(out, std::max(near, far));
    }
    return in <= out;
  }

 private:
  Vec3 origin_;
  Vec3 inverse_;
  double begin_, end_;
};

}  // namespace

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
