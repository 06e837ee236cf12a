#pragma once
#include <algorithm>
#include <cmath>

#include "render/footprint_kernel.h"

namespace vol::render {

/// The planes that a term at a place between pixels is interpolated from.
struct FootprintTaps {
  const float* plane[16];
  float weight[16];
};

/// Planes and weights of a place: with v in [0, 1] the rest of u or v behind a plane, the weights along one
/// direction are those of the polynomial of Lagrange through the planes at 0, 1 (kTaps = 4: 1 - v, v) or
/// -1, 0, 1, 2 (kTaps = 16): w_n(v) = prod_(m != n) (v - m) / (n - m). Those of both directions are
/// multiplied.
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
  const std::int64_t plane = phases.plane();
  // The first one lies before() of the place, and planes begin before() of place 0.
  const float* first = phases.values.data() + (static_cast<std::int64_t>(q) * phases.across() + p) * plane;
  for (int b = 0; b < kWidth; ++b) {
    for (int a = 0; a < kWidth; ++a) {
      taps.plane[kWidth * b + a] = first + (static_cast<std::int64_t>(b) * phases.across() + a) * plane;
      taps.weight[kWidth * b + a] = across[a] * down[b];
    }
  }
}

}  // namespace vol::render
