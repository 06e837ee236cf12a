#pragma once
#include <functional>
#include <limits>

#include "render/ray_box.h"
#include "render/raycast.h"

namespace vol::render {

/// One pixel of a ray caster.
struct Pixel {
  Vec3 colour = Vec3::Zero();
  double alpha = 0;
  double depth = std::numeric_limits<double>::infinity();
  double error = 0;
};

/// Throws vol::Error on an image size, step, tolerance or termination out of range.
void require_valid(const RenderOptions& options);

/// Casts one ray along a chord of the field's box: adds to the counts and returns its pixel, in double.
using RayCaster = std::function<Pixel(const camera::Ray&, const Chord&, RenderCounts&)>;

/// Camera, rays, threads and image around a caster of one ray. Counts are folded row by row: the same
/// whatever the number of threads.
[[nodiscard]] RenderResult draw(const volume::FieldBounds& bounds, const Scene& scene,
                                const RenderOptions& options, const RayCaster& cast);

/// What raycast_plain and raycast_reference do to a ray. Refer to the field, the volume and the index, which
/// must live longer.
[[nodiscard]] RayCaster plain_caster(const FieldView& field, const Scene& scene, const RenderOptions& options,
                                     const index::IndexVolume* index = nullptr);
[[nodiscard]] RayCaster plain_caster(const volume::Volume& volume, const Scene& scene,
                                     const RenderOptions& options, const index::IndexVolume* index = nullptr);
[[nodiscard]] RayCaster reference_caster(const FieldView& field, const Scene& scene,
                                         const RenderOptions& options);
[[nodiscard]] RayCaster reference_caster(const volume::Volume& volume, const Scene& scene,
                                         const RenderOptions& options);

/// The scene's reference length, or where it has none the field's smallest spacing (0: the field has none
/// either, vol::Error).
[[nodiscard]] double resolved_reference_length(const Scene& scene, double smallest_spacing);

}  // namespace vol::render
