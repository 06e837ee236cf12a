#pragma once
#include "render/packet.h"

namespace vol::render {

/// A picture whose largest error is, by every ray's own estimate, at most options.max_error, on the colour
/// scale (linear, 0 to 1; alpha too; xray and mip: relative to the picture's largest value).
///
/// Every ray is integrated cell by cell in packets (quadrature split), its pieces halved until the sum of
/// their error estimates is within the bound: a rule of n Gauss nodes against one of n - 1, times what of
/// their difference is still seen. A ray ends where what is left to see is 5/8 of the bound (a third with a
/// light from the side, which also takes 0.3 of it for kinks that hide between the places looked at). Rays
/// whose pieces could not be made small enough, and scenes that the packets do not cover, are integrated in
/// double by the reference's adaptive rule (reference_integral.h) to a quarter of the bound. Quadrature,
/// nodes, tolerance and image_step of the options play no part: rays left out between others could miss what
/// lies between them. What the shares rest on is measured (tests/render/test_max_error.cpp), not proved.
///
/// \returns the picture with a channel `error`, each pixel's estimate; error_estimate is the largest of them
/// and may
///          exceed max_error, which is then not kept
/// \throws vol::Error unless max_error is positive and finite
[[nodiscard]] RenderResult raycast_within_error(const PacketVolume& volume, const Scene& scene,
                                                const RenderOptions& options);

/// The same in two steps, for any number of views: a scene prepared with these options, then its pictures.
/// \throws vol::Error unless max_error is positive
[[nodiscard]] RenderOptions within_error(const RenderOptions& options);
[[nodiscard]] RenderResult cast_within_error(const PacketScene& scene, const camera::View& view);

}  // namespace vol::render
