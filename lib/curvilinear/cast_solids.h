#pragma once
#include <span>
#include <vector>

#include "curvilinear/ray_solids.h"
#include "render/picture.h"

namespace vol::curvilinear {

/// The reference picture of a curvilinear grid: the emission-absorption integral itself along every camera
/// ray, to options.tolerance, in double precision (render/reference_integral.h); xray and mip as well.
///
/// A ray is cut where it passes from solid to solid (SolidRays); inside, the field is fitted by polynomials
/// of t (SolidPath) to a thousandth of the tolerance, on the scale of the shorter of the values' range and
/// the shortest distance of two of the transfer function's points. Solids that the transfer function makes
/// invisible are passed over. Steps and early termination play no part. The camera looks at the box of the
/// grid's points; solids that bulge beyond it are seen too.
///
/// \param options  width, height, tolerance, image_step, image_tolerance; the rest plays no part
/// \returns channels and counts as raycast_reference; the same whatever the number of threads
/// \throws vol::Error on options out of range, and for composite on a scene without reference_length
[[nodiscard]] render::RenderResult cast_solids(const SolidRays& rays, const render::Scene& scene,
                                               const render::RenderOptions& options);

/// The same for some pixels of that picture, in their order. \param counts  rays, samples and gradients are
/// added
[[nodiscard]] std::vector<render::Pixel> cast_pixels(const SolidRays& rays, const render::Scene& scene,
                                                     const render::RenderOptions& options,
                                                     std::span<const render::PixelPosition> pixels,
                                                     render::RenderCounts& counts);

}  // namespace vol::curvilinear
