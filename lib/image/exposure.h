#pragma once
#include "image/image.h"

namespace vol::image {

/// What a picture whose values are no colours (X-rays, maxima) is multiplied by to be looked at: 1 over the
/// largest finite value of its channels R, G and B, which becomes white; 1 where none is positive.
/// \throws vol::Error where a channel is missing
[[nodiscard]] double exposure_to_white(const Image& picture);

}  // namespace vol::image
