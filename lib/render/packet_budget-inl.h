// Included once per instruction set by packet_split_kernel.cpp.
#if defined(VOL_RENDER_PACKET_BUDGET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_BUDGET_INL_H_
#undef VOL_RENDER_PACKET_BUDGET_INL_H_
#else
#define VOL_RENDER_PACKET_BUDGET_INL_H_
#endif

#include "render/packet_pieces-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// How much error a ray may still make, and what its pieces have made so far.
class ErrorBudget {
 public:
  void begin(const PacketJob& job, F length) {
    left_ = constant(job.budget);
    length_ = length;
    made_ = hn::Zero(DF());
  }

  /// Estimate of what a piece's error does to the pixel: `by` against a rule of lower order, `check`.
  template <int kChannels>
  static HWY_INLINE F estimate(const PacketJob& job, F transmittance, const PieceLight<kChannels>& by,
                               const PieceLight<kChannels>& check) {
    F emitted = hn::Zero(DF());
    for (int c = 0; c < kChannels; ++c) {
      emitted = hn::Max(emitted, hn::Abs(hn::Sub(by.emitted[c], check.emitted[c])));
    }
    const F absorbed = hn::Abs(hn::Sub(by.alpha, check.alpha));
    return hn::Mul(transmittance, hn::MulAdd(constant(job.error_emitted), emitted,
                                             hn::Mul(constant(job.error_alpha), absorbed)));
  }

  /// Whether a piece `stretch` steps long that begins `passed` steps behind the ray's entry may make an
  /// error. What other pieces leave over may be spent: of what is left, four times the piece's share of the
  /// way ahead.
  HWY_INLINE M allows(F error, F stretch, F passed) const {
    const F ahead = hn::Max(hn::Sub(length_, passed), stretch);
    const F share = hn::Div(hn::Mul(constant(4.0F), stretch), hn::Max(ahead, constant(1e-20F)));
    const F most = hn::Min(hn::Max(share, constant(1.0F / 64)), constant(0.5F));
    return hn::Le(error, hn::Mul(most, left_));
  }

  HWY_INLINE void spend(F error) {
    made_ = hn::Add(made_, error);
    left_ = hn::Max(hn::Sub(left_, error), hn::Zero(DF()));
  }
  HWY_INLINE F made() const { return made_; }

 private:
  F left_, length_, made_;
};

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
