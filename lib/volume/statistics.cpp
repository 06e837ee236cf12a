#include "volume/statistics.h"

#include <algorithm>
#include <cmath>

#include "base/compensated_sum.h"
#include "base/error.h"
#include "base/parallel.h"

namespace vol::volume {
namespace {

constexpr std::int64_t kGrain = 1 << 18;  // voxels a task

}  // namespace

Statistics statistics(const Volume& volume) {
  Statistics result;
  result.range = value_range(volume);
  // Deviations are summed from the middle of the range and on its scale: a small signal on a large offset
  // keeps its digits, and 1e200 does not overflow.
  const double middle = 0.5 * result.range.min + 0.5 * result.range.max;
  const double scale = std::max(0.5 * result.range.max - 0.5 * result.range.min, 0.0);
  struct Sums {
    CompensatedSum first, second;
    std::int64_t zeros = 0;
  };
  const Sums sums = visit(volume, [&](const auto& grid) {
    return parallel_reduce<Sums>(
        0, grid.geometry.count(), kGrain,
        [&](std::int64_t begin, std::int64_t end) {
          Sums part;
          for (std::int64_t n = begin; n < end; ++n) {
            const auto value = static_cast<double>(grid.voxels[static_cast<std::size_t>(n)]);
            const double deviation = scale > 0 ? (value - middle) / scale : 0.0;
            part.first.add(deviation);
            part.second.add(deviation * deviation);
            if (value == 0) ++part.zeros;
          }
          return part;
        },
        [](Sums& total, const Sums& part) {
          total.first.add(part.first);
          total.second.add(part.second);
          total.zeros += part.zeros;
        });
  });
  const auto count = static_cast<double>(volume.geometry().count());
  const double mean = sums.first.value() / count;
  result.mean = middle + scale * mean;
  result.standard_deviation = scale * std::sqrt(std::max(0.0, sums.second.value() / count - mean * mean));
  result.zeros = sums.zeros;
  return result;
}

std::vector<std::int64_t> histogram(const Volume& volume, const Range& range, int bins) {
  if (bins < 1) throw Error("a histogram of " + std::to_string(bins) + " bins, expected at least 1");
  // Halved, so that no difference overflows; one product and one quotient, so that whole numbers on the edge
  // of a bin are not rounded into the bin below.
  const double width = 0.5 * range.max - 0.5 * range.min;
  using Counts = std::vector<std::int64_t>;
  Counts counts = visit(volume, [&](const auto& grid) {
    return parallel_reduce<Counts>(
        0, grid.geometry.count(), kGrain,
        [&](std::int64_t begin, std::int64_t end) {
          Counts part(static_cast<std::size_t>(bins));
          for (std::int64_t n = begin; n < end; ++n) {
            const auto value = static_cast<double>(grid.voxels[static_cast<std::size_t>(n)]);
            const double from_min = 0.5 * value - 0.5 * range.min;
            const double bin = width > 1e290 ? from_min / width * bins
                               : width > 0   ? from_min * bins / width
                                             : 0.0;
            ++part[static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(bins - 1)))];
          }
          return part;
        },
        [&](Counts& total, const Counts& part) {
          total.resize(static_cast<std::size_t>(bins));
          for (std::size_t b = 0; b < part.size(); ++b) total[b] += part[b];
        });
  });
  return counts;
}

}  // namespace vol::volume
