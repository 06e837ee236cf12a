#pragma once
#include "index/significant_details.h"
#include "transfer/transfer_function.h"
#include "volume/volume.h"
#include "wavelet/dwt.h"

namespace vol::index {

/// The significant details of any of the fields that a scene makes of a volume (ClassifiedFields). Epsilon is
/// an optical depth (or light, on the colour scale) of a standard step.
///
/// The fields are made and transformed part by part. Haar's basis functions do not overlap: boxes of at least
/// 2^levels voxels along each axis and whole rows along x, of about 2^17 voxels, give the coefficients of the
/// whole bit for bit, by as many threads as there are and out of their caches. Any other wavelet's part is
/// the whole.
[[nodiscard]] SignificantDetails significant_classified_details(
    const volume::Volume& volume, const transfer::TransferFunction& transfer, double reference_length,
    double standard_distance, const wavelet::DwtOptions& dwt, const SignificanceOptions& options);

/// The same from the volume's coefficients: it is rebuilt from them first, and its classified fields are
/// transformed by the same wavelet.
template <class T>
[[nodiscard]] SignificantDetails significant_classified_details(
    const wavelet::Decomposition<T>& decomposition, const transfer::TransferFunction& transfer,
    double reference_length, double standard_distance, const SignificanceOptions& options);

}  // namespace vol::index
