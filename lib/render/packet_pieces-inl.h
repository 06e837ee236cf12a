// Included once per instruction set by the kernels.
#if defined(VOL_RENDER_PACKET_PIECES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_PIECES_INL_H_
#undef VOL_RENDER_PACKET_PIECES_INL_H_
#else
#define VOL_RENDER_PACKET_PIECES_INL_H_
#endif

#include <limits>

#include "render/packet_optics-inl.h"

// Emission and absorption over a piece of a ray on which the field is smooth and crosses no cut of the
// transfer function.

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// Gauss-Legendre on [0,1], and the collocation matrix: integrals from 0 to each node of the polynomial
/// through the nodes' values (the Runge-Kutta methods of Gauss, order 2 kNodes; Butcher 1964).
template <int kNodes>
struct Gauss;
template <>
struct Gauss<1> {
  static constexpr float node[1] = {0.5F}, weight[1] = {1.0F}, up_to[1][1] = {{0.5F}};
};
template <>
struct Gauss<2> {
  static constexpr float node[2] = {0.21132486540518712F, 0.78867513459481288F}, weight[2] = {0.5F, 0.5F};
  static constexpr float up_to[2][2] = {{0.25F, -0.03867513459481288F}, {0.53867513459481288F, 0.25F}};
};
template <>
struct Gauss<3> {
  static constexpr float node[3] = {0.11270166537925831F, 0.5F, 0.88729833462074169F};
  static constexpr float weight[3] = {0.27777777777777778F, 0.44444444444444444F, 0.27777777777777778F};
  static constexpr float up_to[3][3] = {{0.13888888888888889F, -0.03597666752493894F, 0.00978944401530832F},
                                        {0.30026319498086462F, 0.22222222222222222F, -0.02248541720308680F},
                                        {0.26798833376246944F, 0.48042111196938336F, 0.13888888888888889F}};
};

/// Number of the interval of the cuts in which a value lies (a cut itself: in the one above; infinity: in the
/// last).
HWY_INLINE I interval_of(const PacketTransfer& t, F value) {
  value = hn::Min(value, constant(std::numeric_limits<float>::max()));
  if (in_registers(t.intervals)) return piece_of(t.beneath, t.intervals, value);
  I k = hn::GatherIndex(DI(), t.first_cut.data(), truncated(table_coordinate(t, value)));
  for (;;) {
    const MI beyond = int_mask(hn::Ge(value, hn::GatherIndex(DF(), t.cuts.data(), k)));
    if (hn::AllFalse(DI(), beyond)) return k;
    k = hn::Add(k, hn::IfThenElseZero(beyond, constant_i(1)));
  }
}

/// Steps over which log2 T falls by at most 1 in an interval; 1e30 where clear, 0 where opaque.
HWY_INLINE F clarity_of(const PacketTransfer& t, I k) {
  if (in_registers(t.intervals)) return at(t.clear_for, entry(k));
  return hn::GatherIndex(DF(), t.clarity.data(), k);
}
/// The cuts that bound an interval; infinite at the ends.
HWY_INLINE F cut_above(const PacketTransfer& t, I k) {
  if (in_registers(t.intervals)) return at(t.above, entry(k));
  return hn::GatherIndex(DF(), t.cuts.data(), k);
}
HWY_INLINE F cut_beneath(const PacketTransfer& t, I k) {
  if (in_registers(t.intervals)) return at(t.beneath, entry(k));
  const F cut = hn::GatherIndex(DF(), t.cuts.data(), hn::Max(hn::Sub(k, constant_i(1)), hn::Zero(DI())));
  const M lowest = float_mask(hn::Eq(k, hn::Zero(DI())));
  return hn::IfThenElse(lowest, constant(-std::numeric_limits<float>::infinity()), cut);
}

/// What a ray has gathered so far.
template <int kChannels>
struct Gathered {
  F transmittance;
  F sum[kChannels];
};

/// What a piece does to a ray: log2 of its transmittance, its opacity, and the light it sends through its
/// near end.
template <int kChannels>
struct PieceLight {
  F depth, alpha;
  F emitted[kChannels];
};

/// A piece of `length` steps whose field takes `values` at the Gauss nodes; length 0 does nothing.
/// T must not fall below half.
///   tau = length sum_i b_i sigma_i,   alpha = 1 - e^-tau,
///   emitted = alpha (sum_i b_i sigma_i e^-S_i c_i) / (sum_i b_i sigma_i e^-S_i),
/// S_i the depth up to node i. `shade(i, q)`: what lighting makes of node i's colour.
template <int kNodes, int kChannels, class Shade>
HWY_INLINE PieceLight<kChannels> piece_light(const PacketTransfer& t, const F* values, F length,
                                             const Shade& shade) {
  using G = Gauss<kNodes>;
  F y[kNodes], q[kNodes][kChannels];
  F mean = hn::Zero(DF());
  for (int i = 0; i < kNodes; ++i) {
    look_up<kChannels>(t, values[i], y[i], q[i]);
    // Beside a cut, rounding may take the neighbour's line, or find the end of a ramp up to 1.
    y[i] = hn::Max(hn::Min(y[i], hn::Zero(DF())), constant(t.densest));
    shade(i, q[i]);
    mean = hn::MulAdd(constant(G::weight[i]), y[i], mean);
  }
  PieceLight<kChannels> light;
  light.depth = hn::Mul(length, mean);
  light.alpha = hn::Neg(hn::Mul(light.depth, exp2m1_over(light.depth)));
  F total = hn::Zero(DF());
  F sum[kChannels];
  for (int c = 0; c < kChannels; ++c) sum[c] = hn::Zero(DF());
  for (int i = 0; i < kNodes; ++i) {
    F up_to = hn::Zero(DF());
    for (int j = 0; j < kNodes; ++j) up_to = hn::MulAdd(constant(G::up_to[i][j]), y[j], up_to);
    up_to = hn::Min(hn::Mul(length, up_to), hn::Zero(DF()));
    const F clear = hn::MulAdd(up_to, exp2m1_over(up_to), constant(1.0F));
    const F weight = hn::Mul(hn::Mul(constant(G::weight[i]), y[i]), clear);
    total = hn::Add(total, weight);
    for (int c = 0; c < kChannels; ++c) sum[c] = hn::MulAdd(weight, q[i][c], sum[c]);
  }
  const F share = hn::Mul(light.alpha, reciprocal(hn::Min(total, constant(-1e-30F))));
  for (int c = 0; c < kChannels; ++c) light.emitted[c] = hn::Mul(share, sum[c]);
  return light;
}

/// Adds the lanes of `m`.
template <int kChannels>
HWY_INLINE void pass(const PieceLight<kChannels>& light, M m, Gathered<kChannels>& path) {
  const F before = hn::IfThenElseZero(m, path.transmittance);
  for (int c = 0; c < kChannels; ++c) path.sum[c] = hn::MulAdd(before, light.emitted[c], path.sum[c]);
  path.transmittance = hn::NegMulAdd(before, light.alpha, path.transmittance);
}

/// Both. Returns log2 of the piece's transmittance.
template <int kNodes, int kChannels, class Shade>
HWY_INLINE F pass_piece(const PacketTransfer& t, const F* values, F length, const Shade& shade,
                        Gathered<kChannels>& path) {
  const auto light = piece_light<kNodes, kChannels>(t, values, length, shade);
  pass(light, hn::Gt(length, hn::Zero(DF())), path);
  return light.depth;
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
