// Compiled once for every instruction set (Highway's foreach_target); the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fourier/slice_kernel.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // before highway.h
#include <hwy/highway.h>

#include <cmath>

#include "fourier/slice_job.h"

HWY_BEFORE_NAMESPACE();
namespace vol::fourier::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Values of `count` polynomials at s by Horner's rule, rows of coefficients 16 or 32 apart. Products and sums
// are rounded apart and every lane is for itself, so that all instruction sets give the same bits.
template <int kCount, int kRow>
HWY_ATTR HWY_INLINE void polynomials(const float* HWY_RESTRICT coefficients, int degree, float s,
                                     float* HWY_RESTRICT values) {
  const hn::CappedTag<float, (kCount <= 4 ? 4 : kCount <= 8 ? 8 : 16)> tag;
  const auto at = hn::Set(tag, s);
  for (std::size_t l = 0; l < kCount; l += hn::Lanes(tag)) {
    auto v = hn::Load(tag, coefficients + degree * kRow + l);
    for (int d = degree - 1; d >= 0; --d)
      v = hn::Add(hn::Mul(v, at), hn::Load(tag, coefficients + d * kRow + l));
    hn::Store(v, tag, values + l);
  }
}

// One row of taps is 2 kTaps neighbouring floats (re, im, re, im ...): they are added up over the rows as
// they stand, weighted by y and z, and only the sum is weighted by x and folded.
template <int kTaps>
HWY_ATTR void points(const SliceJob& job) {
  constexpr std::size_t kReals = 2 * kTaps <= 4 ? 4 : (2 * kTaps + 7) / 8 * 8;
  const hn::CappedTag<float, (kReals % 16 == 0 ? 16 : kReals % 8 == 0 ? 8 : 4)> tag;
  using V = hn::Vec<decltype(tag)>;
  constexpr std::size_t kLanes = hn::MaxLanes(tag);
  constexpr std::size_t kVectors = kReals / kLanes;
  // Points are done in blocks: positions and the lines of memory they need first, so that these are on their
  // way while the weights are made.
  constexpr int kBlock = 8;
  alignas(64) float wx[kBlock][2 * kMostTaps], wy[kBlock][kMostTaps], wz[kBlock][kMostTaps],
      folded[2 * kMostTaps];
  std::int64_t offset[kBlock];
  float s[kBlock][3], sign[kBlock];
  for (std::int64_t first = 0; first < job.count; first += kBlock) {
    const int block = static_cast<int>(job.count - first < kBlock ? job.count - first : kBlock);
    for (int p = 0; p < block; ++p) {
      const auto i = static_cast<double>(first + p);
      const double gx = job.start[0] + i * job.step[0];
      const double mirror = gx < 0 ? -1.0 : 1.0;
      const double from[3] = {mirror * gx - 0.5 * kTaps,
                              mirror * (job.start[1] + i * job.step[1]) - 0.5 * kTaps,
                              mirror * (job.start[2] + i * job.step[2]) - 0.5 * kTaps};
      const double below[3] = {std::floor(from[0]), std::floor(from[1]), std::floor(from[2])};
      for (int a = 0; a < 3; ++a) s[p][a] = static_cast<float>(2 * (from[a] - below[a]) - 1);
      offset[p] = 2 * (static_cast<std::int64_t>(below[0]) + 1) +
                  job.row * (static_cast<std::int64_t>(below[1]) + 1) +
                  job.slab * (static_cast<std::int64_t>(below[2]) + 1);
      sign[p] = static_cast<float>(mirror);
      if constexpr (kTaps <= 4) {  // of larger footprints neighbours share most
        for (int f = 0; f < job.field_count; ++f) {
          for (int c = 0; c < kTaps; ++c) {
            const float* row = job.fields[f] + offset[p] + c * job.slab;
            for (int b = 0; b < kTaps; ++b, row += job.row) hwy::Prefetch(row);
          }
        }
      }
    }
    for (int p = 0; p < block; ++p) {
      polynomials<2 * kTaps, 2 * kMostTaps>(job.pairs, job.degree, s[p][0], wx[p]);
      polynomials<kTaps, kMostTaps>(job.single, job.degree, s[p][1], wy[p]);
      polynomials<kTaps, kMostTaps>(job.single, job.degree, s[p][2], wz[p]);
    }
    for (int f = 0; f < job.field_count; ++f) {
      for (int p = 0; p < block; ++p) {
        const float* HWY_RESTRICT corner = job.fields[f] + offset[p];
        V sum[kVectors];
        for (std::size_t v = 0; v < kVectors; ++v) sum[v] = hn::Zero(tag);
        for (int c = 0; c < kTaps; ++c) {
          const float* HWY_RESTRICT row = corner + c * job.slab;
          for (int b = 0; b < kTaps; ++b, row += job.row) {
            const auto weight = hn::Set(tag, wy[p][b] * wz[p][c]);
            for (std::size_t v = 0; v < kVectors; ++v) {
              sum[v] = hn::Add(sum[v], hn::Mul(weight, hn::LoadU(tag, row + v * kLanes)));
            }
          }
        }
        for (std::size_t v = 0; v < kVectors; ++v) {
          hn::Store(hn::Mul(sum[v], hn::Load(tag, wx[p] + v * kLanes)), tag, folded + v * kLanes);
        }
        float re = folded[0], im = folded[1];
        for (int t = 1; t < kTaps; ++t) {
          re += folded[2 * t];
          im += folded[2 * t + 1];
        }
        float* out = job.out + 2 * (f * job.count + first + p);
        out[0] = re;
        out[1] = sign[p] * im;
      }
    }
  }
}

HWY_ATTR void slice_points_here(const SliceJob& job) {
  switch (job.taps) {
    case 1:
      return points<1>(job);
    case 2:
      return points<2>(job);
    case 3:
      return points<3>(job);
    case 4:
      return points<4>(job);
    case 5:
      return points<5>(job);
    case 6:
      return points<6>(job);
    case 7:
      return points<7>(job);
    case 8:
      return points<8>(job);
    case 9:
      return points<9>(job);
    case 10:
      return points<10>(job);
    case 11:
      return points<11>(job);
    case 12:
      return points<12>(job);
    case 13:
      return points<13>(job);
    case 14:
      return points<14>(job);
    case 15:
      return points<15>(job);
    default:
      return points<16>(job);
  }
}

}  // namespace vol::fourier::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::fourier {

HWY_EXPORT(slice_points_here);

void slice_points(const SliceJob& job) {
  HWY_DYNAMIC_DISPATCH(slice_points_here)(job);
}

}  // namespace vol::fourier
#endif
