#pragma once
#include <vector>

#include "index/significant_details.h"
#include "transfer/transfer_function.h"
#include "volume/volume.h"
#include "wavelet/dwt.h"

namespace vol::index {

/// What a scene makes of a volume, voxel by voxel: the extinction sigma_t, and the emission c sigma_t of each
/// colour channel that differs from the others, in units of 1 / standard_distance, so that a value is the
/// optical depth (or the light) of one standard step. These are the fields the ray integral sums, and their
/// details, not those of the raw data, say how far apart it must be sampled: what the transfer function makes
/// invisible or constant needs no samples.
///
/// Extinction is capped at the optical depth 32 a standard step, beyond which (e^-32 = 1e-14) nothing is
/// seen. \throws vol::Error unless both lengths are positive
[[nodiscard]] std::vector<volume::Grid<float>> classified_fields(const volume::Volume& volume,
                                                                 const transfer::TransferFunction& transfer,
                                                                 double reference_length,
                                                                 double standard_distance);

/// The voxels with a significant detail in any of the classified fields, for each level. Epsilon is then an
/// optical depth (or light, on the colour scale) of a standard step.
[[nodiscard]] std::vector<BitGrid> significant_classified_details(
    const volume::Volume& volume, const transfer::TransferFunction& transfer, double reference_length,
    double standard_distance, const wavelet::DwtOptions& dwt, const SignificanceOptions& options);

/// The same from the volume's coefficients: it is rebuilt from them first, and its classified fields are
/// transformed by the same wavelet.
template <class T>
[[nodiscard]] std::vector<BitGrid> significant_classified_details(
    const wavelet::Decomposition<T>& decomposition, const transfer::TransferFunction& transfer,
    double reference_length, double standard_distance, const SignificanceOptions& options);

}  // namespace vol::index
