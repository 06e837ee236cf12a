// Included once per instruction set by the kernels.
#if defined(VOL_RENDER_PACKET_PATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_PATH_INL_H_
#undef VOL_RENDER_PACKET_PATH_INL_H_
#else
#define VOL_RENDER_PACKET_PATH_INL_H_
#endif

#include "render/packet_sampling-inl.h"

// What the composite casters share: leaving empty space, the depth channel, writing pixels.

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// How far rays may go inside a cube of invisible macrocells.
class Leaps {
 public:
  HWY_INLINE void prepare(const Position& step) {
    const I wholes[] = {step.whole0, step.whole1, step.whole2};
    const I parts[] = {step.part0, step.part1, step.part2};
    for (int a = 0; a < 3; ++a) {
      const F along = hn::Add(to_float(wholes[a]), fraction(parts[a]));
      const M up = hn::Gt(along, constant(0.0F));
      forward_[a] = hn::IfThenElse(up, constant(-1.0F), constant(1.0F));
      origin_[a] = hn::IfThenElse(up, constant(0.0F), constant(-float(kEdge)));
      steps_a_voxel_[a] = hn::Div(constant(1.0F), hn::Max(hn::Abs(along), constant(1e-20F)));
    }
  }

  /// Nodes from a position on, its own included, that surely lie in the macrocells less than `distance` away
  /// (at least 1).
  HWY_INLINE I nodes_inside(const Position& p, I distance) const {
    const F reach = to_float(hn::ShiftLeft<kEdgeLog2>(distance));
    const F nodes = hn::Min(axis(0, p.whole0, p.part0, reach),
                            hn::Min(axis(1, p.whole1, p.part1, reach), axis(2, p.whole2, p.part2, reach)));
    return hn::Add(truncated(hn::Min(hn::Max(nodes, constant(0.0F)), constant(30000.0F))), constant_i(1));
  }

 private:
  static constexpr std::int32_t kEdge = ::vol::index::Macrocells::kEdge;
  static constexpr int kEdgeLog2 = ::vol::index::Macrocells::kEdgeLog2;

  HWY_INLINE F axis(int a, I whole, I part, F reach) const {
    const F at = hn::Add(to_float(hn::And(whole, constant_i(kEdge - 1))), fraction(part));
    const F room = hn::MulAdd(forward_[a], at, hn::Add(reach, origin_[a]));
    // Margin for the rounding of all this: 1e-4 voxel and 1e-6 of the way.
    return hn::Mul(hn::MulSub(room, constant(1 - 1e-6F), constant(1e-4F)), steps_a_voxel_[a]);
  }

  F forward_[3], origin_[3], steps_a_voxel_[3];
};

/// Where transmittance falls to 1/2: a node, and steps behind it.
class Halfway {
 public:
  HWY_INLINE void begin(MI alive) {
    node_ = constant_i(-1);
    part_ = hn::Zero(DF());
    done_ = hn::Not(float_mask(alive));
  }

  /// A segment of `length` steps, `offset` steps behind node `opened_by`, `depth` its log2 of transmittance.
  HWY_INLINE void pass(I opened_by, F offset, F before, F behind, F depth, F length) {
    const M here = hn::AndNot(done_, hn::Le(behind, constant(0.5F)));
    if (HWY_UNLIKELY(!hn::AllFalse(DF(), here))) mark(here, opened_by, offset, before, depth, length);
  }

  HWY_INLINE void store(PacketPixels& pixels) const {
    hn::Store(node_, DI(), pixels.depth_node);
    hn::Store(part_, DF(), pixels.depth_part);
  }

 private:
  /// log2 T = -1 at a share (log2 T_before + 1) / -depth of the segment.
  HWY_NOINLINE void mark(M here, I opened_by, F offset, F before, F depth, F length) {
    const F share =
        hn::Div(hn::Add(log2_positive(before), constant(1.0F)), hn::Min(depth, constant(-1e-30F)));
    const F inside = hn::Min(hn::Max(hn::Neg(share), constant(0.0F)), constant(1.0F));
    node_ = hn::IfThenElse(int_mask(here), opened_by, node_);
    part_ = hn::IfThenElse(here, hn::MulAdd(inside, length, offset), part_);
    done_ = hn::Or(done_, here);
  }

  I node_;
  F part_;
  M done_;
};

/// Colour from a ray's sums (one channel: of y u, colour being one line in u) and alpha.
template <int kChannels>
HWY_INLINE void store_colour(const PacketTransfer& t, const F* sum, F transmittance, PacketPixels& pixels) {
  const F alpha = hn::Sub(constant(1.0F), transmittance);
  for (int c = 0; c < 3; ++c) {
    const F colour = kChannels == 1
                         ? hn::MulAdd(constant(t.colour1[c]), sum[0], hn::Mul(constant(t.colour0[c]), alpha))
                         : sum[kChannels == 1 ? 0 : c];
    hn::Store(colour, DF(), pixels.colour[c]);
  }
  hn::Store(alpha, DF(), pixels.alpha);
}

HWY_INLINE void store_counts(I samples, I skipped, I gradients, MI stopped, PacketPixels& pixels) {
  const DI d;
  hn::Store(samples, d, pixels.samples);
  hn::Store(skipped, d, pixels.skipped);
  hn::Store(gradients, d, pixels.gradients);
  hn::Store(hn::IfThenElseZero(stopped, constant_i(1)), d, pixels.terminated);
}

/// Length, in steps, from a node to the ray's end.
HWY_INLINE F length_ahead(I node, I segments, F remainder) {
  return hn::Add(to_float(hn::Sub(hn::Sub(segments, constant_i(1)), node)), remainder);
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
