#pragma once
#include "volume/field_sampler.h"
#include "volume/volume.h"

namespace vol::volume {

/// The geometry of `dims` samples over the same box, the one spanned by the outermost centres: spacing
/// (n-1)/(n'-1) times the old one, the corner samples where they were. A single new sample sits in the middle
/// of the box, which is its spacing thick; a single old one has a box to spread over likewise.
[[nodiscard]] GridGeometry resampled_geometry(const GridGeometry& geometry, const Dims& dims);

/// The field that a kernel reconstructs, sampled at new centres over the same box. Separable, in double; the
/// type stays: integers are rounded to nearest even and clamped (Catmull-Rom and B-spline overshoot). Equal
/// dims give the same voxels, exactly for all kernels but the B-spline, whose prefilter rounds. No low-pass
/// filter goes before: fewer samples alias.
[[nodiscard]] Volume resampled(const Volume& volume, const Dims& dims, Reconstruction kernel);

/// "nearest", "trilinear", "catmull-rom", "b-spline".
[[nodiscard]] std::string_view name(Reconstruction kernel);
/// Inverse of name(); throws vol::Error listing the names.
[[nodiscard]] Reconstruction reconstruction_from_name(std::string_view name);

}  // namespace vol::volume
