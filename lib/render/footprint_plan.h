#pragma once
#include "render/footprint_picture.h"
#include "render/wavelet_footprints.h"

namespace vol::render {

/// Decides how the terms of an expansion are drawn in a view (WaveletFootprints says which ways there are and
/// how the error is kept), and makes the tables.
/// \param error  share of the picture's range
[[nodiscard]] FootprintReport plan_footprints(double error, FootprintPicture& picture);

}  // namespace vol::render
