#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "wavelet/analysis_level.h"

namespace vol::wavelet {

/// One axis of one synthesis level. Pair t gives the two neighbouring samples first_sample + 2t + {0, 1}:
///   x[2t + p] = sum_j h[2j + p] c[t - j] + g[2j + p] d[t - j].
template <class T>
struct SynthesisAxis {
  struct Term {
    int band;          ///< 0 low, 1 high
    std::int64_t lag;  ///< j
  };
  bool transformed = true;
  std::int64_t inputs = 1;   ///< coefficients a band
  std::int64_t outputs = 1;  ///< samples wanted
  std::int64_t pairs = 1;
  std::int64_t first_sample = 0;     ///< of pair 0: 0 or -1
  std::int64_t lags = 1;             ///< taps / 2
  std::vector<Term> terms;           ///< in the order of summation, small taps first
  std::vector<T> even, odd;          ///< factors of the terms
  std::int64_t origin = 0;           ///< coefficient of pair 0 and lag 0, before wrapping
  std::vector<std::int64_t> source;  ///< coefficient, wrapped, of t - j at [t - j + lags - 1]

  [[nodiscard]] int bands() const { return transformed ? 2 : 1; }
};

/// \param out     range of the level below, of which the first `wanted` samples are asked for
/// \param in      range of this level's coefficients
template <class T>
[[nodiscard]] SynthesisAxis<T> synthesis_axis(const Wavelet& wavelet, Boundary boundary,
                                              const IndexRange& out, const IndexRange& in,
                                              std::int64_t wanted, bool transformed);

/// Inverse of analyze_level: `to` receives outputs[0] x outputs[1] x outputs[2] samples.
template <class T>
void synthesize_level(const std::array<const T*, 8>& bands, const std::array<SynthesisAxis<T>, 3>& axes,
                      T* to);

}  // namespace vol::wavelet
