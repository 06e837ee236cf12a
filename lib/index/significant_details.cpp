#include "index/significant_details.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "wavelet/filters.h"
#include "wavelet/layout.h"

namespace vol::index {
namespace {

/// Samples of a one-dimensional basis function on the voxels, values[n] at first + n.
struct Samples {
  std::int64_t first;
  std::vector<double> values;
};

/// One synthesis step: y[n] = sum_k taps[n - 2k] x[k].
Samples upsampled(const Samples& x, std::int64_t first, const std::vector<double>& taps) {
  Samples y{2 * x.first + first, std::vector<double>(2 * (x.values.size() - 1) + taps.size(), 0.0)};
  for (std::size_t k = 0; k < x.values.size(); ++k) {
    for (std::size_t t = 0; t < taps.size(); ++t) y.values[2 * k + t] += taps[t] * x.values[k];
  }
  return y;
}

/// Smallest interval that holds the share: ends are given up, the one with less energy first.
RelevantSupport shortest_interval(const Samples& samples, double share) {
  std::size_t begin = 0, end = samples.values.size();
  double total = 0;
  for (const double v : samples.values) total += v * v;
  double may_lose = (1 - share) * total;
  while (end - begin > 1) {
    const double left = samples.values[begin] * samples.values[begin];
    const double right = samples.values[end - 1] * samples.values[end - 1];
    const double least = std::min(left, right);
    if (least > may_lose) break;
    may_lose -= least;
    left <= right ? ++begin : --end;
  }
  return {samples.first + static_cast<std::int64_t>(begin),
          samples.first + static_cast<std::int64_t>(end) - 1};
}

constexpr std::int64_t kGrain = 1 << 18;  // coefficients a task: a small part is one, on the caller's thread

/// Sets the bits of the coefficients above the limit.
template <class T>
void add_row(const T* c, std::int64_t count, T limit, std::uint64_t* bits) {
  for (std::int64_t base = 0; base < count; base += 64) {
    const std::int64_t n = std::min<std::int64_t>(64, count - base);
    int any = 0;  // seldom, and found by vectors of them
    for (std::int64_t b = 0; b < n; ++b) any |= std::abs(c[base + b]) > limit ? 1 : 0;
    if (any == 0) continue;
    std::uint64_t word = 0;
    for (std::int64_t b = 0; b < n; ++b) {
      word |= static_cast<std::uint64_t>(std::abs(c[base + b]) > limit) << b;
    }
    bits[base >> 6] |= word;
  }
}

}  // namespace

RelevantSupport relevant_support(const std::string& name, int level, double share) {
  if (!(share > 0 && share <= 1))
    throw Error("share of energy " + std::to_string(share) + " is outside 0 to 1");
  const auto wavelet = wavelet::make_wavelet(name);
  const auto& bank = wavelet.bank;
  RelevantSupport support{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()};
  for (const auto& taps : {bank.h, bank.g}) {
    Samples samples{0, {1.0}};
    samples = upsampled(samples, bank.first, taps);
    for (int m = 1; m < level; ++m) samples = upsampled(samples, bank.first, bank.h);
    // Per axis the cube root: the share of a product is the product of shares. A full support is cut of exact
    // zeros alone (the one tap by which h and g of a Battle-Lemarie filter are shifted against each other).
    const auto part = shortest_interval(samples, std::cbrt(share));
    support.first = std::min(support.first, part.first);
    support.last = std::max(support.last, part.last);
  }
  return support;
}

SignificantDetails::SignificantDetails(const Dims& volume_dims, const wavelet::DwtOptions& dwt,
                                       double energy_share)
    : dims(volume_dims),
      extended_dims(wavelet::extended_dims(volume_dims, dwt.levels)),
      boundary(dwt.boundary) {
  const auto ranges =
      wavelet::layout(wavelet::make_wavelet(dwt.wavelet), boundary, extended_dims, dwt.levels);
  for (int m = 1; m <= dwt.levels; ++m) {
    const auto& range = ranges[static_cast<std::size_t>(m)];
    levels.push_back({BitGrid({range[0].count, range[1].count, range[2].count}),
                      {range[0].lower, range[1].lower, range[2].lower},
                      relevant_support(dwt.wavelet, m, energy_share)});
  }
}

template <class T>
std::vector<T> significance_thresholds(const SignificanceOptions& options, int levels, double largest) {
  if (!(options.epsilon >= 0)) throw Error("epsilon " + std::to_string(options.epsilon) + " is negative");
  const double noise = 8 * static_cast<double>(std::numeric_limits<T>::epsilon()) * largest;
  std::vector<T> thresholds;
  for (int m = 1; m <= levels; ++m) {
    const double to_amplitude = std::pow(2.0, 1.5 * m);
    double threshold = options.epsilon;
    if (options.rule == Rule::segment) threshold = std::ldexp(threshold, -m);
    if (options.normalisation == Normalisation::amplitude) threshold *= to_amplitude;
    threshold = std::max(threshold, noise * to_amplitude);
    thresholds.push_back(
        static_cast<T>(std::min(threshold, static_cast<double>(std::numeric_limits<T>::max()))));
  }
  return thresholds;
}

template <class T>
void add_significant(const wavelet::Decomposition<T>& part, const std::vector<T>& thresholds,
                     const Dims& begin, SignificantDetails& details) {
  for (const auto& band : part.subbands) {
    if (band.orientation == 0) continue;
    BitGrid& set = details.levels.at(static_cast<std::size_t>(band.level - 1)).coefficients;
    const std::int64_t y = begin[1] >> band.level, z = begin[2] >> band.level;
    if (band.dims[0] != set.dims()[0] || y + band.dims[1] > set.dims()[1] ||
        z + band.dims[2] > set.dims()[2]) {
      throw Error("index: the details are of a volume of other dimensions");
    }
    const T limit = thresholds[static_cast<std::size_t>(band.level - 1)];
    parallel_for(0, band.dims[1] * band.dims[2], std::max<std::int64_t>(1, kGrain / band.dims[0]),
                 [&](std::int64_t first, std::int64_t last) {
                   for (std::int64_t r = first; r < last; ++r) {
                     add_row(band.coefficients.data() + r * band.dims[0], band.dims[0], limit,
                             set.row(y + r % band.dims[1], z + r / band.dims[1]));
                   }
                 });
  }
}

template <class T>
SignificantDetails significant_details(const wavelet::Decomposition<T>& d,
                                       const SignificanceOptions& options) {
  SignificantDetails details(d.geometry.dims, {d.wavelet, d.levels, d.boundary, d.extension},
                             options.energy_share);
  const double largest = std::max(std::abs(d.range.min), std::abs(d.range.max));
  add_significant(d, significance_thresholds<T>(options, d.levels, largest), {0, 0, 0}, details);
  return details;
}

template std::vector<float> significance_thresholds(const SignificanceOptions&, int, double);
template std::vector<double> significance_thresholds(const SignificanceOptions&, int, double);
template void add_significant(const wavelet::Decomposition<float>&, const std::vector<float>&, const Dims&,
                              SignificantDetails&);
template void add_significant(const wavelet::Decomposition<double>&, const std::vector<double>&, const Dims&,
                              SignificantDetails&);
template SignificantDetails significant_details(const wavelet::Decomposition<float>&,
                                                const SignificanceOptions&);
template SignificantDetails significant_details(const wavelet::Decomposition<double>&,
                                                const SignificanceOptions&);

}  // namespace vol::index
