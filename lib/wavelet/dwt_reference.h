#pragma once
#include "wavelet/dwt.h"

namespace vol::wavelet {

/// The transform as its definition says it, one line of samples at a time, in double: the oracle of
/// analyze(). Not for use on more than small volumes. \throws vol::Error on another initialisation than
/// samples
[[nodiscard]] Decomposition<double> analyze_reference(const volume::Volume& volume,
                                                      const DwtOptions& options);

/// The inverse as its definition says it; the oracle of synthesize().
[[nodiscard]] volume::Grid<double> synthesize_reference(const Decomposition<double>& decomposition);

}  // namespace vol::wavelet
