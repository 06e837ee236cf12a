#pragma once
#include <cstdint>

// Private to lib/fourier: what the SIMD kernel is handed, in plain numbers.
namespace vol::fourier {

inline constexpr int kMostTaps = 16;

struct SliceJob {
  const float* const* fields;  ///< element (0, 0, 0) of each spectrum
  int field_count;
  std::int64_t row, slab;  ///< strides in reals
  int taps, degree;
  const float* single;  ///< polynomials of the weights: kMostTaps a degree
  const float* pairs;   ///< the same with every tap twice
  double start[3], step[3];
  std::int64_t count;
  float* out;  ///< field by field, `count` complex numbers each
};

void slice_points(const SliceJob& job);

}  // namespace vol::fourier
