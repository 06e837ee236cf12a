#include "fit/samples.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <type_traits>

#include "base/error.h"

namespace vol::fit {
namespace {

void require_extent(const volume::Range& range, int count) {
  if (!(range.max > range.min) || !std::isfinite(range.max - range.min)) {
    throw Error("a curve needs a range of values with an extent; give --range");
  }
  if (count < 1) throw Error("at least 1 sample is needed");
}

/// Every value of the volume with its number of voxels; of wide types the middles of bins.
std::map<double, std::int64_t> counted_values(const volume::Volume& volume, const volume::Range& range,
                                              int bins) {
  const volume::Range all = volume::value_range(volume);
  const bool whole = volume::visit(volume, [](const auto& grid) {
    return std::is_integral_v<typename std::decay_t<decltype(grid)>::value_type>;
  });
  const double steps = all.max - all.min;
  std::map<double, std::int64_t> found;
  if (whole && steps < 65536) {
    // One bin a value: the interval of histogram() for the value k begins at k - 1/2.
    const auto counts =
        volume::histogram(volume, {all.min - 0.5, all.max + 0.5}, static_cast<int>(steps) + 1);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] > 0)
        found[std::clamp(all.min + static_cast<double>(i), range.min, range.max)] += counts[i];
    }
    return found;
  }
  // What lies outside the range is in the first or the last bin.
  const auto counts = volume::histogram(volume, range, bins);
  const double width = (range.max - range.min) / bins;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    // Of bins narrower than a double's digits several have one middle.
    if (counts[i] > 0) {
      found[std::min(range.min + (static_cast<double>(i) + 0.5) * width, range.max)] += counts[i];
    }
  }
  return found;
}

}  // namespace

std::vector<double> Samples::targets(const std::function<double(double)>& f) const {
  std::vector<double> values;
  for (const double at : value) values.push_back(f(at));
  return values;
}

Samples uniform_samples(const volume::Range& range, int count) {
  require_extent(range, count);
  Samples samples{{}, {}, range};
  for (int i = 0; i < count; ++i) {
    samples.v.push_back((i + 0.5) / count);
    samples.value.push_back(range.min + samples.v.back() * (range.max - range.min));
    samples.weight.push_back(1.0 / count);
  }
  return samples;
}

Weighting weighting_from_name(const std::string& name) {
  if (name == "uniform") return Weighting::uniform;
  if (name == "histogram") return Weighting::histogram;
  if (name == "log-histogram") return Weighting::log_histogram;
  throw Error("weighting " + name + " is not known; uniform, histogram, log-histogram are");
}

Samples histogram_samples(const volume::Volume& volume, const volume::Range& range, int bins,
                          Weighting weighting) {
  require_extent(range, bins);
  if (weighting == Weighting::uniform) throw Error("uniform weights are no histogram's");
  Samples samples{{}, {}, range};
  double sum = 0;
  for (const auto& [value, count] : counted_values(volume, range, bins)) {
    const auto n = static_cast<double>(count);
    samples.v.push_back((value - range.min) / (range.max - range.min));
    samples.value.push_back(value);
    samples.weight.push_back(weighting == Weighting::histogram ? n : std::log1p(n));
    sum += samples.weight.back();
  }
  for (double& w : samples.weight) w /= sum;
  return samples;
}

}  // namespace vol::fit
