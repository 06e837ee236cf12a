// Included once per instruction set by the kernels.
#if defined(VOL_RENDER_PACKET_SAMPLING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_SAMPLING_INL_H_
#undef VOL_RENDER_PACKET_SAMPLING_INL_H_
#else
#define VOL_RENDER_PACKET_SAMPLING_INL_H_
#endif

#include "render/packet_job.h"
#include "render/packet_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// Fixed-point vector per axis: whole + part 2^-31, 0 <= part < 2^31. Sums are exact, so a node's position
/// does not depend on the hops by which it was reached.
struct Position {
  I whole0, whole1, whole2, part0, part1, part2;
};

HWY_INLINE Position load(const std::int32_t (&whole)[3][kMaxLanes],
                         const std::int32_t (&part)[3][kMaxLanes]) {
  const DI d;
  return {hn::Load(d, whole[0]), hn::Load(d, whole[1]), hn::Load(d, whole[2]),
          hn::Load(d, part[0]),  hn::Load(d, part[1]),  hn::Load(d, part[2])};
}

HWY_INLINE I carry_of(I part) {
  return hn::BitCast(DI(), hn::ShiftRight<31>(hn::BitCast(hn::RebindToUnsigned<DI>(), part)));
}

HWY_INLINE void add_axis(I& whole, I& part, I step_whole, I step_part) {
  const I sum = hn::Add(part, step_part);
  whole = hn::Add(hn::Add(whole, step_whole), carry_of(sum));
  part = hn::And(sum, constant_i(0x7fffffff));
}
HWY_INLINE void advance(Position& p, const Position& step) {
  add_axis(p.whole0, p.part0, step.whole0, step.part0);
  add_axis(p.whole1, p.part1, step.whole1, step.part1);
  add_axis(p.whole2, p.part2, step.whole2, step.part2);
}

HWY_INLINE void subtract_axis(I& whole, I& part, I step_whole, I step_part) {
  const I difference = hn::Sub(part, step_part);
  whole = hn::Sub(hn::Sub(whole, step_whole), carry_of(difference));
  part = hn::And(difference, constant_i(0x7fffffff));
}
HWY_INLINE void retreat(Position& p, const Position& step) {
  subtract_axis(p.whole0, p.part0, step.whole0, step.part0);
  subtract_axis(p.whole1, p.part1, step.whole1, step.part1);
  subtract_axis(p.whole2, p.part2, step.whole2, step.part2);
}

/// step times a count in [0, 32767], by 16-bit digits.
HWY_INLINE void scale_axis(I& whole, I& part, I count) {
  const I low = hn::Mul(count, hn::And(part, constant_i(0xffff)));
  const I high = hn::Add(hn::Mul(count, hn::ShiftRight<16>(part)), hn::ShiftRight<16>(low));
  part = hn::Or(hn::ShiftLeft<16>(hn::And(high, constant_i(0x7fff))), hn::And(low, constant_i(0xffff)));
  whole = hn::Add(hn::Mul(count, whole), hn::ShiftRight<15>(high));
}
HWY_INLINE Position scaled(Position step, I count) {
  scale_axis(step.whole0, step.part0, count);
  scale_axis(step.whole1, step.part1, count);
  scale_axis(step.whole2, step.part2, count);
  return step;
}

HWY_INLINE Position masked(const Position& p, MI m) {
  return {hn::IfThenElseZero(m, p.whole0), hn::IfThenElseZero(m, p.whole1), hn::IfThenElseZero(m, p.whole2),
          hn::IfThenElseZero(m, p.part0),  hn::IfThenElseZero(m, p.part1),  hn::IfThenElseZero(m, p.part2)};
}
HWY_INLINE Position selected(MI m, const Position& a, const Position& b) {
  return {hn::IfThenElse(m, a.whole0, b.whole0), hn::IfThenElse(m, a.whole1, b.whole1),
          hn::IfThenElse(m, a.whole2, b.whole2), hn::IfThenElse(m, a.part0, b.part0),
          hn::IfThenElse(m, a.part1, b.part1),   hn::IfThenElse(m, a.part2, b.part2)};
}

HWY_INLINE F fraction(I part) {
  return hn::Mul(to_float(part), constant(0x1p-31F));
}

/// The eight samples around a position as floats; reads at most 3 bytes behind the last sample, which Buffer
/// keeps readable.
struct Corners {
  F v000, v100, v010, v110, v001, v101, v011, v111;
};

template <PacketVoxels kVoxels>
struct Gather {
  static HWY_INLINE const std::int32_t* at(const PacketJob& job, std::int64_t offset) {
    constexpr int kBytes = kVoxels == PacketVoxels::f32 ? 4 : 1;
    return reinterpret_cast<const std::int32_t*>(static_cast<const char*>(job.voxels) + offset * kBytes);
  }
  /// Neighbours along x, from the word that holds both.
  static HWY_INLINE void pair(const PacketJob& job, std::int64_t row, I offset, F& v0, F& v1) {
    const DI d;
    if constexpr (kVoxels == PacketVoxels::f32) {
      const auto* base = reinterpret_cast<const float*>(at(job, row));
      v0 = hn::GatherIndex(DF(), base, offset);
      v1 = hn::GatherIndex(DF(), base + job.neighbour[0], offset);
    } else {
      const I word = hn::GatherOffset(d, at(job, row), offset);
      if constexpr (kVoxels == PacketVoxels::u8) {
        v0 = to_float(hn::And(word, constant_i(0xff)));
        v1 = to_float(hn::And(hn::ShiftRight<8>(word), constant_i(0xff)));
      } else if (job.is_signed) {
        v0 = to_float(hn::ShiftRight<16>(hn::ShiftLeft<16>(word)));
        v1 = to_float(hn::ShiftRight<16>(word));
      } else {
        v0 = to_float(hn::And(word, constant_i(0xffff)));
        v1 = to_float(hn::And(hn::ShiftRight<16>(word), constant_i(0xffff)));
      }
    }
  }
  static HWY_INLINE F single(const PacketJob& job, I offset) {
    if constexpr (kVoxels == PacketVoxels::f32) {
      return hn::GatherIndex(DF(), static_cast<const float*>(job.voxels), offset);
    } else {
      F v0, v1;
      pair(job, 0, offset, v0, v1);
      return v0;
    }
  }
};

/// Of voxels in blocks (voxel_blocks.h).
template <PacketVoxels kVoxels>
HWY_INLINE I block_offset(const PacketJob& job, I i, I j, I k) {
  constexpr int kLog2 = BlockStrides::kEdgeLog2;
  constexpr int kBytesLog2 = kVoxels == PacketVoxels::u8 ? 0 : kVoxels == PacketVoxels::two_bytes ? 1 : 2;
  constexpr int kWidthLog2 = BlockStrides::kRowBytesLog2 - kBytesLog2;
  const BlockStrides& b = job.blocks;
  const I along = kVoxels == PacketVoxels::two_bytes ? hn::Add(i, i) : i;
  const I row = hn::Mul(hn::Add(j, hn::ShiftLeft<kLog2>(k)), constant_i(b.pitch));
  const I x = hn::Mul(hn::ShiftRight<kWidthLog2>(i), constant_i(b.beyond[0]));
  const I y = hn::Mul(hn::ShiftRight<kLog2>(j), constant_i(b.beyond[1]));
  const I z = hn::Mul(hn::ShiftRight<kLog2>(k), constant_i(b.beyond[2]));
  return hn::Add(hn::Add(along, row), hn::Add(x, hn::Add(y, z)));
}

/// From a voxel in row or slice `at` of a block to the next one along that axis, `inside` it.
HWY_INLINE I block_hop(I at, std::int32_t inside, std::int32_t beyond) {
  const I last = constant_i((1 << BlockStrides::kEdgeLog2) - 1);
  return hn::Add(constant_i(inside), hn::IfThenElseZero(hn::Eq(hn::And(at, last), last), constant_i(beyond)));
}

HWY_INLINE I voxel_offset(const PacketJob& job, I i, I j, I k, bool two_bytes) {
  const I row = hn::Add(hn::Mul(j, constant_i(job.stride[1])), hn::Mul(k, constant_i(job.stride[2])));
  return hn::Add(row, two_bytes ? hn::Add(i, i) : i);
}

/// One reconstruction of the field, and the corners for its gradient.
template <PacketVoxels kVoxels>
struct Sampler {
  static constexpr bool kTwoBytes = kVoxels == PacketVoxels::two_bytes;
  F x, y, z;
  Corners c;

  HWY_INLINE F value(const PacketJob& job, const Position& p) {
    x = fraction(p.part0);
    y = fraction(p.part1);
    z = fraction(p.part2);
    if (HWY_UNLIKELY(job.nearest)) return nearest(job, p);
    load_corners(job, p);
    const F a = hn::MulAdd(x, hn::Sub(c.v100, c.v000), c.v000);
    const F b = hn::MulAdd(x, hn::Sub(c.v110, c.v010), c.v010);
    const F d = hn::MulAdd(x, hn::Sub(c.v101, c.v001), c.v001);
    const F e = hn::MulAdd(x, hn::Sub(c.v111, c.v011), c.v011);
    const F front = hn::MulAdd(y, hn::Sub(b, a), a);
    const F back = hn::MulAdd(y, hn::Sub(e, d), d);
    return hn::MulAdd(z, hn::Sub(back, front), front);
  }

  HWY_INLINE void load_corners(const PacketJob& job, const Position& p) {
    using G = Gather<kVoxels>;
    if (job.in_blocks) {
      const BlockStrides& b = job.blocks;
      const I at = block_offset<kVoxels>(job, p.whole0, p.whole1, p.whole2);
      const I up = hn::Add(at, block_hop(p.whole1, b.pitch, b.beyond[1]));
      const I in = block_hop(p.whole2, b.pitch << BlockStrides::kEdgeLog2, b.beyond[2]);
      G::pair(job, 0, at, c.v000, c.v100);
      G::pair(job, 0, up, c.v010, c.v110);
      G::pair(job, 0, hn::Add(at, in), c.v001, c.v101);
      G::pair(job, 0, hn::Add(up, in), c.v011, c.v111);
      return;
    }
    const I offset = voxel_offset(job, p.whole0, p.whole1, p.whole2, kTwoBytes);
    const std::int64_t dy = job.neighbour[1], dz = job.neighbour[2];
    G::pair(job, 0, offset, c.v000, c.v100);
    G::pair(job, dy, offset, c.v010, c.v110);
    G::pair(job, dz, offset, c.v001, c.v101);
    G::pair(job, dy + dz, offset, c.v011, c.v111);
  }

  /// The nearest sample, the upper of two equally near.
  HWY_INLINE F nearest(const PacketJob& job, const Position& p) {
    c.v000 = c.v100 = c.v010 = c.v110 = c.v001 = c.v101 = c.v011 = c.v111 = constant(0.0F);  // no gradient
    const auto rounded = [](I whole, I part) HWY_ATTR { return hn::Add(whole, hn::ShiftRight<30>(part)); };
    const I i = rounded(p.whole0, p.part0), j = rounded(p.whole1, p.part1), k = rounded(p.whole2, p.part2);
    return Gather<kVoxels>::single(
        job, job.in_blocks ? block_offset<kVoxels>(job, i, j, k) : voxel_offset(job, i, j, k, kTwoBytes));
  }

  /// Gradient of the trilinear field along the index axes, per sample; along an axis of one sample 0, because
  /// its two corners are the same voxel (x: the fraction is 0 there, and `to_world` has a zero column).
  HWY_INLINE void gradient(F& gx, F& gy, F& gz) const {
    const auto mix = [](F t, F a, F b) HWY_ATTR { return hn::MulAdd(t, hn::Sub(b, a), a); };
    gx = mix(z, mix(y, hn::Sub(c.v100, c.v000), hn::Sub(c.v110, c.v010)),
             mix(y, hn::Sub(c.v101, c.v001), hn::Sub(c.v111, c.v011)));
    const F front0 = mix(x, c.v000, c.v100), front1 = mix(x, c.v010, c.v110);
    const F back0 = mix(x, c.v001, c.v101), back1 = mix(x, c.v011, c.v111);
    gy = mix(z, hn::Sub(front1, front0), hn::Sub(back1, back0));
    gz = hn::Sub(mix(y, back0, back1), mix(y, front0, front1));
  }
};

/// L of the index entry that governs a position.
HWY_INLINE I index_level(const PacketJob& job, const Position& p) {
  const DI d;
  const auto entry = [&](I whole) HWY_ATTR {
    if (job.reduction == 1) return whole;
    // Half a cell keeps the quotient off the integers, beyond what float rounding could move.
    return truncated(hn::Mul(hn::Add(to_float(whole), constant(0.5F)), constant(job.inverse_reduction)));
  };
  const I i = entry(p.whole0), j = entry(p.whole1), k = entry(p.whole2);
  const I offset = hn::Add(hn::ShiftRight<1>(i), hn::Add(hn::Mul(j, constant_i(job.row_bytes)),
                                                         hn::Mul(k, constant_i(job.slice_bytes))));
  const I word = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(job.nibbles), offset);
  const MI odd = hn::Ne(hn::And(i, constant_i(1)), hn::Zero(d));
  return hn::And(hn::IfThenElse(odd, hn::ShiftRight<4>(word), word), constant_i(15));
}

/// The distance to what is visible, of the macrocell at a position.
HWY_INLINE I visible_distance(const PacketJob& job, const std::uint8_t* distances, const Position& p) {
  const DI d;
  constexpr int kEdgeLog2 = ::vol::index::Macrocells::kEdgeLog2;
  const I offset =
      hn::Add(hn::ShiftRight<kEdgeLog2>(p.whole0),
              hn::Add(hn::Mul(hn::ShiftRight<kEdgeLog2>(p.whole1), constant_i(job.macro_stride[1])),
                      hn::Mul(hn::ShiftRight<kEdgeLog2>(p.whole2), constant_i(job.macro_stride[2]))));
  const I word = hn::GatherOffset(d, reinterpret_cast<const std::int32_t*>(distances), offset);
  return hn::And(word, constant_i(0xff));
}

/// 2^level for level in [0, 15].
HWY_INLINE I power_of_two(I level) {
  return hn::Shl(constant_i(1), level);
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
