// Included once per instruction set by packet_split_kernel.cpp.
#if defined(VOL_RENDER_PACKET_SPLIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_SPLIT_INL_H_
#undef VOL_RENDER_PACKET_SPLIT_INL_H_
#else
#define VOL_RENDER_PACKET_SPLIT_INL_H_
#endif

#include "render/packet_budget-inl.h"
#include "render/packet_cubic-inl.h"
#include "render/packet_light-inl.h"
#include "render/packet_path-inl.h"
#include "render/packet_pieces-inl.h"
#include "render/packet_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// A packet cell by cell: in each, the cubic along the ray is cut where it crosses the transfer function's
/// points (and `cuts` of packet_transfer.h), and its smooth pieces are integrated by kNodes Gauss nodes
/// (after Weiss and Westermann 2021). Adaptive: a piece is halved until its error, estimated by the rule of
/// one node less, fits the ray's budget.
template <PacketVoxels kVoxels, int kChannels, int kNodes, bool kAdaptive>
class Split {
 public:
  Split(const PacketJob& job, const PacketRays& rays)
      : job_(job), distances_(rays.distances), walk_(job, rays) {
    const DI d;
    alive_ = hn::Gt(hn::Load(d, rays.segments), hn::Zero(d));
    stopped_ = hn::Lt(hn::Zero(d), hn::Zero(d));
    samples_ = skipped_ = gradients_ = hn::Zero(d);
    passed_ = hn::Zero(DF());
    halfway_.begin(alive_);
    path_.transmittance = constant(1.0F);
    for (int c = 0; c < kChannels; ++c) path_.sum[c] = hn::Zero(DF());
    for (int a = 0; a < 3; ++a) ray_[a] = job.shaded ? hn::Load(DF(), rays.direction[a]) : hn::Zero(DF());
    budget_.begin(job, length_ahead(hn::Zero(d), hn::Load(d, rays.segments), hn::Load(DF(), rays.remainder)));
  }

  void cast(PacketPixels& pixels) {
    while (!hn::AllFalse(DI(), alive_)) {
      if (distances_) leave_empty_space();
      if (hn::AllFalse(DI(), alive_)) break;
      pass_cell();
    }
    store(pixels);
  }

 private:
  HWY_INLINE void leave_empty_space() {
    const DI d;
    for (;;) {
      const I distance = hn::IfThenElseZero(alive_, visible_distance(job_, distances_, walk_.cell()));
      const MI here = hn::Gt(distance, hn::Zero(d));
      if (HWY_LIKELY(hn::AllFalse(d, here))) return;
      const auto faces = walk_.faces();
      const F room = walk_.room(distance);
      const MI far = hn::And(here, int_mask(hn::Gt(room, faces.nearest)));
      const MI near = hn::AndNot(far, here);
      passed_ = hn::Add(passed_, hn::IfThenElseZero(float_mask(here), hn::Max(room, faces.nearest)));
      MI out = walk_.cross(faces, near);
      out = hn::Or(out, walk_.jump(room, far));
      alive_ = hn::AndNot(out, alive_);
      skipped_ = hn::Add(skipped_, hn::IfThenElseZero(here, constant_i(1)));
    }
  }

  HWY_INLINE void pass_cell() {
    const auto faces = walk_.faces();
    Sampler<kVoxels> sampler;
    sampler.load_corners(job_, walk_.cell());
    samples_ = hn::Add(samples_, hn::IfThenElseZero(alive_, constant_i(1)));
    F at[3], way[3];
    for (int a = 0; a < 3; ++a) {
      at[a] = walk_.at(a);
      way[a] = hn::Mul(faces.nearest, walk_.along(a));
    }
    const Cubic p = cubic_along(sampler.c, at[0], at[1], at[2], way[0], way[1], way[2]);
    CellLight<kVoxels> light(job_, sampler, at, way, ray_);
    pass_cubic(p, hn::IfThenElseZero(float_mask(alive_), faces.nearest), light);
    passed_ = hn::Add(passed_, faces.nearest);
    const MI out = walk_.cross(faces, alive_);
    alive_ = hn::AndNot(out, alive_);
    const MI stopped = hn::And(alive_, int_mask(hn::Le(path_.transmittance, constant(job_.termination))));
    alive_ = hn::AndNot(stopped, alive_);
    stopped_ = hn::Or(stopped_, stopped);
  }

  /// The whole of a cell, `length` steps (0: nothing happens).
  HWY_INLINE void pass_cubic(const Cubic& p, F length, CellLight<kVoxels>& lamp) {
    const PacketTransfer& t = job_.transfer;
    F lo, hi;
    hull(p, lo, hi);
    const I lowest = interval_of(t, lo);
    const M one_interval = hn::Lt(hi, cut_above(t, lowest));
    const M some = hn::Gt(length, constant(0.0F));
    M whole = hn::Or(hn::Not(some), one_interval);
    if (kChannels == 3 && job_.shaded && job_.headlight) {
      // Light along the ray has a kink where the field's slope along it changes sign.
      F turn, second;
      turns(p, turn, second);
      whole = hn::And(whole, hn::Or(hn::Not(some), hn::Gt(turn, constant(1.0F))));
    }
    const F clarity = clarity_of(t, lowest);
    M done = hn::Not(some);
    if (HWY_UNLIKELY(!t.peaks.empty())) done = hn::Or(done, enter_peaks(p, length, some, lamp));
    if (HWY_LIKELY(hn::AllTrue(DF(), hn::Or(done, hn::And(whole, hn::Ge(clarity, length)))))) {
      const M seen = hn::AndNot(done, hn::Lt(clarity, constant(kClear)));
      if (hn::AllFalse(DF(), seen)) return;
      const M passed = piece(p, hn::Zero(DF()), constant(1.0F), length, seen, lamp);
      done = hn::Or(done, passed);
      if (!kAdaptive || HWY_LIKELY(hn::AllTrue(DF(), done))) return;
    }
    pass_in_pieces(p, length, done, lamp);
  }

  /// From `from` to `to` of a cell `length` steps long, for the lanes of `seen`. Returns the lanes that are
  /// behind it: all but those whose error would be too large.
  HWY_INLINE M piece(const Cubic& p, F from, F to, F length, M seen, CellLight<kVoxels>& lamp) {
    const F width = hn::Sub(to, from);
    const F stretch = hn::IfThenElseZero(seen, hn::Mul(width, length));
    const F start = hn::MulAdd(from, length, passed_);
    const auto light = light_of<kNodes>(p, from, width, stretch, seen, lamp);
    M passes = seen;
    if constexpr (kAdaptive) {
      const auto check = light_of<kNodes - 1>(p, from, width, stretch, seen, lamp);
      F error = ErrorBudget::estimate(job_, path_.transmittance, light, check);
      if (kChannels == 3 && job_.shaded) {
        const M unsure = hn::And(seen, lamp.turns(from, to));
        const F lit = hn::Mul(hn::Mul(path_.transmittance, light.alpha), constant(job_.error_light));
        error = hn::Add(error, hn::IfThenElseZero(unsure, lit));
        gradients_ = hn::Add(gradients_, hn::IfThenElseZero(int_mask(seen), constant_i(3)));
      }
      const M fits = hn::Or(budget_.allows(error, stretch, start), hn::Le(width, constant(kNarrowest)));
      passes = hn::And(seen, fits);
      budget_.spend(hn::IfThenElseZero(passes, error));
    }
    const F before = path_.transmittance;
    pass(light, passes, path_);
    const I node = truncated(start);
    halfway_.pass(node, hn::Sub(start, to_float(node)), before, path_.transmittance, light.depth, stretch);
    return hn::Or(passes, hn::Not(seen));
  }

  template <int kSome>
  HWY_INLINE PieceLight<kChannels> light_of(const Cubic& p, F from, F width, F stretch, M seen,
                                            CellLight<kVoxels>& lamp) {
    F nodes[kSome], values[kSome];
    for (int i = 0; i < kSome; ++i) {
      nodes[i] = hn::MulAdd(constant(Gauss<kSome>::node[i]), width, from);
      values[i] = p(nodes[i]);
    }
    const I evaluated = hn::IfThenElseZero(int_mask(seen), constant_i(kSome));
    samples_ = hn::Add(samples_, evaluated);
    if (job_.shaded) gradients_ = hn::Add(gradients_, evaluated);
    return piece_light<kSome, kChannels>(job_.transfer, values, stretch, [&](int i, F* q) HWY_ATTR {
      if constexpr (kChannels == 3) lamp.shade(nodes[i], q);
    });
  }

  /// A cell that begins on a cut and falls belongs to the interval beneath: a value only touched is not
  /// entered.
  static HWY_INLINE I interval_below(const PacketTransfer& t, const Cubic& p, I k) {
    const F zero = hn::Zero(DF());
    const M falls =
        hn::Or(hn::Lt(p.c[1], zero),
               hn::And(hn::Eq(p.c[1], zero),
                       hn::Or(hn::Lt(p.c[2], zero), hn::And(hn::Eq(p.c[2], zero), hn::Lt(p.c[3], zero)))));
    const M on_cut = hn::Eq(p.c[0], cut_beneath(t, k));
    return hn::Sub(k, hn::IfThenElseZero(int_mask(hn::And(on_cut, falls)), constant_i(1)));
  }

  /// A cell in pieces, for the lanes that are not `done`.
  HWY_NOINLINE void pass_in_pieces(const Cubic& p, F length, M done, CellLight<kVoxels>& lamp) {
    const PacketTransfer& t = job_.transfer;
    const F one = constant(1.0F);
    const F per_length = reciprocal(hn::Max(length, constant(1e-20F)));
    F turn, second;
    turns(p, turn, second);
    F from = hn::IfThenElseZero(done, one);
    F widest = one;
    M fell = hn::Lt(one, one);  // into the present interval, from above
    F value = p.c[0];
    I k = interval_below(t, p, interval_of(t, value));
    do {
      const M open = hn::Lt(from, one);
      const F clarity = clarity_of(t, k);
      const M opaque = hn::And(open, hn::Eq(clarity, hn::Zero(DF())));
      if (HWY_UNLIKELY(!hn::AllFalse(DF(), opaque))) {
        // From above, the cut itself belongs to the interval left.
        const F range = constant(static_cast<float>(t.buckets) / t.scale);
        const F aside = hn::Mul(constant(5e-7F), hn::Add(range, hn::Abs(value)));
        enter_opaque(hn::IfThenElse(fell, hn::Sub(value, aside), value), from, length, opaque, lamp);
        from = hn::IfThenElse(opaque, one, from);
        continue;
      }
      // The next stretch on which the cubic is monotone.
      const F end = hn::IfThenElse(hn::Lt(from, turn), hn::Min(turn, one),
                                   hn::IfThenElse(hn::Lt(from, second), hn::Min(second, one), one));
      const F value_end = p(end);
      const F upper = cut_above(t, k), lower = cut_beneath(t, k);
      const M rises = hn::Ge(value_end, upper), falls = hn::Lt(value_end, lower);
      const M cuts = hn::Or(rises, falls);
      const F cut = hn::IfThenElse(rises, upper, lower);
      F to = end;
      if (!hn::AllFalse(DF(), cuts)) {
        const F place = crossing(p, from, end, value, value_end, hn::IfThenElse(cuts, cut, value));
        to = hn::IfThenElse(cuts, place, end);
      }
      F reach = hn::MulAdd(clarity, per_length, from);
      if constexpr (kAdaptive) reach = hn::Min(reach, hn::Add(from, widest));
      const M capped = hn::Lt(reach, to);
      to = hn::IfThenElse(capped, reach, to);
      const F width = hn::Sub(to, from);
      const M seen = hn::And(hn::Gt(width, constant(0.0F)), hn::Lt(clarity, constant(kClear)));
      M passed = hn::Eq(width, width);
      if (!hn::AllFalse(DF(), seen)) passed = piece(p, from, to, length, seen, lamp);
      if constexpr (kAdaptive) {
        widest =
            hn::IfThenElse(passed, hn::Min(one, hn::Add(widest, widest)), hn::Mul(constant(0.5F), width));
      }
      const M crosses = hn::And(hn::And(open, passed), hn::AndNot(capped, cuts));
      const I beside = hn::IfThenElse(int_mask(rises), constant_i(1), constant_i(-1));
      k = hn::Add(k, hn::IfThenElseZero(int_mask(crosses), beside));
      fell = hn::Or(hn::And(crosses, falls), hn::AndNot(crosses, fell));
      const F value_to =
          hn::IfThenElse(hn::AndNot(capped, cuts), cut, hn::IfThenElse(capped, p(to), value_end));
      value = hn::IfThenElse(passed, value_to, value);
      from = hn::IfThenElse(passed, to, from);
      // What lies behind nothing is seen through is left out.
    } while (!hn::AllFalse(DF(), hn::And(hn::Lt(from, one), hn::Gt(path_.transmittance, constant(0.0F)))));
  }

  /// Cells that are constant at a value where the opacity only touches 1 are opaque. Returns their lanes.
  HWY_NOINLINE M enter_peaks(const Cubic& p, F length, M some, CellLight<kVoxels>& lamp) {
    const F zero = hn::Zero(DF());
    const M constant_cell =
        hn::And(hn::Eq(p.c[1], zero), hn::And(hn::Eq(p.c[2], zero), hn::Eq(p.c[3], zero)));
    M at_peak = hn::Lt(zero, zero);
    for (const float peak : job_.transfer.peaks) at_peak = hn::Or(at_peak, hn::Eq(p.c[0], constant(peak)));
    const M opaque = hn::And(some, hn::And(constant_cell, at_peak));
    if (!hn::AllFalse(DF(), opaque)) enter_opaque(p.c[0], zero, length, opaque, lamp);
    return opaque;
  }

  /// T c, and nothing behind it.
  HWY_NOINLINE void enter_opaque(F value, F from, F length, M m, CellLight<kVoxels>& lamp) {
    PieceLight<kChannels> light;
    F y;
    look_up<kChannels>(job_.transfer, value, y, light.emitted);
    if constexpr (kChannels == 3) lamp.shade(from, light.emitted);
    light.alpha = constant(1.0F);
    light.depth = constant(kOpaque);
    const F before = path_.transmittance, start = hn::MulAdd(from, length, passed_);
    pass(light, m, path_);
    const I node = truncated(start);
    halfway_.pass(node, hn::Sub(start, to_float(node)), before, path_.transmittance, light.depth,
                  hn::Zero(DF()));
    samples_ = hn::Add(samples_, hn::IfThenElseZero(int_mask(m), constant_i(1)));
    if (job_.shaded) gradients_ = hn::Add(gradients_, hn::IfThenElseZero(int_mask(m), constant_i(1)));
  }

  void store(PacketPixels& pixels) const {
    store_colour<kChannels>(job_.transfer, path_.sum, path_.transmittance, pixels);
    halfway_.store(pixels);
    store_counts(samples_, skipped_, gradients_, stopped_, pixels);
    const F unseen = hn::IfThenElseZero(float_mask(stopped_), path_.transmittance);
    hn::Store(hn::MulAdd(constant(job_.error_unseen), unseen, budget_.made()), DF(), pixels.error);
  }

  static constexpr float kClear = 1e29F;            // clarity of what nothing is seen in
  static constexpr float kNarrowest = 1.0F / 4096;  // of a cell: no piece is halved further

  const PacketJob& job_;
  const std::uint8_t* distances_;
  CellWalk walk_;
  Gathered<kChannels> path_;
  Halfway halfway_;
  ErrorBudget budget_;
  I samples_, skipped_, gradients_;
  F passed_;  // steps from the entry
  F ray_[3];
  MI alive_, stopped_;
};

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
