#pragma once
#include "index/build_index.h"
#include "transfer/transfer_function.h"
#include "volume/volume.h"

namespace vol::index {

/// The index of the field as a transfer function shows it, with choices that serve most scenes: Haar, as many
/// levels as the longest axis has and at most 4 (a coefficient of level 4 spans 16 voxels), supports that
/// hold 99 % of a basis function's energy. \param epsilon  optical depth of a standard step below which a
/// detail does not count
[[nodiscard]] IndexVolume index_of_scene(const volume::Volume& volume,
                                         const transfer::TransferFunction& transfer, double reference_length,
                                         double epsilon, const IndexOptions& options);

}  // namespace vol::index
