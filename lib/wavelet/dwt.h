#pragma once
#include <string>

#include "volume/volume.h"
#include "wavelet/decomposition.h"

namespace vol::wavelet {

struct DwtOptions {
  std::string wavelet = "haar";
  int levels = 3;  ///< 0 stores the volume itself as level0.LLL
  Boundary boundary = Boundary::periodic;
  Extension extension = Extension::replicate;
  Initialisation initialisation = Initialisation::samples;
};

/// Orthonormal separable 3-D wavelet transform (Mallat 1989) of a volume of any voxel type, in the precision
/// T: each level filters and decimates the approximation of the level below along x, y and z,
///   c'[k] = sum_n h[n] c[2k + n],  d[k] = sum_n g[n] c[2k + n],
/// an axis of one sample excepted. Sizes that 2^levels does not divide are extended first. c is the volume at
/// first, or with `interpolate` B^-1 of the extended volume (initialisation.h), which takes a copy of it in
/// T.
///
/// One pass over memory a level: planes are filtered along x and y as they are read, kept in a ring that fits
/// the second-level cache, and filtered along z straight into the subbands. Takes, beyond the volume and the
/// coefficients, an eighth of a volume of T and about 1 MiB a thread (more for Battle-Lemarie).
/// The result has the same bits for any number of threads and any vector width.
///
/// \param range  of the volume: from volume::value_range(), which refuses NaN and infinity
/// Throws vol::Error on an unknown wavelet, on too many levels, when coefficients could overflow T, and what
/// require_interpolation() throws.
template <class T>
[[nodiscard]] Decomposition<T> analyze(const volume::Volume& volume, const DwtOptions& options,
                                       const volume::Range& range);

/// The inverse: the volume's own box, in the precision of the coefficients; of `interpolate` the values that
/// the expansion takes at the voxels, B c, for which the extended box is rebuilt. Exact but for rounding; for
/// the truncated Battle-Lemarie filters off by what frame_bounds() says. Throws vol::Error when the
/// decomposition is not one that analyze() makes (validate()).
template <class T>
[[nodiscard]] volume::Grid<T> synthesize(const Decomposition<T>& decomposition);

}  // namespace vol::wavelet
