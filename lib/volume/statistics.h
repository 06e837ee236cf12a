#pragma once
#include <cstdint>
#include <vector>

#include "volume/volume.h"

namespace vol::volume {

struct Statistics {
  Range range;
  double mean = 0;                ///< sum carried with its rounding errors: as exact as one double can be
  double standard_deviation = 0;  ///< root of the mean squared deviation from the mean
  std::int64_t zeros = 0;         ///< voxels equal to 0
};

/// Throws vol::Error on NaN or infinity. The same figures whatever the number of threads.
[[nodiscard]] Statistics statistics(const Volume& volume);

/// Number of voxels in each of `bins` equal intervals of [range.min, range.max]; the last is closed, the
/// others are half open. A range of one value puts all voxels into the first. \param bins at least 1
[[nodiscard]] std::vector<std::int64_t> histogram(const Volume& volume, const Range& range, int bins);

}  // namespace vol::volume
