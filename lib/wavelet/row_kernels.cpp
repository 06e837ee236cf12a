#include "wavelet/row_kernels.h"

// This file is compiled once for each instruction set (google/highway).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "wavelet/row_kernels.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vol::wavelet::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

[[maybe_unused]] constexpr int kAhead = 8;  // rows that are fetched before they are needed

/// kTaps > 0: number of taps known to the compiler. kVectors at a time hide the latency of the additions.
template <int kTaps, int kVectors, bool kHigh, class T>
HWY_INLINE std::int64_t combine_blocks(const T* const* HWY_RESTRICT rows, const T* HWY_RESTRICT a,
                                       const T* HWY_RESTRICT b, int taps, std::int64_t begin,
                                       std::int64_t count, T* HWY_RESTRICT low, T* HWY_RESTRICT high) {
  const hn::ScalableTag<T> d;
  using V = hn::Vec<decltype(d)>;
  [[maybe_unused]] const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  const int n = kTaps > 0 ? kTaps : taps;
  std::int64_t i = begin;
  for (; i + kVectors * lanes <= count; i += kVectors * lanes) {
    V sum_low[kVectors], sum_high[kVectors];
    {
      const V wa = hn::Set(d, a[0]), wb = hn::Set(d, kHigh ? b[0] : a[0]);
      for (int v = 0; v < kVectors; ++v) {
        const V x = hn::LoadU(d, rows[0] + i + v * lanes);
        sum_low[v] = hn::Mul(wa, x);
        if constexpr (kHigh) sum_high[v] = hn::Mul(wb, x);
      }
    }
    for (int r = 1; r < n; ++r) {
      const V wa = hn::Set(d, a[r]), wb = hn::Set(d, kHigh ? b[r] : a[r]);
      const T* HWY_RESTRICT row = rows[r] + i;
      if constexpr (kTaps ==
                    0) {  // long filters: planes far apart, in no order that the hardware could guess
        if (r + kAhead < n) {
          for (int v = 0; v < kVectors; ++v) hwy::Prefetch(rows[r + kAhead] + i + v * lanes);
        }
      }
      for (int v = 0; v < kVectors; ++v) {
        const V x = hn::LoadU(d, row + v * lanes);
        sum_low[v] = hn::Add(sum_low[v], hn::Mul(wa, x));
        if constexpr (kHigh) sum_high[v] = hn::Add(sum_high[v], hn::Mul(wb, x));
      }
    }
    for (int v = 0; v < kVectors; ++v) {
      hn::StoreU(sum_low[v], d, low + i + v * lanes);
      if constexpr (kHigh) hn::StoreU(sum_high[v], d, high + i + v * lanes);
    }
  }
  return i;
}

template <int kTaps, bool kHigh, class T>
HWY_INLINE void combine_taps(const T* const* rows, const T* a, const T* b, int taps, std::int64_t count,
                             T* low, T* high) {
  std::int64_t i = combine_blocks<kTaps, 4, kHigh>(rows, a, b, taps, 0, count, low, high);
  i = combine_blocks<kTaps, 1, kHigh>(rows, a, b, taps, i, count, low, high);
  for (; i < count; ++i) {
    T l = a[0] * rows[0][i], h = kHigh ? b[0] * rows[0][i] : T{0};
    for (int r = 1; r < taps; ++r) {
      l += a[r] * rows[r][i];
      if constexpr (kHigh) h += b[r] * rows[r][i];
    }
    low[i] = l;
    if constexpr (kHigh) high[i] = h;
  }
}

template <class T>
HWY_INLINE void combine_rows(const T* const* rows, const T* a, const T* b, int taps, std::int64_t count,
                             T* low, T* high) {
  if (high == nullptr) return combine_taps<0, false>(rows, a, b, taps, count, low, low);
  switch (taps) {
    case 2:
      return combine_taps<2, true>(rows, a, b, taps, count, low, high);
    case 4:
      return combine_taps<4, true>(rows, a, b, taps, count, low, high);
    case 6:
      return combine_taps<6, true>(rows, a, b, taps, count, low, high);
    default:
      return combine_taps<0, true>(rows, a, b, taps, count, low, high);
  }
}

template <class T>
HWY_INLINE void deinterleave_row(const T* HWY_RESTRICT x, std::int64_t count, T* HWY_RESTRICT even,
                                 T* HWY_RESTRICT odd) {
  const hn::ScalableTag<T> d;
  [[maybe_unused]] const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  std::int64_t i = 0;
#if HWY_TARGET != HWY_SCALAR
  for (; 2 * (i + lanes) <= count; i += lanes) {
    const auto lo = hn::LoadU(d, x + 2 * i);
    const auto hi = hn::LoadU(d, x + 2 * i + lanes);
    hn::StoreU(hn::ConcatEven(d, hi, lo), d, even + i);
    hn::StoreU(hn::ConcatOdd(d, hi, lo), d, odd + i);
  }
#endif
  for (; 2 * i + 1 < count; ++i) {
    even[i] = x[2 * i];
    odd[i] = x[2 * i + 1];
  }
  if (2 * i < count) even[i] = x[2 * i];
}

template <class T>
HWY_INLINE void interleave_row(const T* HWY_RESTRICT even, const T* HWY_RESTRICT odd, std::int64_t count,
                               T* HWY_RESTRICT x) {
  const hn::ScalableTag<T> d;
  [[maybe_unused]] const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  std::int64_t i = 0;
#if HWY_TARGET != HWY_SCALAR
  for (; i + lanes <= count; i += lanes) {
    hn::StoreInterleaved2(hn::LoadU(d, even + i), hn::LoadU(d, odd + i), d, x + 2 * i);
  }
#endif
  for (; i < count; ++i) {
    x[2 * i] = even[i];
    x[2 * i + 1] = odd[i];
  }
}

void combine_f32(const float* const* rows, const float* a, const float* b, int taps, std::int64_t count,
                 float* low, float* high) {
  combine_rows(rows, a, b, taps, count, low, high);
}
void combine_f64(const double* const* rows, const double* a, const double* b, int taps, std::int64_t count,
                 double* low, double* high) {
  combine_rows(rows, a, b, taps, count, low, high);
}
void deinterleave_f32(const float* x, std::int64_t n, float* even, float* odd) {
  deinterleave_row(x, n, even, odd);
}
void deinterleave_f64(const double* x, std::int64_t n, double* even, double* odd) {
  deinterleave_row(x, n, even, odd);
}
void interleave_f32(const float* even, const float* odd, std::int64_t n, float* x) {
  interleave_row(even, odd, n, x);
}
void interleave_f64(const double* even, const double* odd, std::int64_t n, double* x) {
  interleave_row(even, odd, n, x);
}

}  // namespace vol::wavelet::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::wavelet {

HWY_EXPORT(combine_f32);
HWY_EXPORT(combine_f64);
HWY_EXPORT(deinterleave_f32);
HWY_EXPORT(deinterleave_f64);
HWY_EXPORT(interleave_f32);
HWY_EXPORT(interleave_f64);

void combine(const float* const* rows, const float* a, const float* b, int taps, std::int64_t count,
             float* low, float* high) {
  HWY_DYNAMIC_DISPATCH(combine_f32)(rows, a, b, taps, count, low, high);
}
void combine(const double* const* rows, const double* a, const double* b, int taps, std::int64_t count,
             double* low, double* high) {
  HWY_DYNAMIC_DISPATCH(combine_f64)(rows, a, b, taps, count, low, high);
}
void deinterleave(const float* x, std::int64_t n, float* even, float* odd) {
  HWY_DYNAMIC_DISPATCH(deinterleave_f32)(x, n, even, odd);
}
void deinterleave(const double* x, std::int64_t n, double* even, double* odd) {
  HWY_DYNAMIC_DISPATCH(deinterleave_f64)(x, n, even, odd);
}
void interleave(const float* even, const float* odd, std::int64_t n, float* x) {
  HWY_DYNAMIC_DISPATCH(interleave_f32)(even, odd, n, x);
}
void interleave(const double* even, const double* odd, std::int64_t n, double* x) {
  HWY_DYNAMIC_DISPATCH(interleave_f64)(even, odd, n, x);
}

}  // namespace vol::wavelet
#endif
