#include "curvilinear/cast_solids.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

#include "base/parallel.h"
#include "curvilinear/solid_path.h"
#include "render/picture.h"
#include "render/reference_integral.h"

namespace vol::curvilinear {
namespace {

using render::Chord;
using render::Pixel;
using render::RenderCounts;

/// The shortest distance of two of the transfer function's points, if any and if it is below `range`.
double finest(const transfer::TransferFunction& transfer, double range) {
  const auto& points = transfer.breakpoints();
  for (std::size_t n = 1; n < points.size(); ++n) range = std::min(range, points[n] - points[n - 1]);
  return range;
}

/// Everything about a picture that its rays share.
class Caster {
 public:
  Caster(const SolidRays& rays, const render::Scene& scene, const render::RenderOptions& options)
      : rays_(rays), scene_(scene), tolerance_(options.tolerance) {
    double scale = rays.value_range();
    if (scene.model == render::Model::composite) {
      optics_.emplace(scene.transfer, render::resolved_reference_length(scene, 0));
      if (scene.shading) shading_.emplace(*scene.shading);
      const Vec3 brightest = Vec3::Constant(optics_->brightest());
      brightest_ = std::max((shading_ ? shading_->brightest() : render::Lit{})(brightest).maxCoeff(),
                            scene.background.maxCoeff());
      scale = finest(scene.transfer, scale);
    }
    value_tolerance_ = 1e-3 * tolerance_ * scale;
  }

  Pixel operator()(const camera::Ray& ray, RenderCounts& counts) const {
    const bool starts_at_eye = scene_.view.projection == camera::Projection::perspective;
    RayScratch scratch;
    std::vector<RaySegment> segments;
    rays_.segments(ray, starts_at_eye ? 0 : -std::numeric_limits<double>::infinity(), scratch, segments);
    if (segments.empty()) return {};
    const Chord chord{segments.front().t0, segments.back().t1};
    SolidPath* current = nullptr;
    const render::PieceSource pieces = [&](const camera::Ray&, const Chord&, const render::PieceSink& sink) {
      std::int64_t evaluations = 0;
      for (const RaySegment& segment : segments) {
        const Solid solid = rays_.solid(segment.in);
        SolidPath path(solid, ray, segment.in, rays_.handedness(segment.in.block));
        if (optics_ && scene_.transfer.max_opacity(path.least(), path.most()) == 0) continue;
        current = &path;
        const bool goes_on = path.pieces(segment.t0, segment.t1, value_tolerance_, sink);
        current = nullptr;
        evaluations += path.evaluations();
        if (!goes_on) break;
      }
      return evaluations;
    };
    switch (scene_.model) {
      case render::Model::xray:
        return render::reference_xray(ray, chord, pieces, counts);
      case render::Model::mip:
        return render::reference_mip(ray, chord, pieces, tolerance_, counts);
      case render::Model::composite:
        break;
    }
    render::ReferenceIntegral::Light light;
    if (shading_) {
      light = [&](double t) {
        ++counts.gradients;
        return (*shading_)(current->gradient(t), ray.direction);
      };
    }
    const bool headlight = scene_.shading && !scene_.shading->light;
    render::ReferenceIntegral integral(*optics_, tolerance_, chord.length(), brightest_, std::move(light),
                                       headlight);
    counts.samples += pieces(ray, chord, [&](const render::RayPiece& piece) { return integral.add(piece); });
    counts.samples += integral.evaluations();
    return integral.pixel();
  }

 private:
  const SolidRays& rays_;
  const render::Scene& scene_;
  double tolerance_;
  double value_tolerance_ = 0;
  double brightest_ = 0;
  std::optional<render::Optics> optics_;  // of composite
  std::optional<render::BlinnPhong> shading_;
};

}  // namespace

render::RenderResult cast_solids(const SolidRays& rays, const render::Scene& scene,
                                 const render::RenderOptions& options) {
  render::require_valid(options);
  const Caster caster(rays, scene, options);
  const Box3 box = rays.grid().bounds();
  const volume::FieldBounds bounds{box.min, box.size().asDiagonal()};
  render::RenderResult result = render::draw(
      bounds, scene, options,
      [&](const camera::Ray& ray, const Chord&, RenderCounts& counts) { return caster(ray, counts); },
      [&](const camera::Ray& ray, RenderCounts& counts) { return caster(ray, counts); });
  result.caster = "reference";
  return result;
}

std::vector<render::Pixel> cast_pixels(const SolidRays& rays, const render::Scene& scene,
                                       const render::RenderOptions& options,
                                       std::span<const render::PixelPosition> pixels, RenderCounts& counts) {
  render::require_valid(options);
  const Caster caster(rays, scene, options);
  const Box3 box = rays.grid().bounds();
  const camera::Camera camera(scene.view, box.centre(), box.size().maxCoeff(), options.width, options.height);
  std::vector<Pixel> found(pixels.size());
  constexpr std::int64_t kGrain = 64;
  counts += parallel_reduce<RenderCounts>(
      0, static_cast<std::int64_t>(pixels.size()), kGrain,
      [&](std::int64_t begin, std::int64_t end) {
        RenderCounts part;
        for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
          found[n] = caster(camera.ray(pixels[n].x + 0.5, pixels[n].y + 0.5), part);
          ++part.rays;
        }
        return part;
      },
      [](RenderCounts& sum, const RenderCounts& part) { sum += part; });
  return found;
}

}  // namespace vol::curvilinear
