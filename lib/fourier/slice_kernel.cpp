// Compiled once for every instruction set (Highway's foreach_target); the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fourier/slice_kernel.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // before highway.h
#include <hwy/highway.h>

#include <utility>

#include "fourier/slice_job.h"

HWY_BEFORE_NAMESPACE();
namespace vol::fourier::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Products and sums are rounded apart, and everything is added up in an order that does not depend on the
// number of lanes: all instruction sets give the same bits.

constexpr std::int64_t kBlock = 16;  // points done together; their footprints are on their way meanwhile
constexpr int kFewTaps = 4;          // up to which a row of taps is one vector of 4 or 8 reals
constexpr bool kVectorFold = HWY_TARGET != HWY_SCALAR;

/// A block's points: where their footprints begin and how far they lie from there.
struct Block {
  HWY_ALIGN float s[3][kBlock], sign[kBlock];
  HWY_ALIGN double offset[kBlock];  // in reals; whole
};

/// Of large footprints neighbours share most, so only small ones are fetched in advance.
template <int kTaps>
HWY_ATTR HWY_INLINE void fetch(const SliceJob& job, const Block& block, std::int64_t count) {
  if constexpr (kTaps <= kFewTaps) {
    for (int f = 0; f < job.field_count; ++f) {
      for (std::int64_t p = 0; p < count; ++p) {
        const float* slab = job.fields[f] + static_cast<std::int64_t>(block.offset[p]);
        for (int c = 0; c < kTaps; ++c, slab += job.slab) {
          const float* row = slab;
          for (int b = 0; b < kTaps; ++b, row += job.row) hwy::Prefetch(row);
        }
      }
    }
  }
}

/// Positions of the points first ... first + kBlock - 1, lanes being points.
template <int kTaps>
HWY_ATTR HWY_INLINE void place(const SliceJob& job, std::int64_t first, Block& block) {
  const hn::CappedTag<double, 8> tag;
  const hn::Rebind<float, decltype(tag)> narrow;
  const auto one = hn::Set(tag, 1.0), half = hn::Set(tag, 0.5 * kTaps);
  const double strides[3] = {2, static_cast<double>(job.row), static_cast<double>(job.slab)};
  for (std::int64_t l = 0; l < kBlock; l += static_cast<std::int64_t>(hn::Lanes(tag))) {
    const auto i = hn::Iota(tag, static_cast<double>(first + l));
    const auto gx = hn::Add(hn::Set(tag, job.start[0]), hn::Mul(i, hn::Set(tag, job.step[0])));
    const auto mirror = hn::IfThenElse(hn::Lt(gx, hn::Zero(tag)), hn::Neg(one), one);
    auto offset = hn::Zero(tag);
    for (int a = 0; a < 3; ++a) {
      const auto g = hn::Add(hn::Set(tag, job.start[a]), hn::Mul(i, hn::Set(tag, job.step[a])));
      const auto from = hn::Sub(hn::Mul(mirror, g), half);
      const auto below = hn::Floor(from);
      const auto within = hn::Sub(from, below);
      hn::Store(hn::DemoteTo(narrow, hn::Sub(hn::Add(within, within), one)), narrow, block.s[a] + l);
      offset = hn::Add(offset, hn::Mul(hn::Set(tag, strides[a]), hn::Add(below, one)));  // whole: exact
    }
    hn::Store(offset, tag, block.offset + l);
    hn::Store(hn::DemoteTo(narrow, mirror), narrow, block.sign + l);
  }
}

/// The polynomials of all taps at kBlock places by Horner's rule, lanes being points: weight(t, l, values).
template <int kTaps, class Tag, class Weight>
HWY_ATTR HWY_INLINE void weigh(Tag tag, const SliceJob& job, const float* HWY_RESTRICT s,
                               const Weight& weight) {
  for (std::int64_t l = 0; l < kBlock; l += static_cast<std::int64_t>(hn::Lanes(tag))) {
    const auto at = hn::Load(tag, s + l);
    for (int t = 0; t < kTaps; ++t) {
      auto v = hn::Set(tag, job.single[job.degree * kMostTaps + t]);
      for (int d = job.degree - 1; d >= 0; --d)
        v = hn::Add(hn::Mul(v, at), hn::Set(tag, job.single[d * kMostTaps + t]));
      weight(t, l, v);
    }
  }
}

/// The same at one place, every tap twice, lanes being taps.
template <int kCount>
HWY_ATTR HWY_INLINE void weigh_pairs(const SliceJob& job, float s, float* HWY_RESTRICT values) {
  const hn::CappedTag<float, (kCount <= 4 ? 4 : kCount <= 8 ? 8 : 16)> tag;
  const auto at = hn::Set(tag, s);
  for (std::size_t l = 0; l < kCount; l += hn::Lanes(tag)) {
    auto v = hn::Load(tag, job.pairs + job.degree * 2 * kMostTaps + l);
    for (int d = job.degree - 1; d >= 0; --d)
      v = hn::Add(hn::Mul(v, at), hn::Load(tag, job.pairs + d * 2 * kMostTaps + l));
    hn::Store(v, tag, values + l);
  }
}

#if HWY_TARGET == HWY_SCALAR
struct FewWeights {};
#else
/// The x weights of few taps, as fold_few() reads them: taps 0 and 1 of all points, then 2 and 3; twice each,
/// for real and imaginary part, the second with the sign of a mirrored point.
struct FewWeights {
  HWY_ALIGN float pairs[2][4 * kBlock];
};

template <int kTaps>
HWY_ATTR HWY_INLINE void weigh_few(const SliceJob& job, const Block& block, FewWeights& few) {
  const hn::CappedTag<float, kBlock> tag;
  HWY_ALIGN float w[kFewTaps][kBlock] = {};  // 0 for taps that are none
  weigh<kTaps>(tag, job, block.s[0],
               [&](int t, std::int64_t l, auto v) HWY_ATTR { hn::Store(v, tag, w[t] + l); });
  for (int half = 0; half < (kTaps + 1) / 2; ++half) {
    for (std::int64_t l = 0; l < kBlock; l += static_cast<std::int64_t>(hn::Lanes(tag))) {
      const auto even = hn::Load(tag, w[2 * half] + l), odd = hn::Load(tag, w[2 * half + 1] + l);
      const auto sign = hn::Load(tag, block.sign + l);
      hn::StoreInterleaved4(even, hn::Mul(even, sign), odd, hn::Mul(odd, sign), tag, few.pairs[half] + 4 * l);
    }
  }
}

/// Point p of a row sum of 4 or 8 reals: (tap 0 + tap 2) + (tap 1 + tap 3).
template <class V, std::size_t kVectors>
HWY_ATTR HWY_INLINE void fold_few(const V (&sum)[kVectors], const FewWeights& few, std::int64_t p,
                                  float* HWY_RESTRICT out) {
  const hn::FixedTag<float, 4> four;
  const hn::FixedTag<float, 2> two;
  const auto low = hn::Load(four, few.pairs[0] + 4 * p);
  auto x = hn::Zero(four);
  if constexpr (kVectors == 2) {
    x = hn::Add(hn::Mul(sum[0], low), hn::Mul(sum[1], hn::Load(four, few.pairs[1] + 4 * p)));
  } else if constexpr (hn::MaxLanes(hn::DFromV<V>()) == 8) {
    x = hn::Add(hn::Mul(hn::LowerHalf(four, sum[0]), low),
                hn::Mul(hn::UpperHalf(four, sum[0]), hn::Load(four, few.pairs[1] + 4 * p)));
  } else {
    x = hn::Mul(sum[0], low);
  }
  hn::Store(hn::LowerHalf(two, hn::Add(x, hn::Shuffle1032(x))), two, out + 2 * p);
}

#endif

// One row of taps is 2 kTaps neighbouring floats (re, im, re, im ...): they are added up over the rows as
// they stand, weighted by y and z, and only the sum is weighted by x and folded.
template <int kTaps>
HWY_ATTR void points(const SliceJob& job) {
  constexpr std::size_t kReals = 2 * kTaps <= 4 ? 4 : (2 * kTaps + 7) / 8 * 8;
  const hn::CappedTag<float, (kReals % 16 == 0 ? 16 : kReals % 8 == 0 ? 8 : 4)> tag;
  const hn::CappedTag<float, kBlock> across;
  using V = hn::Vec<decltype(tag)>;
  constexpr std::size_t kLanes = hn::MaxLanes(tag);
  constexpr std::size_t kVectors = kReals / kLanes;
  HWY_ALIGN float wx[kBlock][2 * kMostTaps], wyz[kTaps * kTaps][kBlock], wy[kTaps][kBlock],
      folded[2 * kMostTaps];
  FewWeights few;
  Block blocks[2];
  Block *now = &blocks[0], *next = &blocks[1];
  const auto in_block = [&](std::int64_t first) {
    return job.count - first < kBlock ? job.count - first : kBlock;
  };
  place<kTaps>(job, 0, *now);
  fetch<kTaps>(job, *now, in_block(0));
  for (std::int64_t first = 0; first < job.count; first += kBlock, std::swap(now, next)) {
    const std::int64_t count = in_block(first);
    if (first + kBlock < job.count) {
      place<kTaps>(job, first + kBlock, *next);
      fetch<kTaps>(job, *next, in_block(first + kBlock));
    }
    weigh<kTaps>(across, job, now->s[1],
                 [&](int t, std::int64_t l, auto v) HWY_ATTR { hn::Store(v, across, wy[t] + l); });
    weigh<kTaps>(across, job, now->s[2], [&](int t, std::int64_t l, auto v) HWY_ATTR {
      for (int b = 0; b < kTaps; ++b)
        hn::Store(hn::Mul(hn::Load(across, wy[b] + l), v), across, wyz[t * kTaps + b] + l);
    });
    if constexpr (kVectorFold && kTaps <= kFewTaps) {
      weigh_few<kTaps>(job, *now, few);
    } else {
      for (std::int64_t p = 0; p < count; ++p) weigh_pairs<2 * kTaps>(job, now->s[0][p], wx[p]);
    }
    for (int f = 0; f < job.field_count; ++f) {
      float* HWY_RESTRICT out = job.out + 2 * (f * job.count + first);
      for (std::int64_t p = 0; p < count; ++p) {
        const float* HWY_RESTRICT slab = job.fields[f] + static_cast<std::int64_t>(now->offset[p]);
        V sum[kVectors];
        for (std::size_t v = 0; v < kVectors; ++v) sum[v] = hn::Zero(tag);
        for (int c = 0; c < kTaps; ++c, slab += job.slab) {
          const float* HWY_RESTRICT row = slab;
          for (int b = 0; b < kTaps; ++b, row += job.row) {
            const auto weight = hn::Set(tag, wyz[c * kTaps + b][p]);
            for (std::size_t v = 0; v < kVectors; ++v) {
              sum[v] = hn::Add(sum[v], hn::Mul(weight, hn::LoadU(tag, row + v * kLanes)));
            }
          }
        }
        if constexpr (kVectorFold && kTaps <= kFewTaps) {
          fold_few(sum, few, p, out);
        } else {
          for (std::size_t v = 0; v < kVectors; ++v) {
            hn::Store(hn::Mul(sum[v], hn::Load(tag, wx[p] + v * kLanes)), tag, folded + v * kLanes);
          }
          float re = folded[0], im = folded[1];
          if constexpr (kTaps == 3 || kTaps == 4) {  // as fold_few()
            re = (re + folded[4]) + (kTaps == 3 ? folded[2] : folded[2] + folded[6]);
            im = (im + folded[5]) + (kTaps == 3 ? folded[3] : folded[3] + folded[7]);
          } else {
            for (int t = 1; t < kTaps; ++t) {
              re += folded[2 * t];
              im += folded[2 * t + 1];
            }
          }
          out[2 * p] = re;
          out[2 * p + 1] = now->sign[p] * im;
        }
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
