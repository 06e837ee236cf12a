// Included once per instruction set by packet_split_kernel.cpp.
#if defined(VOL_RENDER_PACKET_CUBIC_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_CUBIC_INL_H_
#undef VOL_RENDER_PACKET_CUBIC_INL_H_
#else
#define VOL_RENDER_PACKET_CUBIC_INL_H_
#endif

#include "render/packet_sampling-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// The trilinear field along a ray's way through a cell, a cubic of s in [0,1], by powers.
struct Cubic {
  F c[4];
  HWY_INLINE F operator()(F s) const {
    return hn::MulAdd(s, hn::MulAdd(s, hn::MulAdd(s, c[3], c[2]), c[1]), c[0]);
  }
  HWY_INLINE F slope(F s) const {
    return hn::MulAdd(s, hn::MulAdd(s, hn::Mul(constant(3.0F), c[3]), hn::Mul(constant(2.0F), c[2])), c[1]);
  }
};

HWY_INLINE Cubic cubic_along(const Corners& v, F x, F y, F z, F dx, F dy, F dz) {
  // Four edges along x: linear in s; mixed along y: quadratic; along z: cubic.
  const auto start = [&](F v0, F v1) HWY_ATTR { return hn::MulAdd(x, hn::Sub(v1, v0), v0); };
  const auto slope = [&](F v0, F v1) HWY_ATTR { return hn::Mul(dx, hn::Sub(v1, v0)); };
  struct Quadratic {
    F q0, q1, q2;
  };
  const auto face = [&](F a0, F a1, F b0, F b1) HWY_ATTR {
    const F a = start(a0, a1), as = slope(a0, a1);
    const F d = hn::Sub(start(b0, b1), a), ds = hn::Sub(slope(b0, b1), as);
    return Quadratic{hn::MulAdd(y, d, a), hn::MulAdd(dy, d, hn::MulAdd(y, ds, as)), hn::Mul(dy, ds)};
  };
  const Quadratic front = face(v.v000, v.v100, v.v010, v.v110);
  const Quadratic back = face(v.v001, v.v101, v.v011, v.v111);
  const F d0 = hn::Sub(back.q0, front.q0), d1 = hn::Sub(back.q1, front.q1), d2 = hn::Sub(back.q2, front.q2);
  return {{hn::MulAdd(z, d0, front.q0), hn::MulAdd(dz, d0, hn::MulAdd(z, d1, front.q1)),
           hn::MulAdd(dz, d1, hn::MulAdd(z, d2, front.q2)), hn::Mul(dz, d2)}};
}

/// Smallest and largest value at most, by the Bernstein coefficients.
HWY_INLINE void hull(const Cubic& p, F& lo, F& hi) {
  const F third = constant(1.0F / 3);
  const F b1 = hn::MulAdd(third, p.c[1], p.c[0]);
  const F b2 = hn::MulAdd(third, hn::Add(hn::Add(p.c[1], p.c[1]), p.c[2]), p.c[0]);
  const F b3 = p(constant(1.0F));
  lo = hn::Min(hn::Min(p.c[0], b1), hn::Min(b2, b3));
  hi = hn::Max(hn::Max(p.c[0], b1), hn::Max(b2, b3));
}

/// Where the cubic turns, in order; 2 where it does not within (0, 1).
HWY_INLINE void turns(const Cubic& p, F& first, F& second) {
  // a s^2 + 2 b s + c, scaled so that squares neither overflow nor vanish.
  const F most = hn::Max(hn::Abs(p.c[3]), hn::Max(hn::Abs(p.c[2]), hn::Abs(p.c[1])));
  const F down = hn::Div(constant(1.0F), hn::Max(most, constant(1e-37F)));
  const F a = hn::Mul(constant(3.0F), hn::Mul(p.c[3], down)), b = hn::Mul(p.c[2], down),
          c = hn::Mul(p.c[1], down);
  const F discriminant = hn::NegMulAdd(a, c, hn::Mul(b, b));
  const M real = hn::Ge(discriminant, constant(0.0F));
  const F root = hn::Sqrt(hn::Max(discriminant, constant(0.0F)));
  const F q = hn::Neg(hn::Add(b, hn::IfThenElse(hn::Lt(b, constant(0.0F)), hn::Neg(root), root)));
  const auto inside = [&](F numerator, F denominator) HWY_ATTR {
    const M zero = hn::Eq(denominator, constant(0.0F));
    const F s = hn::Div(numerator, hn::IfThenElse(zero, constant(1.0F), denominator));
    const M in =
        hn::And(hn::And(real, hn::Not(zero)), hn::And(hn::Gt(s, constant(0.0F)), hn::Lt(s, constant(1.0F))));
    return hn::IfThenElse(in, s, constant(2.0F));
  };
  const F r = inside(q, a), t = inside(c, q);
  first = hn::Min(r, t);
  second = hn::Max(r, t);
}

/// s in [from, to], on which the cubic is monotone, where it takes a value between its ends' values: Newton
/// steps, halved where they leave the bracket.
HWY_INLINE F crossing(const Cubic& p, F from, F to, F value_from, F value_to, F value) {
  const F rise = hn::Sub(value_to, value_from);
  const M rising = hn::Gt(rise, constant(0.0F));
  F s = hn::MulAdd(
      hn::Div(hn::Sub(value, value_from), hn::IfThenElse(hn::Eq(rise, constant(0.0F)), constant(1.0F), rise)),
      hn::Sub(to, from), from);
  s = hn::Min(hn::Max(s, from), to);
  F lo = from, hi = to;
  // Beside a turn Newton's steps only halve the distance at first: 24 of them reach rounding from anywhere.
  for (int i = 0; i < 24; ++i) {
    const F over = hn::Sub(p(s), value);
    const M before = hn::Xor(hn::Gt(over, constant(0.0F)), rising);  // the crossing lies behind s
    lo = hn::IfThenElse(before, s, lo);
    hi = hn::IfThenElse(before, hi, s);
    const F slope = p.slope(s);
    const F run = reciprocal(hn::IfThenElse(hn::Eq(slope, constant(0.0F)), constant(1e-30F), slope));
    const F next = hn::NegMulAdd(over, run, s);
    const M good = hn::And(hn::Ge(next, lo), hn::Le(next, hi));
    const F moved = hn::IfThenElse(good, next, hn::Mul(constant(0.5F), hn::Add(lo, hi)));
    const F by = hn::Abs(hn::Sub(moved, s));
    // What a Newton step of `by` leaves of a cubic: (p''/2 + c3 by) by^2 / p', whatever its sign.
    const F bends = hn::Abs(hn::MulAdd(hn::Mul(constant(3.0F), p.c[3]), s, p.c[2]));
    const F most = hn::MulAdd(hn::Abs(p.c[3]), by, bends);
    const F rest = hn::Mul(hn::Mul(by, by), hn::Mul(most, hn::Abs(run)));
    s = moved;
    const M there = hn::Or(hn::Le(by, constant(1e-7F)), hn::And(good, hn::Le(rest, constant(2e-8F))));
    if (hn::AllTrue(DF(), there)) break;
  }
  return s;
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
