#pragma once
#include <functional>
#include <limits>
#include <span>

#include "render/ray_box.h"
#include "render/raycast.h"
#include "render/refinement.h"

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

/// One ray's light so far, from the eye on.
struct Beam {
  Pixel pixel;
  double transmittance = 1;
};

/// Integrates a part of a ray that has got so far (model composite): adds to the beam and the counts.
/// \param whole  length of the chord that it is a part of, which a tolerance is for
using MediumCaster =
    std::function<void(const camera::Ray&, const Chord& part, double whole, Beam&, RenderCounts&)>;

/// Casts a ray that misses the field's box.
using BesideCaster = std::function<Pixel(const camera::Ray&, RenderCounts&)>;

/// Camera, rays, threads and image around a caster of one ray. Counts are folded row by row: the same
/// whatever the number of threads.
[[nodiscard]] RenderResult draw(const volume::FieldBounds& bounds, const Scene& scene,
                                const RenderOptions& options, const RayCaster& cast,
                                const BesideCaster& beside = {});

/// Number of the channel `error`, in pictures that have it.
inline constexpr std::size_t kErrorChannel = 6;

/// What no ray meets: depth infinite, all else 0; with a channel `error` where options.max_error asks for it.
/// In the memory of `spare`, where there is any.
[[nodiscard]] image::Image blank_image(const RenderOptions& options, image::Image spare = {});

/// Casts some pixels of a picture anew, and adds what that costs to its counts.
void redraw(const volume::FieldBounds& bounds, const Scene& scene, std::span<const PixelPosition> pixels,
            const RayCaster& cast, RenderResult& result);

/// What raycast_plain and raycast_reference do to a ray. Refer to the field, the volume, the index
/// and the labels, which must live longer.
[[nodiscard]] RayCaster plain_caster(const FieldView& field, const Scene& scene, const RenderOptions& options,
                                     const index::IndexVolume* index = nullptr);
[[nodiscard]] RayCaster plain_caster(const volume::Volume& volume, const Scene& scene,
                                     const RenderOptions& options, const index::IndexVolume* index = nullptr,
                                     const LabelledMedium* labels = nullptr);
[[nodiscard]] RayCaster reference_caster(const FieldView& field, const Scene& scene,
                                         const RenderOptions& options);
[[nodiscard]] RayCaster reference_caster(const volume::Volume& volume, const Scene& scene,
                                         const RenderOptions& options);

/// The same for the parts of rays between surfaces. \throws vol::Error on a model that is not `composite`
[[nodiscard]] MediumCaster plain_medium(const FieldView& field, const Scene& scene,
                                        const RenderOptions& options,
                                        const index::IndexVolume* index = nullptr);
[[nodiscard]] MediumCaster plain_medium(const volume::Volume& volume, const Scene& scene,
                                        const RenderOptions& options,
                                        const index::IndexVolume* index = nullptr,
                                        const LabelledMedium* labels = nullptr);
/// \param brightest  upper bound of what else than the medium is in the picture
[[nodiscard]] MediumCaster reference_medium(const FieldView& field, const Scene& scene,
                                            const RenderOptions& options, double brightest = 0);
[[nodiscard]] MediumCaster reference_medium(const volume::Volume& volume, const Scene& scene,
                                            const RenderOptions& options, double brightest = 0);

/// The scene's reference length, or where it has none the field's smallest spacing (0: the field has none
/// either, vol::Error).
[[nodiscard]] double resolved_reference_length(const Scene& scene, double smallest_spacing);

}  // namespace vol::render
