#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "base/compensated_sum.h"
#include "base/error.h"
#include "render/grid_field.h"
#include "render/ray_polynomial.h"
#include "render/raycast.h"
#include "render/reference_integral.h"
#include "volume/grid_sampler.h"

namespace vol::render {

Pixel reference_xray(const camera::Ray& ray, const Chord& chord, const PieceSource& pieces,
                     RenderCounts& counts) {
  CompensatedSum sum;
  double magnitude = 0;
  counts.samples += pieces(ray, chord, [&](const RayPiece& piece) {
    const double part = (piece.t1 - piece.t0) * piece.p.integral();
    sum.add(part);
    magnitude += std::abs(part);
    ++counts.samples;
    return true;
  });
  return {Vec3::Constant(sum.value()), 1, std::numeric_limits<double>::infinity(), 1e-14 * magnitude};
}

Pixel reference_mip(const camera::Ray& ray, const Chord& chord, const PieceSource& pieces, double tolerance,
                    RenderCounts& counts) {
  double most = -std::numeric_limits<double>::infinity();
  double depth = 0;
  double error = 0;
  counts.samples += pieces(ray, chord, [&](const RayPiece& piece) {
    ++counts.samples;
    const double allowed = tolerance * std::max(std::abs(piece.p.min()), std::abs(piece.p.max()));
    double maximum = 0, where = 0;
    if (piece.p.max() > most && find_maximum(piece.p, most, allowed, maximum, where)) {
      most = maximum;
      depth = piece.t0 + where * (piece.t1 - piece.t0);
    }
    error = std::max(error, allowed);
    return true;
  });
  return {Vec3::Constant(most), 1, depth, error};
}

namespace {

MediumCaster medium(const FieldView& field, PieceSource pieces, const Scene& scene,
                    const RenderOptions& options, double smallest_spacing, double else_brightest) {
  require_valid(options);
  if (scene.model != Model::composite) throw Error("only the model composite has a medium between surfaces");
  const auto optics =
      std::make_shared<const Optics>(scene.transfer, resolved_reference_length(scene, smallest_spacing));
  std::optional<BlinnPhong> shading;
  if (scene.shading) shading.emplace(*scene.shading);
  const bool headlight = scene.shading && !scene.shading->light;
  const double lit = (shading ? shading->brightest() : Lit{})(Vec3::Constant(optics->brightest())).maxCoeff();
  const double brightest = std::max({lit, scene.background.maxCoeff(), else_brightest});
  return [=, pieces = std::move(pieces), tolerance = options.tolerance](
             const camera::Ray& ray, const Chord& part, double whole, Beam& beam, RenderCounts& counts) {
    ReferenceIntegral::Light light;
    if (shading) {
      light = [&](double t) {
        ++counts.gradients;
        return (*shading)(field.gradient(ray.origin + t * ray.direction), ray.direction);
      };
    }
    ReferenceIntegral integral(*optics, tolerance, whole, brightest, std::move(light), headlight, beam);
    counts.samples += pieces(ray, part, [&](const RayPiece& piece) { return integral.add(piece); });
    counts.samples += integral.evaluations();
    beam = integral.beam();
  };
}

RayCaster caster(const FieldView& field, PieceSource pieces, const Scene& scene, const RenderOptions& options,
                 double smallest_spacing) {
  require_valid(options);
  if (scene.model == Model::xray) {
    return [pieces = std::move(pieces)](const camera::Ray& ray, const Chord& chord, RenderCounts& counts) {
      return reference_xray(ray, chord, pieces, counts);
    };
  }
  if (scene.model == Model::mip) {
    return [pieces = std::move(pieces), tolerance = options.tolerance](
               const camera::Ray& ray, const Chord& chord, RenderCounts& counts) {
      return reference_mip(ray, chord, pieces, tolerance, counts);
    };
  }
  return [medium = medium(field, std::move(pieces), scene, options, smallest_spacing, 0)](
             const camera::Ray& ray, const Chord& chord, RenderCounts& counts) {
    Beam beam;
    medium(ray, chord, chord.length(), beam, counts);
    return beam.pixel;
  };
}

PieceSource pieces_of(const FieldView& field) {
  return [field](const camera::Ray& ray, const Chord& chord, const PieceSink& sink) {
    return fit_pieces(field, ray, chord, sink);
  };
}

/// \param field  of the volume, for the gradients of shading; kept alive
PieceSource pieces_of(const volume::Volume& volume, const GridField& field, const RenderOptions& options) {
  (void)volume::value_range(volume);  // refuses NaN and infinity
  const auto grid_pieces = std::make_shared<const GridPieces>(volume, options.reconstruction);
  return [grid_pieces, field](const camera::Ray& ray, const Chord& chord, const PieceSink& sink) {
    (*grid_pieces)(ray, chord, sink);
    return std::int64_t{0};
  };
}

}  // namespace

RayCaster reference_caster(const FieldView& field, const Scene& scene, const RenderOptions& options) {
  return caster(field, pieces_of(field), scene, options, 0);
}

RayCaster reference_caster(const volume::Volume& volume, const Scene& scene, const RenderOptions& options) {
  const GridField field(volume, options.reconstruction);
  return caster(field.view(), pieces_of(volume, field, options), scene, options,
                volume.geometry().spacing.minCoeff());
}

MediumCaster reference_medium(const FieldView& field, const Scene& scene, const RenderOptions& options,
                              double brightest) {
  return medium(field, pieces_of(field), scene, options, 0, brightest);
}

MediumCaster reference_medium(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                              double brightest) {
  const GridField field(volume, options.reconstruction);
  return medium(field.view(), pieces_of(volume, field, options), scene, options,
                volume.geometry().spacing.minCoeff(), brightest);
}

RenderResult raycast_reference(const FieldView& field, const Scene& scene, const RenderOptions& options) {
  RenderResult result = draw(field.bounds, scene, options, reference_caster(field, scene, options));
  result.caster = "reference";
  return result;
}

RenderResult raycast_split_plain(const volume::Volume& volume, const Scene& scene,
                                 const RenderOptions& options) {
  RenderOptions adaptive = options;
  adaptive.tolerance = kSplitTolerance;
  return raycast_reference(volume, scene, adaptive);
}

RenderResult raycast_reference(const volume::Volume& volume, const Scene& scene,
                               const RenderOptions& options) {
  RenderResult result =
      draw(volume::field_bounds(volume.geometry()), scene, options, reference_caster(volume, scene, options));
  result.caster = "reference";
  return result;
}

}  // namespace vol::render
