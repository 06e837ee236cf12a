#pragma once
#include <algorithm>
#include <cmath>

#include "render/footprint_kernel.h"

namespace vol::render {

inline constexpr int kRowMargin = 2, kColumnMargin = 2;

/// The planes that a term at a place between pixels is interpolated from.
struct FootprintTaps {
  const float* plane[16];  ///< at the window's first pixel
  float weight[16];
};

/// kTaps is 4 (linear) or 16 (cubic). A phase below 0 or above the last one is another plane's, one pixel on
/// (two, where there is a single one).
template <int kTaps>
inline void find_taps(const FootprintPhases& phases, const Splat& splat, FootprintTaps& taps) {
  constexpr int kWidth = kTaps == 16 ? 4 : 2;
  const auto weights = [](float v, float* w) {
    if constexpr (kWidth == 2) {
      w[0] = 1 - v;
      w[1] = v;
    } else {
      w[0] = -v * (v - 1) * (v - 2) / 6;
      w[1] = (v + 1) * (v - 1) * (v - 2) / 2;
      w[2] = -(v + 1) * v * (v - 2) / 2;
      w[3] = (v + 1) * v * (v - 1) / 6;
    }
  };
  const int p = std::min(static_cast<int>(splat.u), phases.column_phases - 1);
  const int q = std::min(static_cast<int>(splat.v), phases.row_phases - 1);
  float across[kWidth], down[kWidth];
  weights(splat.u - static_cast<float>(p), across);
  weights(splat.v - static_cast<float>(q), down);
  const std::int64_t plane = phases.stride * (phases.rows + 2 * kRowMargin);
  const auto wrap = [](int& at, int count) {
    int pixels = 0;
    for (; at < 0; at += count) ++pixels;
    for (; at >= count; at -= count) --pixels;
    return pixels;
  };
  constexpr int kFirst = kWidth == 4 ? -1 : 0;
  std::int64_t column[kWidth];
  for (int a = 0; a < kWidth; ++a) {
    int x = p + kFirst + a;
    const int pixels = wrap(x, phases.column_phases);
    column[a] = x * plane + pixels + kColumnMargin;
  }
  for (int b = 0; b < kWidth; ++b) {
    int y = q + kFirst + b;
    const int pixels = wrap(y, phases.row_phases);
    const float* row = phases.values.data() + static_cast<std::int64_t>(y) * phases.column_phases * plane +
                       (pixels + kRowMargin) * phases.stride;
    for (int a = 0; a < kWidth; ++a) {
      taps.plane[kWidth * b + a] = row + column[a];
      taps.weight[kWidth * b + a] = across[a] * down[b];
    }
  }
}

}  // namespace vol::render
