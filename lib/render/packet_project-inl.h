// Included once per instruction set by packet_kernel.cpp.
#if defined(VOL_RENDER_PACKET_PROJECT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_PROJECT_INL_H_
#undef VOL_RENDER_PACKET_PROJECT_INL_H_
#else
#define VOL_RENDER_PACKET_PROJECT_INL_H_
#endif

#include "render/packet_sampling-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// The nodes of a packet's rays for xray and mip, in order: calls node(value, number, length ahead, active),
/// where the length ahead, in steps, reaches to the next node and is 0 for the last one and for lanes that
/// have ended.
template <PacketVoxels kVoxels, bool kWithLast, class Visit>
HWY_INLINE I walk(const PacketJob& job, const PacketRays& rays, const Visit& visit) {
  const DI d;
  const I segments = hn::Load(d, rays.segments);
  const F remainder = hn::Load(DF(), rays.remainder);
  const Position step = load(rays.step_whole, rays.step_part);
  Position position = load(rays.entry_whole, rays.entry_part);
  I node = hn::Zero(d), samples = hn::Zero(d);
  Sampler<kVoxels> sampler;
  for (;;) {
    const MI active = hn::Lt(node, segments);
    if (hn::AllFalse(d, active)) break;
    I hop = constant_i(1);
    if (job.nibbles) {
      const I first = hn::Load(d, rays.first_level);
      hop = power_of_two(hn::IfThenElse(hn::Eq(node, hn::Zero(d)), first, index_level(job, position)));
    }
    const F ahead = hn::Add(to_float(hn::Sub(hn::Sub(segments, constant_i(1)), node)), remainder);
    const F length = hn::IfThenElseZero(float_mask(active), hn::Min(to_float(hop), ahead));
    visit(sampler.value(job, position), node, length, active);
    samples = hn::Add(samples, hn::IfThenElseZero(active, constant_i(1)));
    const I next = hn::Min(hn::Add(node, hop), segments);
    // Lanes that reach the end stay: the last node has a place of its own.
    const MI moves = hn::And(active, hn::Lt(next, segments));
    if (job.nibbles) {
      advance(position, scaled(step, hn::IfThenElseZero(moves, hop)));
    } else {
      advance(position, masked(step, moves));
    }
    node = hn::IfThenElse(active, next, node);
  }
  if (kWithLast) {
    const MI active = hn::Gt(segments, hn::Zero(d));
    visit(sampler.value(job, load(rays.exit_whole, rays.exit_part)), segments, hn::Zero(DF()), active);
    samples = hn::Add(samples, hn::IfThenElseZero(active, constant_i(1)));
  }
  return samples;
}

HWY_INLINE void store_projection(F value, I depth_node, I samples, PacketPixels& pixels) {
  const DF df;
  const DI d;
  for (int c = 0; c < 3; ++c) hn::Store(value, df, pixels.colour[c]);
  hn::Store(constant(1.0F), df, pixels.alpha);
  hn::Store(depth_node, d, pixels.depth_node);
  hn::Store(constant(0.0F), df, pixels.depth_part);
  hn::Store(samples, d, pixels.samples);
  for (auto* none : {pixels.gradients, pixels.skipped, pixels.terminated}) hn::Store(hn::Zero(d), d, none);
}

/// Sum of value times length, in steps; Neumaier's compensation, because a sum of thousands of floats is
/// printed.
template <PacketVoxels kVoxels, bool kTrapezoid>
HWY_INLINE void xray(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  F sum = constant(0.0F), lost = constant(0.0F), left = constant(0.0F), left_length = constant(0.0F);
  const auto add = [&](F term) HWY_ATTR {
    const F total = hn::Add(sum, term);
    const M larger = hn::Ge(hn::Abs(sum), hn::Abs(term));
    lost = hn::Add(
        lost, hn::Add(hn::Sub(hn::IfThenElse(larger, sum, term), total), hn::IfThenElse(larger, term, sum)));
    sum = total;
  };
  const I samples = walk<kVoxels, kTrapezoid>(job, rays, [&](F value, I, F length, MI active) HWY_ATTR {
    if constexpr (kTrapezoid) {
      const M m = float_mask(active);
      add(hn::Mul(hn::IfThenElseZero(m, left_length),
                  hn::MulAdd(constant(0.5F), left, hn::Mul(constant(0.5F), value))));
      left = hn::IfThenElse(m, value, left);
      left_length = hn::IfThenElse(m, length, left_length);
    } else {
      add(hn::Mul(length, value));
    }
  });
  store_projection(hn::Add(sum, lost), constant_i(-1), samples, pixels);
}

template <PacketVoxels kVoxels>
HWY_INLINE void mip(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  F most = constant(-3.4028235e38F);
  I depth = hn::Zero(DI());
  const I samples = walk<kVoxels, true>(job, rays, [&](F value, I node, F, MI active) HWY_ATTR {
    const M higher = hn::And(float_mask(active), hn::Gt(value, most));
    most = hn::IfThenElse(higher, value, most);
    depth = hn::IfThenElse(int_mask(higher), node, depth);
  });
  store_projection(most, depth, samples, pixels);
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
