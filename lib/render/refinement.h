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

/// A picture from rays at every `step`-th pixel and wherever it bends between them (after Levoy 1990).
///
/// The image is covered by square cells of `step` pixels with rays at their corners. Where the second
/// differences through a cell's corners (the largest over the channels R, G, B, A), along rows plus along
/// columns, are at most twice `tolerance`, its other pixels are interpolated: bilinearly, and where the
/// pixels one cell further on were cast too, with what the cubics of Catmull and Rom (1974) add to lines
/// along rows and along columns (at most a quarter of the tolerance). A kink inside a cell is missed by
/// little more than the tolerance then (at the picture's rim and beside larger cells by up to twice that), a
/// smooth picture by far less. Other cells are cut into four, down to single pixels. What lies between the
/// rays altogether is missed. Interpolated pixels have 0 in channel 4, `samples`; channel 5, `depth`, is
/// interpolated where all four corners have one and is else the nearest corner's.
///
/// \param image  blank (picture.h: blank_image), of finite colours where it is cast; what lies between rays
///     that meet nothing stays blank
/// \param step  a power of two, 1 to 64; 1 casts every ray
/// \param tolerance  >= 0, in units of the channels
/// \throws vol::Error on a step or tolerance out of range
void cast_refined(image::Image& image, int step, double tolerance, const CastPixels& cast);

}  // namespace vol::render
