// Included once per instruction set by the kernels, inside its namespace: no include guard of the usual
// kind.
#if defined(VOL_RENDER_PACKET_MATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_MATH_INL_H_
#undef VOL_RENDER_PACKET_MATH_INL_H_
#else
#define VOL_RENDER_PACKET_MATH_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<DF>;
using F = hn::Vec<DF>;
using I = hn::Vec<DI>;
using M = hn::Mask<DF>;
using MI = hn::Mask<DI>;

constexpr float kExp2m1[] = {6.931471741e-01F, 2.402260561e-01F, 5.549895370e-02F,
                             9.596275803e-03F, 1.290780001e-03F, 1.145805682e-04F};

HWY_INLINE F constant(float v) {
  return hn::Set(DF(), v);
}
HWY_INLINE I constant_i(std::int32_t v) {
  return hn::Set(DI(), v);
}
HWY_INLINE F to_float(I v) {
  return hn::ConvertTo(DF(), v);
}
HWY_INLINE I truncated(F v) {
  return hn::ConvertTo(DI(), v);
}
/// The integer that a float in [0, 2^22] holds. ConvertTo also looks after those that no integer holds.
HWY_INLINE I small_integer(F v) {
  return hn::And(hn::BitCast(DI(), hn::Add(v, constant(0x1p23F))), constant_i(0x7fffff));
}
HWY_INLINE M float_mask(MI m) {
  return hn::RebindMask(DF(), m);
}
HWY_INLINE MI int_mask(M m) {
  return hn::RebindMask(DI(), m);
}

/// 1 / v for |v| in [1e-37, 1e37], to 3e-7 of it. On x86 the machine's estimate, of 12 bits or more, and a
/// step of Newton's, a fraction of what a division waits for; elsewhere estimates have fewer bits.
HWY_INLINE F reciprocal(F v) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  const F r = hn::ApproximateReciprocal(v);
  return hn::MulAdd(r, hn::NegMulAdd(v, r, constant(1.0F)), r);
#else
  return hn::Div(constant(1.0F), v);
#endif
}
/// v^-1/2 for v in [1e-37, 1e37], the same.
HWY_INLINE F reciprocal_root(F v) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  const F r = hn::ApproximateReciprocalSqrt(v);
  const F rest = hn::NegMulAdd(hn::Mul(v, r), r, constant(1.0F));
  return hn::MulAdd(hn::Mul(constant(0.5F), r), rest, r);
#else
  return hn::Div(constant(1.0F), hn::Sqrt(v));
#endif
}

/// (2^f - 1) / f for f in [-1, 0]: a polynomial of degree 5 with relative error 9e-09 (weighted least
/// squares, iterated to the minimax solution), so that f times it keeps the digits of small opacities.
HWY_INLINE F exp2m1_over(F f) {
  F p = hn::MulAdd(constant(kExp2m1[5]), f, constant(kExp2m1[4]));
  p = hn::MulAdd(p, f, constant(kExp2m1[3]));
  p = hn::MulAdd(p, f, constant(kExp2m1[2]));
  p = hn::MulAdd(p, f, constant(kExp2m1[1]));
  return hn::MulAdd(p, f, constant(kExp2m1[0]));
}

/// 1 - 2^y for y <= 0, exactly 0 at 0; with y = k + f, f in (-1, 0], 2^y = 2^k (1 + q): (1 - 2^k) - 2^k q.
/// Exactly 1 from y = -25 on.
HWY_INLINE F one_minus_exp2(F y) {
  y = hn::Max(y, constant(-126.0F));
  const F whole = hn::Trunc(y);
  const F f = hn::Sub(y, whole);
  // k + 127 in the last bits of a float, moved to where the exponent stands.
  const F power =
      hn::BitCast(DF(), hn::ShiftLeft<23>(hn::BitCast(DI(), hn::Add(whole, constant(0x1p23F + 127)))));
  return hn::NegMulAdd(hn::Mul(power, f), exp2m1_over(f), hn::Sub(constant(1.0F), power));
}

/// log2(1 + m) for m in [2^-1/2 - 1, 2^1/2 - 1] as m P(m), P of degree 9, relative error 4e-9.
HWY_INLINE F log2p1_reduced(F m) {
  F p = hn::MulAdd(constant(-0.10994951860602373F), m, constant(0.1861749439296738F));
  p = hn::MulAdd(p, m, constant(-0.19106275968042613F));
  p = hn::MulAdd(p, m, constant(0.20460062296773437F));
  p = hn::MulAdd(p, m, constant(-0.2396174033252155F));
  p = hn::MulAdd(p, m, constant(0.2885674081908687F));
  p = hn::MulAdd(p, m, constant(-0.3606966494134437F));
  p = hn::MulAdd(p, m, constant(0.4808982410614184F));
  p = hn::MulAdd(p, m, constant(-0.7213473515005814F));
  p = hn::MulAdd(p, m, constant(1.442695040829924F));
  return hn::Mul(m, p);
}

/// log2(u) for normal u > 0: exponent and mantissa in [2^-1/2, 2^1/2).
HWY_INLINE F log2_positive(F u) {
  const I bits = hn::BitCast(DI(), u);
  const I offset = constant_i(0x3f3504f3);  // 2^-1/2
  const I exponent = hn::ShiftRight<23>(hn::Sub(bits, offset));
  const F mantissa = hn::BitCast(DF(), hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  return hn::Add(to_float(exponent), log2p1_reduced(hn::Sub(mantissa, constant(1.0F))));
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
