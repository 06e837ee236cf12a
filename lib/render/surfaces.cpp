#include "render/surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void meet(const SurfaceHit& hit, Beam& beam) {
  const double behind = beam.transmittance * (1 - hit.opacity);
  if (beam.transmittance > 0.5 && behind <= 0.5) beam.pixel.depth = hit.t;
  beam.pixel.colour += beam.transmittance * hit.opacity * hit.colour;
  beam.pixel.alpha += beam.transmittance * hit.opacity;
  beam.transmittance = behind;
}

HybridCaster hybrid(MediumCaster medium, const RenderOptions& options, const Surfaces& surfaces) {
  // Early termination plays no part in the truth.
  const double termination = options.quadrature >= Quadrature::split ? 0 : options.termination;
  return [medium = std::move(medium), termination, &surfaces](const camera::Ray& ray, const Chord* chord,
                                                              RenderCounts& counts) {
    std::vector<SurfaceHit> hits;
    surfaces.find(ray, chord, hits, counts);
    Beam beam;
    const auto seen = [&] { return beam.transmittance > termination; };
    double t = chord != nullptr ? chord->entry : 0;
    const auto cross = [&](double end) {  // the medium up to there
      if (chord == nullptr) return;
      end = std::min(end, chord->exit);
      if (!(end > t) || !seen()) return;
      medium(ray, {t, end}, chord->length(), beam, counts);
      t = end;
    };
    for (const SurfaceHit& hit : hits) {
      cross(hit.t);
      if (!seen()) break;
      meet(hit, beam);
    }
    cross(kInfinity);
    return beam.pixel;
  };
}

RenderResult drawn(const volume::FieldBounds& bounds, const Scene& scene, const RenderOptions& options,
                   const HybridCaster& cast) {
  const RayCaster within = [&](const camera::Ray& ray, const Chord& chord, RenderCounts& counts) {
    return cast(ray, &chord, counts);
  };
  const auto beside = [&](const camera::Ray& ray, RenderCounts& counts) {
    return cast(ray, nullptr, counts);
  };
  RenderResult result = draw(bounds, scene, options, within, beside);
  if (options.quadrature >= Quadrature::split) {
    result.caster = "reference";
  } else {
    result.error_estimate = std::numeric_limits<double>::quiet_NaN();
  }
  return result;
}

RenderOptions within_split_tolerance(RenderOptions options) {
  if (options.quadrature == Quadrature::split) options.tolerance = kSplitTolerance;
  return options;
}

}  // namespace

Surfaces::Surfaces(const Scene& scene)
    : light_(scene.shading.value_or(Shading{})),
      t_min_(scene.view.projection == camera::Projection::perspective ? 0 : -kInfinity) {
  if (scene.model != Model::composite) throw Error("surfaces in a picture need the model composite");
}

void Surfaces::admit(const SurfaceLook& look) {
  if (!(look.colour.minCoeff() >= 0 && look.colour.maxCoeff() <= 1 && look.opacity >= 0 &&
        look.opacity <= 1)) {
    throw Error("a surface's colour and opacity are numbers from 0 to 1");
  }
  brightest_ = std::max(brightest_, light_.brightest()(look.colour).maxCoeff());
}

void Surfaces::add(const IsosurfaceRays& isosurface, const SurfaceLook& look) {
  admit(look);
  isosurfaces_.push_back({&isosurface, look, next_++});
}

void Surfaces::add(const mesh::MeshRays& mesh, const SurfaceLook& look) {
  admit(look);
  meshes_.push_back({&mesh, look, next_++});
}

void Surfaces::add(const SplatRays& splats) {
  brightest_ = std::max(brightest_, light_.brightest()(splats.brightest()).maxCoeff());
  splats_.push_back({&splats, {}, next_++});
}

void Surfaces::find(const camera::Ray& ray, const Chord* chord, std::vector<SurfaceHit>& hits,
                    RenderCounts& counts) const {
  hits.clear();
  double end = kInfinity;  // the nearest opaque hit
  const auto add = [&](double t, const Vec3& normal, const SurfaceLook& look, std::uint32_t number) {
    hits.push_back({t, light_(-normal, ray.direction)(look.colour), look.opacity, number});
    if (look.opacity == 1) end = std::min(end, t);
  };
  if (chord != nullptr) {
    for (const auto& surface : isosurfaces_) {
      IsosurfaceRays::Counts own;
      bool undecided = false;
      const auto take = [&](const IsosurfaceRays::Hit& hit) {
        if (hit.t > end) return false;
        add(hit.t, hit.normal, surface.look, surface.number);
        return surface.look.opacity < 1;
      };
      surface.rays->for_hits(ray, *chord, take, own, undecided);
      counts.surface_undecided += undecided;
    }
  }
  for (const auto& surface : meshes_) {
    surface.rays->for_hits(ray.origin, ray.direction, t_min_, end, [&](const mesh::MeshRays::Hit& hit) {
      add(hit.t, surface.rays->normal(hit), surface.look, surface.number);
      return end;
    });
  }
  for (const auto& surface : splats_) {
    bool undecided = false;
    const auto hit = surface.rays->first_hit(ray, t_min_, &undecided);
    counts.surface_undecided += undecided;
    if (hit && hit->t <= end) add(hit->t, hit->normal, {hit->colour, 1}, surface.number);
  }
  std::sort(hits.begin(), hits.end(), [](const SurfaceHit& a, const SurfaceHit& b) {
    return a.t != b.t ? a.t < b.t : a.surface < b.surface;
  });
  const auto opaque =
      std::find_if(hits.begin(), hits.end(), [](const SurfaceHit& hit) { return hit.opacity == 1; });
  if (opaque != hits.end()) hits.erase(opaque + 1, hits.end());
  counts.surface_hits += static_cast<std::int64_t>(hits.size());
}

HybridCaster hybrid_caster(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                           const Surfaces& surfaces, const index::IndexVolume* index,
                           const LabelledMedium* labels) {
  if (labels && options.quadrature >= Quadrature::split) {
    throw Error("labels are drawn by the quadratures rectangle and trapezoid alone");
  }
  return hybrid(options.quadrature >= Quadrature::split
                    ? reference_medium(volume, scene, within_split_tolerance(options), surfaces.brightest())
                    : plain_medium(volume, scene, options, index, labels),
                options, surfaces);
}

HybridCaster hybrid_caster(const FieldView& field, const Scene& scene, const RenderOptions& options,
                           const Surfaces& surfaces) {
  return hybrid(options.quadrature >= Quadrature::split
                    ? reference_medium(field, scene, within_split_tolerance(options), surfaces.brightest())
                    : plain_medium(field, scene, options),
                options, surfaces);
}

RenderResult raycast_with_surfaces(const volume::Volume& volume, const Scene& scene,
                                   const RenderOptions& options, const Surfaces& surfaces,
                                   const index::IndexVolume* index, const LabelledMedium* labels) {
  return drawn(volume::field_bounds(volume.geometry()), scene, options,
               hybrid_caster(volume, scene, options, surfaces, index, labels));
}

RenderResult raycast_with_surfaces(const FieldView& field, const Scene& scene, const RenderOptions& options,
                                   const Surfaces& surfaces) {
  return drawn(field.bounds, scene, options, hybrid_caster(field, scene, options, surfaces));
}

}  // namespace vol::render
