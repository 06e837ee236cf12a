#pragma once
#include "transfer/bezier.h"
#include "volume/volume.h"

namespace vol::render {

/// Every voxel f as BezierTransfer::weighted(f, channel): v sum colour B(v), v the scaled value; f64 for an
/// f64 volume, else f32. What lies between is then interpolated as the field's values are, so that the X-ray
/// of the result is the picture of Fourier volume rendering, which weights voxels before its transform.
[[nodiscard]] volume::Volume weighted_volume(const volume::Volume& volume,
                                             const transfer::BezierTransfer& bezier, int channel);

}  // namespace vol::render
