#include "index/significant_details.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "wavelet/filters.h"

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
  return {samples.first + static_cast<std::int64_t>(begin), samples.first + static_cast<std::int64_t>(end) - 1};
}

/// Sets bits first..last of a row of n bits, wrapped around (periodic) or clipped.
void set_range(std::uint64_t* row, std::int64_t n, std::int64_t first, std::int64_t last, bool periodic) {
  if (periodic) {
    if (last - first + 1 >= n) first = 0, last = n - 1;
    const std::int64_t turn = first >= 0 ? first / n : -((-first + n - 1) / n);
    first -= turn * n, last -= turn * n;
    if (last >= n) {
      set_range(row, n, 0, last - n, false);
      last = n - 1;
    }
  }
  first = std::max<std::int64_t>(first, 0), last = std::min(last, n - 1);
  if (first > last) return;
  const std::int64_t first_word = first >> 6, last_word = last >> 6;
  const std::uint64_t head = ~std::uint64_t{0} << (first & 63), tail = ~std::uint64_t{0} >> (63 - (last & 63));
  if (first_word == last_word) {
    row[first_word] |= head & tail;
    return;
  }
  row[first_word] |= head;
  for (std::int64_t w = first_word + 1; w < last_word; ++w) row[w] = ~std::uint64_t{0};
  row[last_word] |= tail;
}

/// The coefficients of one level as a set: those above the threshold in any orientation.
template <class T>
BitGrid significant_coefficients(const wavelet::Decomposition<T>& decomposition, int level, double threshold,
                                 std::array<std::int64_t, 3>& lower) {
  BitGrid set;
  bool first = true;
  for (const auto& band : decomposition.subbands) {
    if (band.level != level || band.orientation == 0) continue;
    if (first) {
      set = BitGrid(band.dims);
      lower = band.lower;
      first = false;
    }
    const T limit = static_cast<T>(threshold);
    parallel_for(0, band.dims[2], 4, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t row = begin * band.dims[1]; row < end * band.dims[1]; ++row) {
        const T* c = band.coefficients.data() + row * band.dims[0];
        std::uint64_t* bits = set.row(row % band.dims[1], row / band.dims[1]);
        for (std::int64_t base = 0; base < band.dims[0]; base += 64) {
          const std::int64_t n = std::min<std::int64_t>(64, band.dims[0] - base);
          std::uint64_t word = 0;
          for (std::int64_t b = 0; b < n; ++b) {
            word |= static_cast<std::uint64_t>(std::abs(c[base + b]) > limit) << b;
          }
          bits[base >> 6] |= word;
        }
      }
    });
  }
  return set;
}

/// From coefficients to the voxels they bear on: along x by ranges of bits, along y and z by rows.
BitGrid spread(const BitGrid& coefficients, const std::array<std::int64_t, 3>& lower, int level,
               const RelevantSupport& support, const Dims& dims, const Dims& extended, bool periodic) {
  const std::int64_t scale = std::int64_t{1} << level;
  const Dims& coarse = coefficients.dims();
  const auto range = [&](int axis, std::int64_t k) -> RelevantSupport {
    const auto a = static_cast<std::size_t>(axis);
    if (extended[a] == 1) return {0, 0};  // an axis of one sample is not transformed
    return {scale * (lower[a] + k) + support.first, scale * (lower[a] + k) + support.last};
  };
  const auto for_each_target = [&](int axis, std::int64_t k, auto&& visit) {
    const auto a = static_cast<std::size_t>(axis);
    auto [first, last] = range(axis, k);
    if (periodic) last = std::min(last, first + extended[a] - 1);
    for (std::int64_t v = first; v <= last; ++v) {
      const std::int64_t at = periodic ? ((v % extended[a]) + extended[a]) % extended[a] : v;
      if (at >= 0 && at < dims[a]) visit(at);
    }
  };
  BitGrid along_x({extended[0], coarse[1], coarse[2]});
  parallel_for(0, coarse[2], 4, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int64_t j = 0; j < coarse[1]; ++j) {
        const std::uint64_t* from = coefficients.row(j, k);
        for (std::int64_t w = 0; w < coefficients.words_per_row(); ++w) {
          for (std::uint64_t rest = from[w]; rest != 0; rest &= rest - 1) {
            const auto [first, last] = range(0, 64 * w + __builtin_ctzll(rest));
            set_range(along_x.row(j, k), extended[0], first, last, periodic);
          }
        }
      }
    }
  });
  const std::int64_t words = (dims[0] + 63) / 64;
  BitGrid along_xy({dims[0], dims[1], coarse[2]});
  parallel_for(0, coarse[2], 4, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int64_t j = 0; j < coarse[1]; ++j) {
        const std::uint64_t* from = along_x.row(j, k);
        for_each_target(1, j, [&](std::int64_t y) {
          std::uint64_t* to = along_xy.row(y, k);
          for (std::int64_t w = 0; w < words; ++w) to[w] |= from[w];
        });
      }
    }
  });
  BitGrid result(dims);
  const int tail = static_cast<int>(dims[0] & 63);  // the extension's voxels do not exist
  const std::uint64_t last_mask = tail == 0 ? ~std::uint64_t{0} : (std::uint64_t{1} << tail) - 1;
  parallel_for(0, dims[1], 8, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = 0; k < coarse[2]; ++k) {
      for_each_target(2, k, [&](std::int64_t z) {
        for (std::int64_t y = begin; y < end; ++y) {
          const std::uint64_t* from = along_xy.row(y, k);
          std::uint64_t* to = result.row(y, z);
          for (std::int64_t w = 0; w < words; ++w) to[w] |= from[w];
        }
      });
    }
    for (std::int64_t z = 0; z < dims[2]; ++z) {
      for (std::int64_t y = begin; y < end; ++y) result.row(y, z)[words - 1] &= last_mask;
    }
  });
  return result;
}

}  // namespace

RelevantSupport relevant_support(const std::string& name, int level, double share) {
  if (!(share > 0 && share <= 1)) throw Error("share of energy " + std::to_string(share) + " is outside 0 to 1");
  const auto wavelet = wavelet::make_wavelet(name);
  const auto& bank = wavelet.bank;
  RelevantSupport support{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()};
  for (const auto& taps : {bank.h, bank.g}) {
    Samples samples{0, {1.0}};
    samples = upsampled(samples, bank.first, taps);
    for (int m = 1; m < level; ++m) samples = upsampled(samples, bank.first, bank.h);
    // Per axis the cube root: the share of a product is the product of shares. A full support is cut of exact zeros
    // alone (the one tap by which h and g of a Battle-Lemarie filter are shifted against each other).
    const auto part = shortest_interval(samples, std::cbrt(share));
    support.first = std::min(support.first, part.first);
    support.last = std::max(support.last, part.last);
  }
  return support;
}

template <class T>
std::vector<BitGrid> significant_details(const wavelet::Decomposition<T>& decomposition,
                                         const SignificanceOptions& options) {
  if (!(options.epsilon >= 0)) throw Error("epsilon " + std::to_string(options.epsilon) + " is negative");
  const double largest = std::max(std::abs(decomposition.range.min), std::abs(decomposition.range.max));
  const double noise = 8 * static_cast<double>(std::numeric_limits<T>::epsilon()) * largest;
  std::vector<BitGrid> levels;
  for (int m = 1; m <= decomposition.levels; ++m) {
    const double to_amplitude = std::pow(2.0, 1.5 * m);
    double threshold = options.epsilon;
    if (options.rule == Rule::segment) threshold = std::ldexp(threshold, -m);
    if (options.normalisation == Normalisation::amplitude) threshold *= to_amplitude;
    threshold = std::min(std::max(threshold, noise * to_amplitude), static_cast<double>(std::numeric_limits<T>::max()));
    std::array<std::int64_t, 3> lower{};
    const BitGrid coefficients = significant_coefficients(decomposition, m, threshold, lower);
    if (coefficients.dims()[0] == 0) {  // every axis has one sample: there are no details
      levels.emplace_back(decomposition.geometry.dims);
      continue;
    }
    const auto support = relevant_support(decomposition.wavelet, m, options.energy_share);
    levels.push_back(spread(coefficients, lower, m, support, decomposition.geometry.dims, decomposition.extended_dims,
                            decomposition.boundary == wavelet::Boundary::periodic));
  }
  return levels;
}

template std::vector<BitGrid> significant_details(const wavelet::Decomposition<float>&, const SignificanceOptions&);
template std::vector<BitGrid> significant_details(const wavelet::Decomposition<double>&, const SignificanceOptions&);

}  // namespace vol::index
