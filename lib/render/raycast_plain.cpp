#include <limits>
#include <memory>

#include "base/error.h"
#include "render/composite_ray.h"
#include "render/raycast.h"
#include "render/step_control.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

/// Integral of f: left node, or both (trapezoid and preintegrated, which for f itself are the same).
Pixel xray(const RayContext& context, const NodeWalk& walk, RenderCounts& counts) {
  const bool both = context.options.quadrature != Quadrature::rectangle;
  double sum = 0;
  double left = context.field.value(walk.position(0));
  ++counts.samples;
  for (std::int64_t node = 0; node < walk.last();) {
    const std::int64_t next = walk.after(node);
    const double h = walk.t(next) - walk.t(node);
    double right = 0;
    if (both || next < walk.last()) {
      right = context.field.value(walk.position(next));
      ++counts.samples;
    }
    sum += h * (both ? 0.5 * left + 0.5 * right : left);
    left = right;
    node = next;
  }
  return {Vec3::Constant(sum), 1, std::numeric_limits<double>::infinity(), 0};
}

/// Largest value of the visited nodes; the first where several are equal.
Pixel mip(const RayContext& context, const NodeWalk& walk, RenderCounts& counts) {
  double most = -std::numeric_limits<double>::infinity();
  double depth = 0;
  for (std::int64_t node = 0;; node = walk.after(node)) {
    const double value = context.field.value(walk.position(node));
    ++counts.samples;
    if (value > most) {
      most = value;
      depth = walk.t(node);
    }
    if (node == walk.last()) break;
  }
  return {Vec3::Constant(most), 1, depth, 0};
}

/// Adds what options and scene say, and refuses what no steps can do.
std::shared_ptr<const RayContext> complete(RayContext context, const Scene& scene, double smallest_spacing) {
  require_valid(context.options);
  if (context.options.quadrature >= Quadrature::split) {
    throw Error("quadratures split and reference have no steps to cast by; call raycast_reference");
  }
  if (context.options.step_tolerance > 0) {
    require_adaptive_steps_can_be(scene, context.index != nullptr);
    context.halvings = most_halvings(context.field.bounds, context.options.step);
    context.options.step /= 1 << context.halvings;  // the walk's nodes
    if (scene.shading) {
      context.shading_share = shading_share(*scene.shading, context.options.step, context.cell);
    }
  }
  if (scene.model == Model::composite) {
    context.optics.emplace(scene.transfer, resolved_reference_length(scene, smallest_spacing));
    if (scene.shading) context.shading.emplace(*scene.shading);
  }
  return std::make_shared<const RayContext>(std::move(context));
}

RayCaster caster(const std::shared_ptr<const RayContext>& shared, const Scene& scene) {
  return [shared, model = scene.model](const camera::Ray& ray, const Chord& chord, RenderCounts& counts) {
    const NodeWalk walk(ray, chord, shared->options.step, shared->box, shared->index);
    switch (model) {
      case Model::xray:
        return xray(*shared, walk, counts);
      case Model::mip:
        return mip(*shared, walk, counts);
      default:
        Beam beam;
        pass_composite(*shared, walk, ray.direction, beam, counts);
        return beam.pixel;
    }
  };
}

MediumCaster medium(const std::shared_ptr<const RayContext>& shared, const Scene& scene) {
  if (scene.model != Model::composite) throw Error("only the model composite has a medium between surfaces");
  return [shared](const camera::Ray& ray, const Chord& part, double, Beam& beam, RenderCounts& counts) {
    const NodeWalk walk(ray, part, shared->options.step, shared->box, shared->index);
    pass_composite(*shared, walk, ray.direction, beam, counts);
  };
}

RenderResult drawn(const volume::FieldBounds& bounds, const Scene& scene, const RenderOptions& options,
                   const RayCaster& cast) {
  RenderResult result = draw(bounds, scene, options, cast);
  result.error_estimate = std::numeric_limits<double>::quiet_NaN();
  return result;
}

std::shared_ptr<const RayContext> context_of(const FieldView& field, const Scene& scene,
                                             const RenderOptions& options, const index::IndexVolume* index) {
  return complete({.field = field, .options = options, .box = RayBox(field.bounds), .index = index}, scene,
                  0);
}

/// Labels are known at nodes alone: what lies between two of them is not the value's way from one to the
/// other.
void require_labels_can_be_drawn(const Scene& scene, const RenderOptions& options,
                                 const index::IndexVolume* index) {
  if (scene.model != Model::composite) throw Error("labels are drawn by the model composite alone");
  if (options.quadrature != Quadrature::rectangle && options.quadrature != Quadrature::trapezoid) {
    throw Error("labels are drawn by the quadratures rectangle and trapezoid alone");
  }
  if (index) throw Error("an index of the field says nothing of its labels");
}

std::shared_ptr<const RayContext> context_of(const volume::Volume& volume, const Scene& scene,
                                             const RenderOptions& options, const index::IndexVolume* index,
                                             const LabelledMedium* labels) {
  (void)volume::value_range(volume);  // refuses NaN and infinity
  if (labels) require_labels_can_be_drawn(scene, options, index);
  const volume::GridGeometry& geometry = volume.geometry();
  if (index && index->volume_dims() != geometry.dims) {
    throw Error("index volume was built for other dims than the volume's");
  }
  const GridField field(volume, options.reconstruction);
  RayContext context{.field = field.view(),
                     .options = options,
                     .box = RayBox(field.view().bounds),
                     .index = index,
                     .labels = labels,
                     .grid = field};
  context.cell = smallest_cell(geometry, options.reconstruction);
  if (options.skip_empty && labels) {
    context.visibility.emplace(labels->visibility());
    context.dims = geometry.dims;
  } else if (options.skip_empty && scene.model == Model::composite) {
    context.macrocells.emplace(index::macrocells(volume, options.reconstruction));
    context.visibility.emplace(visibility(*context.macrocells, scene.transfer));
    context.dims = geometry.dims;
  }
  return complete(std::move(context), scene, geometry.spacing.minCoeff());
}

}  // namespace

RayCaster plain_caster(const FieldView& field, const Scene& scene, const RenderOptions& options,
                       const index::IndexVolume* index) {
  return caster(context_of(field, scene, options, index), scene);
}

RayCaster plain_caster(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                       const index::IndexVolume* index, const LabelledMedium* labels) {
  return caster(context_of(volume, scene, options, index, labels), scene);
}

MediumCaster plain_medium(const FieldView& field, const Scene& scene, const RenderOptions& options,
                          const index::IndexVolume* index) {
  return medium(context_of(field, scene, options, index), scene);
}

MediumCaster plain_medium(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                          const index::IndexVolume* index, const LabelledMedium* labels) {
  return medium(context_of(volume, scene, options, index, labels), scene);
}

RenderResult raycast_plain(const FieldView& field, const Scene& scene, const RenderOptions& options,
                           const index::IndexVolume* index) {
  return drawn(field.bounds, scene, options, plain_caster(field, scene, options, index));
}

RenderResult raycast_plain(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                           const index::IndexVolume* index, const LabelledMedium* labels) {
  return drawn(volume::field_bounds(volume.geometry()), scene, options,
               plain_caster(volume, scene, options, index, labels));
}

}  // namespace vol::render
