#pragma once
#include <functional>
#include <string>
#include <vector>

#include "volume/statistics.h"

namespace vol::fit {

/// Where curves are fitted and how much each place counts.
struct Samples {
  std::vector<double> v;       ///< data values scaled by the range to [0, 1], ascending
  std::vector<double> weight;  ///< positive, of sum 1
  volume::Range range;         ///< data values of v = 0 and v = 1
  /// Data values themselves: what v and the range make again of an integer is it but for rounding, and misses
  /// a band that ends there.
  std::vector<double> value{};

  /// f at every sample's data value.
  [[nodiscard]] std::vector<double> targets(const std::function<double(double)>& f) const;
};

/// `count` places (i + 1/2)/count, all alike. \throws vol::Error for less than 1 or a range without extent
[[nodiscard]] Samples uniform_samples(const volume::Range& range, int count);

enum class Weighting { uniform, histogram, log_histogram };
/// uniform, histogram, log-histogram. \throws vol::Error for another name
[[nodiscard]] Weighting weighting_from_name(const std::string& name);

/// The values that occur in a volume, clamped to the range, each with its number of voxels n (histogram) or
/// log(1 + n): exactly the values where voxels are integers of at most 65536 values, else the middles of
/// `bins` equal intervals. What does not occur has no sample. \throws vol::Error for Weighting::uniform, NaN
/// or infinity in the volume, less than 1 bin, a range without extent
[[nodiscard]] Samples histogram_samples(const volume::Volume& volume, const volume::Range& range, int bins,
                                        Weighting weighting);

}  // namespace vol::fit
