#pragma once
#include <cstdint>
#include <functional>
#include <span>

#include "image/image.h"

namespace vol::render {

struct PixelPosition {
  std::int32_t x, y;
};

/// Casts the rays of these pixels into the image; no pixel comes twice.
using CastPixels = std::function<void(std::span<const PixelPosition>)>;

/// A picture from rays at every `step`-th pixel and wherever its neighbourhood is not flat.
///
/// The image is covered by square cells of `step` pixels, rays at their corners, their centres and the
/// middles of their sides. Where bilinear interpolation of the corners meets the other five within
/// `tolerance`, in each of the channels R, G, B, A, the cell's remaining pixels are interpolated, by the
/// biquadratic through all nine; elsewhere the cell is cut into four, down to single pixels. Where the
/// picture is smooth the error is well below the tolerance; what lies between the rays altogether is missed.
/// Interpolated pixels have 0 in channel 4, `samples`; channel 5, `depth`, is interpolated where all four
/// corners have one and is else the nearest corner's.
///
/// \param step  a power of two, 1 to 64; 1 casts every ray
/// \param tolerance  >= 0, in units of the channels
/// \throws vol::Error on a step or tolerance out of range
void cast_refined(image::Image& image, int step, double tolerance, const CastPixels& cast);

}  // namespace vol::render
