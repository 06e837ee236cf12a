// Included once per instruction set by packet_steps_kernel.cpp.
#if defined(VOL_RENDER_PACKET_STEPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_STEPS_INL_H_
#undef VOL_RENDER_PACKET_STEPS_INL_H_
#else
#define VOL_RENDER_PACKET_STEPS_INL_H_
#endif

#include "render/packet_composite-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// Trapezoids of adaptive length (step_control.h): a lane takes two steps at once, each of 1 to 2^halvings
/// nodes of the lattice of the shortest step. Every lane has steps of its own, so that what it samples does
/// not depend on its neighbours; both nodes are sampled before what they add is passed, so that neither waits
/// for the other.
template <PacketVoxels kVoxels, int kChannels>
class AdaptiveSteps : private Composite<kVoxels, true, kChannels> {
  using Base = Composite<kVoxels, true, kChannels>;
  using Base::alive_, Base::fresh_, Base::job_, Base::leaps_, Base::path_, Base::remainder_, Base::samples_,
      Base::segments_, Base::skipped_, Base::step_, Base::stops_;

 public:
  AdaptiveSteps(const PacketJob& job, const PacketRays& rays)
      : Base(job, rays), last_(hn::Sub(segments_, constant_i(1))), level_(constant_i(job.halvings)) {}

  void cast(PacketPixels& pixels) {
    open();
    // A copy, which stays in registers: the member is for what is seldom done.
    Path path = path_;
    MI arrived = alive_;
    for (;;) {
      if (this->rays_.distances) leap(path, arrived);
      const MI active = hn::And(alive_, hn::Lt(hn::Add(path.node, constant_i(1)), last_));
      if (hn::AllFalse(DI(), active)) break;
      arrived = try_pair(path, active);
      if (stops_) {
        path_.transmittance = path.transmittance;
        this->stop();
      }
    }
    path_ = path;
    // What is left is at most two of the shortest steps.
    remainder_ = hn::Add(remainder_, to_float(hn::Sub(last_, path_.node)));
    this->finish();
    this->store(pixels);
  }

 private:
  using typename Base::Path;

  /// The first node, where it may be visible.
  HWY_INLINE void open() {
    MI seen = alive_;
    if (this->rays_.distances)
      seen = hn::And(seen,
                     hn::Eq(visible_distance(job_, this->rays_.distances, path_.position), hn::Zero(DI())));
    fresh_ = hn::Lt(alive_ones(), hn::Zero(DI()));  // none: all have a left node now
    skipped_ = hn::Add(skipped_, hn::Sub(alive_ones(), ones(seen)));
    if (hn::AllFalse(DI(), seen)) return;
    const Lights<kChannels> node = this->sample(path_.position);
    if (job_.shaded) this->count_gradients(node, seen, path_.transmittance);
    samples_ = hn::Add(samples_, ones(seen));
    keep(path_, node, seen);
    level_ = most_level(path_);
  }

  static HWY_INLINE I ones(MI m) { return hn::IfThenElseZero(m, constant_i(1)); }
  HWY_INLINE I alive_ones() const { return ones(alive_); }

  /// `node` is the left node of the next segment, for the lanes of `m`.
  static HWY_INLINE void keep(Path& path, const Lights<kChannels>& node, MI m) {
    const M f = float_mask(m);
    path.left.y = hn::IfThenElse(f, node.y, path.left.y);
    for (int c = 0; c < kChannels; ++c) {
      path.left.yq[c] = hn::IfThenElse(f, node.yq[c], path.left.yq[c]);
    }
  }

  /// By how much two trapezoids `hop` nodes long differ, in the pixel, from one over both.
  HWY_INLINE F difference(const Path& path, const Lights<kChannels>& middle, const Lights<kChannels>& right,
                          F hop) const {
    const Lights<kChannels>& left = path.left;
    const auto bend = [](F a, F b, F c) HWY_ATTR { return hn::Sub(hn::Add(a, c), hn::Add(b, b)); };
    const F y = bend(left.y, middle.y, right.y);
    F most = hn::Abs(y);
    for (int c = 0; c < kChannels; ++c) {
      const F yq = bend(left.yq[c], middle.yq[c], right.yq[c]);
      if constexpr (kChannels == 1) {
        for (int k = 0; k < 3; ++k) {  // the colour is one line in q
          const F emitted = hn::MulAdd(constant(job_.transfer.colour1[k]), yq,
                                       hn::Mul(constant(job_.transfer.colour0[k]), y));
          most = hn::Max(most, hn::Abs(emitted));
        }
      } else {
        most = hn::Max(most, hn::Abs(yq));
      }
    }
    constexpr float kLn2 = 0.693147181F;
    return hn::Mul(hn::Mul(constant(kLn2), hop), hn::Mul(path.transmittance, most));
  }

  /// The highest level that shading allows behind the left node: doublings_in_shading() by the exponent of g
  /// alone, for which powers of four count as above.
  HWY_INLINE I most_level(const Path& path) const {
    const I highest = constant_i(job_.halvings);
    if (!job_.shaded) return highest;
    const F g = hn::Mul(hn::Mul(path.transmittance, constant(job_.shading_share)), hn::Abs(path.left.y));
    const I exponent = hn::ShiftRight<23>(hn::BitCast(DI(), g));
    const I doublings = hn::ShiftRight<1>(hn::Sub(constant_i(126), exponent));
    return hn::Min(hn::Max(doublings, hn::Zero(DI())), highest);
  }

  /// `step_` times 2^level, for the lanes of `m`.
  HWY_INLINE Position hop(I level, MI m) const {
    const I rest = hn::Sub(constant_i(31), level);
    const auto whole = [&](I w, I part) HWY_ATTR {
      const auto bits = hn::BitCast(hn::RebindToUnsigned<DI>(), part);
      const auto over = hn::Shr(bits, hn::BitCast(hn::RebindToUnsigned<DI>(), rest));
      return hn::IfThenElseZero(m, hn::Add(hn::Shl(w, level), hn::BitCast(DI(), over)));
    };
    const auto part = [&](I p) HWY_ATTR {
      return hn::IfThenElseZero(m, hn::And(hn::Shl(p, level), constant_i(0x7fffffff)));
    };
    return {whole(step_.whole0, step_.part0),
            whole(step_.whole1, step_.part1),
            whole(step_.whole2, step_.part2),
            part(step_.part0),
            part(step_.part1),
            part(step_.part2)};
  }

  /// The next steps of the lanes of `m`, by their levels; the others stay where they are.
  HWY_INLINE void set_steps(MI m) {
    moves_ = m;
    nodes_ = hn::IfThenElseZero(m, power_of_two(level_));
    hop_ = hop(level_, m);
  }

  /// At the ray's end steps only as long as there are nodes.
  HWY_INLINE MI over(const Path& path, MI active) const {
    return hn::And(active, hn::Gt(hn::Add(path.node, hn::Add(nodes_, nodes_)), last_));
  }

  /// Two steps of every active lane; returns those that were passed. That all pass, and go on with the steps
  /// they have, is left to branches: the processor, which foresees them, samples the next nodes before these
  /// ones have come from memory.
  HWY_INLINE MI try_pair(Path& path, MI active) {
    const DI d;
    if (HWY_UNLIKELY(!hn::AllFalse(d, hn::Xor(active, moves_)))) set_steps(active);
    for (MI ends = over(path, active); HWY_UNLIKELY(!hn::AllFalse(d, ends)); ends = over(path, active)) {
      level_ = hn::Sub(level_, ones(ends));
      set_steps(active);
    }
    Position half = path.position;
    advance(half, hop_);
    Position whole = half;
    advance(whole, hop_);
    const Lights<kChannels> middle = this->sample(half), right = this->sample(whole);
    samples_ = hn::Add(samples_, hn::Add(ones(active), ones(active)));
    if (job_.shaded) {
      this->count_gradients(middle, active, path.transmittance);
      this->count_gradients(right, active, path.transmittance);
    }
    const F length = to_float(nodes_);
    const F made = difference(path, middle, right, length);
    const F most = constant(job_.step_tolerance);
    const MI shortest = hn::Eq(level_, hn::Zero(d));
    const MI passed = hn::And(active, hn::Or(shortest, int_mask(hn::Le(made, most))));
    const MI fails = hn::AndNot(passed, active);
    const bool all = hn::AllFalse(d, fails);
    pass(path, middle, right, HWY_LIKELY(all) ? length : hn::IfThenElseZero(float_mask(passed), length));
    if (HWY_LIKELY(all)) {
      path.position = whole;
      path.node = hn::Add(path.node, hn::Add(nodes_, nodes_));
    } else {
      path.position = selected(passed, whole, path.position);
      path.node = hn::Add(path.node, hn::IfThenElseZero(passed, hn::Add(nodes_, nodes_)));
    }
    path.left_node = path.node;
    keep(path, right, HWY_LIKELY(all) ? active : passed);
    const MI smooth = hn::And(passed, int_mask(hn::Le(made, hn::Mul(most, constant(kGrowBelow)))));
    const I most_now = most_level(path);
    const MI grows = hn::And(smooth, hn::Lt(level_, most_now));
    const MI falls = hn::And(passed, hn::Gt(level_, most_now));
    if (HWY_UNLIKELY(!hn::AllFalse(d, hn::Or(grows, hn::Or(falls, fails))))) {
      level_ = hn::Sub(hn::Add(level_, ones(grows)), ones(fails));
      level_ = hn::IfThenElse(falls, most_now, level_);
      set_steps(active);
    }
    return passed;
  }

  /// Two segments of this length (0: nothing happens).
  HWY_INLINE void pass(Path& path, const Lights<kChannels>& middle, const Lights<kChannels>& right,
                       F length) {
    auto passed = path;
    passed.left_node = path.node;
    passed.node = hn::Add(path.node, nodes_);
    this->segment(passed, middle, length);
    passed.node = hn::Add(passed.node, nodes_);
    this->segment(passed, right, length);
    path.transmittance = passed.transmittance;
    for (int c = 0; c < kChannels; ++c) path.sum[c] = passed.sum[c];
  }

  /// Lanes at a transparent node in an invisible macrocell go to the last node before the first that may be
  /// visible.
  HWY_INLINE void leap(Path& path, MI arrived) {
    const DI d;
    const MI able = hn::And(hn::And(arrived, alive_),
                            hn::And(hn::Lt(path.node, last_), int_mask(hn::Eq(path.left.y, constant(0.0F)))));
    if (hn::AllFalse(d, able)) return;
    const I distance = hn::IfThenElseZero(able, visible_distance(job_, this->rays_.distances, path.position));
    if (hn::AllFalse(d, hn::Gt(distance, hn::Zero(d)))) return;
    path_ = path;
    leap_on(distance);
    path = path_;
  }
  HWY_NOINLINE void leap_on(I distance);

  I last_;   // the last node of the lattice
  I level_;  // log2 of the nodes that the next step is long
  I nodes_;  // that, for the lanes that take it; 0 for the others
  Position hop_;
  MI moves_ = hn::Lt(hn::Zero(DI()), hn::Zero(DI()));  // the lanes that `nodes_` and `hop_` are set for
};

template <PacketVoxels kVoxels, int kChannels>
HWY_NOINLINE void AdaptiveSteps<kVoxels, kChannels>::leap_on(I distance) {
  const DI d;
  const MI leaps = hn::Gt(distance, hn::Zero(d));
  const I start = path_.node;
  MI here = leaps;
  while (!hn::AllFalse(d, here)) {
    const I room = hn::Sub(last_, path_.node);
    const I nodes = hn::IfThenElseZero(here, hn::Min(leaps_.nodes_inside(path_.position, distance), room));
    skipped_ = hn::Add(skipped_, nodes);
    advance(path_.position, scaled(step_, nodes));
    path_.node = hn::Add(path_.node, nodes);
    distance = visible_distance(job_, this->rays_.distances, path_.position);
    here = hn::And(here, hn::And(hn::Gt(distance, hn::Zero(d)), hn::Lt(path_.node, last_)));
  }
  // Not where nothing was found on the way.
  const MI found = hn::And(leaps, hn::Eq(distance, hn::Zero(d)));
  retreat(path_.position, masked(step_, found));
  const I back = hn::IfThenElseZero(found, constant_i(1));
  path_.node = hn::Sub(path_.node, back);
  skipped_ = hn::Sub(skipped_, back);
  path_.left_node = hn::IfThenElse(leaps, path_.node, path_.left_node);
  level_ = hn::IfThenElse(hn::And(leaps, hn::Gt(path_.node, start)), constant_i(job_.halvings), level_);
  set_steps(moves_);
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
