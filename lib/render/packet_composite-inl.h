// Included once per instruction set by packet_kernel.cpp.
#if defined(VOL_RENDER_PACKET_COMPOSITE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_COMPOSITE_INL_H_
#undef VOL_RENDER_PACKET_COMPOSITE_INL_H_
#else
#define VOL_RENDER_PACKET_COMPOSITE_INL_H_
#endif

#include <algorithm>

#include "render/packet_optics-inl.h"
#include "render/packet_path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// Nodes between two looks at the macrocells: lanes look where their node is a multiple of this. What a lane
/// samples then depends on its own ray alone, not on its neighbours or the number of lanes.
constexpr int kRun = 2;

/// A packet on its way through the volume: one ray a lane, each at a node of its own.
///
/// Rectangle: node i opens segment i; the last node n - 1 opens the shorter last segment. Trapezoid: a
/// segment is closed by its right node; `fresh` lanes have no left node yet. A lane that is done takes steps
/// of length 0 at the place where it stopped, which add exactly nothing. A segment whose nodes have
/// extinctions s0, s1 has the colour (s0 c0 + s1 c1) / (s0 + s1): a node known to be invisible counts as y =
/// 0 without being sampled.
template <PacketVoxels kVoxels, bool kTrapezoid, int kChannels>
class Composite {
 public:
  Composite(const PacketJob& job, const PacketRays& rays)
      : job_(job), rays_(rays), indexed_(job.nibbles != nullptr) {
    const DI d;
    segments_ = hn::Load(d, rays.segments);
    remainder_ = hn::Load(DF(), rays.remainder);
    path_.position = load(rays.entry_whole, rays.entry_part);
    step_ = load(rays.step_whole, rays.step_part);
    path_.node = path_.left_node = samples_ = skipped_ = gradients_ = hn::Zero(d);
    alive_ = hn::Gt(segments_, hn::Zero(d));
    halfway_.begin(alive_);
    fresh_ = alive_;
    path_.transmittance = constant(1.0F);
    left_length_ = hn::Zero(DF());
    path_.left.y = hn::Zero(DF());
    for (int c = 0; c < kChannels; ++c) path_.left.yq[c] = path_.sum[c] = hn::Zero(DF());
    if (job.shaded) {
      for (int a = 0; a < 3; ++a) ray_[a] = hn::Load(DF(), rays.direction[a]);
    } else {
      ray_[0] = ray_[1] = ray_[2] = hn::Zero(DF());
    }
    stops_ = job.termination > 0 || job.transfer.opaque || job.transfer.steepest * longest() < -20;
    // |y| of any segment at most 1: 2^y needs no range reduction.
    gentle_ = job.transfer.steepest * longest() >= -1;
    end_invisible_ = hn::Lt(segments_, hn::Zero(d));
    if (rays.distances) {
      if (kTrapezoid) {
        end_invisible_ =
            hn::Gt(visible_distance(job, rays.distances, load(rays.exit_whole, rays.exit_part)), hn::Zero(d));
      }
      leaps_.prepare(step_);
    }
  }

  void cast(PacketPixels& pixels) {
    // Lattice nodes visited by the main loop; a rectangle's last one has its own length (an index knows it
    // anyway).
    const I limit = kTrapezoid || indexed_ ? segments_ : hn::Sub(segments_, constant_i(1));
    for (;;) {
      if (!indexed_ && phase_ == 0) run_on(limit);
      if (rays_.distances && phase_ == 0) leap(limit);
      const MI active = hn::And(alive_, hn::Lt(path_.node, limit));
      if (hn::AllFalse(DI(), active)) break;
      run(active, limit);
    }
    if (kTrapezoid || !indexed_) finish();
    store(pixels);
  }

 protected:  // what AdaptiveSteps builds on too
  [[nodiscard]] float longest() const { return job_.longest_hop; }

  HWY_INLINE F ahead(I node) const { return length_ahead(node, segments_, remainder_); }

  HWY_INLINE Lights<kChannels> sample(const Position& p) const {
    Sampler<kVoxels> sampler;
    const F value = sampler.value(job_, p);
    return lights<kChannels>(job_, value, sampler, ray_);
  }

  HWY_INLINE I level_here() const {
    return hn::IfThenElse(hn::Eq(path_.node, hn::Zero(DI())), hn::Load(DI(), rays_.first_level),
                          index_level(job_, path_.position));
  }

  /// What changes from node to node, kept in registers while a run lasts.
  struct Path {
    Position position;
    I node, left_node;
    F transmittance;
    F sum[kChannels];
    Lights<kChannels> left;
  };

  /// Passes a segment of `length` steps (0: nothing happens), log2 of its transmittance y a step, and its
  /// nodes' sums of y and y q: emission = alpha (sum of y q) / (sum of y). Of y <= 0 the magnitude counts.
  HWY_INLINE void absorb(Path& path, F y, F sum_y, const F* sum_yq, F length) {
    const F depth = hn::Mul(y, length);
    F share, behind;
    if (gentle_) {
      share = hn::Mul(length, exp2m1_over(depth));
      behind = hn::MulAdd(path.transmittance, hn::Mul(y, share), path.transmittance);
    } else {
      const F alpha = one_minus_exp2(depth);
      share = hn::Mul(alpha, reciprocal(hn::Max(hn::Neg(sum_y), constant(1e-30F))));
      behind = hn::NegMulAdd(path.transmittance, alpha, path.transmittance);
    }
    const F weight = hn::Mul(path.transmittance, share);
    halfway_.pass(kTrapezoid ? path.left_node : path.node, hn::Zero(DF()), path.transmittance, behind, depth,
                  length);
    for (int c = 0; c < kChannels; ++c) path.sum[c] = hn::NegMulAdd(weight, sum_yq[c], path.sum[c]);
    path.transmittance = behind;
  }

  /// One segment: from the left node to `node` (trapezoid), or opened by `node` (rectangle).
  HWY_INLINE void segment(Path& path, const Lights<kChannels>& node, F length) {
    if constexpr (kTrapezoid) {
      const Lights<kChannels>& left = path.left;
      F sum_y = hn::Add(left.y, node.y);
      F sum_yq[kChannels];
      for (int c = 0; c < kChannels; ++c) sum_yq[c] = hn::Add(left.yq[c], node.yq[c]);
      F y = sum_y;
      if (HWY_UNLIKELY(job_.transfer.opaque)) {
        // One end opaque: opacity runs linearly to 1, tau = r (1 - log(1 - a)); both: opaque, the left
        // colour.
        const F lower = hn::Min(left.y, node.y), upper = hn::Max(left.y, node.y);
        const M one = hn::Le(lower, constant(kOpaqueTest)), both = hn::Le(upper, constant(kOpaqueTest));
        const F ramp = hn::Sub(hn::Add(upper, upper), constant(2.885390082F * job_.transfer.exponent));
        y = hn::IfThenElse(one, hn::IfThenElse(both, constant(kOpaque), ramp), y);
        sum_y = hn::IfThenElse(both, left.y, sum_y);
        for (int c = 0; c < kChannels; ++c) sum_yq[c] = hn::IfThenElse(both, left.yq[c], sum_yq[c]);
      }
      absorb(path, y, sum_y, sum_yq, length);
      path.left = node;
      path.left_node = path.node;
    } else {
      absorb(path, node.y, node.y, node.yq, length);
    }
  }

  /// Runs one after the other while no lane is near its end. Both nodes of a run are sampled before what they
  /// add is passed: neither waits for the other. Lanes that leave empty space or stop leave the inner loop,
  /// whose path stays in registers.
  HWY_INLINE void run_on(I limit) {
    const DI d;
    const I least = constant_i(kTrapezoid ? kRun + 1 : kRun);  // a trapezoid's last node is left to run()
    // A lane that left empty space begins its run at the node before the first visible one.
    for (bool looks = rays_.distances != nullptr;; looks = false) {
      const MI active = hn::And(alive_, hn::Lt(path_.node, limit));
      const I ones = hn::IfThenElseZero(active, constant_i(1));
      const F whole = to_float(ones);
      const Position hop = masked(step_, active);
      Path path = path_;
      bool goes_on = !hn::AllFalse(d, active);
      while (goes_on) {
        goes_on = hn::AllFalse(d, hn::And(active, hn::Lt(hn::Sub(limit, path.node), least)));
        if (HWY_UNLIKELY(!goes_on)) break;
        if (looks) {
          const MI hidden = hn::Gt(visible_distance(job_, rays_.distances, path.position), hn::Zero(d));
          if (!hn::AllFalse(d, hn::And(active, hidden))) break;
        }
        looks = rays_.distances != nullptr;
        Position second = path.position;
        advance(second, hop);
        const Lights<kChannels> nodes[kRun] = {sample(path.position), sample(second)};
        F length = whole;
        if (kTrapezoid) length = hn::IfThenElseZero(float_mask(hn::AndNot(fresh_, active)), whole);
        for (const Lights<kChannels>& node : nodes) {
          I taken = ones;
          if (stops_) {
            const M going = hn::Gt(path.transmittance, constant(job_.termination));
            length = hn::IfThenElseZero(going, length);
            taken = hn::IfThenElseZero(int_mask(going), ones);
          }
          samples_ = hn::Add(samples_, taken);
          if (job_.shaded) count_gradients(node, active, path.transmittance);
          segment(path, node, length);
          path.node = hn::Add(path.node, ones);
          length = whole;
        }
        path.position = second;
        advance(path.position, hop);
        fresh_ = hn::AndNot(active, fresh_);
        const M ended = hn::Le(path.transmittance, constant(job_.termination));
        if (stops_ && !hn::AllFalse(DF(), hn::And(float_mask(active), ended))) break;
      }
      if (kTrapezoid) path.left_node = hn::IfThenElse(active, path.left_node, path_.left_node);
      path_ = path;
      if (!goes_on) return;
      if (stops_) stop();
      if (rays_.distances) leap(limit);
    }
  }

  /// Several nodes of every active lane, none of which ends on the way.
  HWY_INLINE void run(MI active, I limit) {
    const DI d;
    const I ones = hn::IfThenElseZero(active, constant_i(1));
    int count = 1;
    if (!indexed_) {
      const I left = hn::IfThenElse(active, hn::Sub(limit, path_.node), constant_i(kRun));
      count = std::min(kRun - phase_, static_cast<int>(hn::GetLane(hn::MinOfLanes(d, left))));
      phase_ = (phase_ + count) % kRun;
    }
    const F whole = to_float(ones);
    F length = whole;
    if (kTrapezoid) {
      length = hn::IfThenElseZero(float_mask(hn::AndNot(fresh_, active)), indexed_ ? left_length_ : whole);
    }
    Position hop = masked(step_, active);
    I hop_nodes = ones;
    if (indexed_) {
      const I nodes = power_of_two(level_here());
      hop_nodes = hn::IfThenElseZero(active, hn::Min(nodes, hn::Sub(segments_, path_.node)));
      // A lane that reaches the end stays where it is: the last node has a place of its own.
      const MI stays = hn::Not(hn::Lt(hn::Add(path_.node, hop_nodes), segments_));
      hop = scaled(step_, hn::IfThenElseZero(hn::AndNot(stays, active), hop_nodes));
      const F next = hn::IfThenElseZero(float_mask(active), hn::Min(to_float(nodes), ahead(path_.node)));
      if (kTrapezoid) {
        left_length_ = hn::IfThenElse(float_mask(active), next, left_length_);
      } else {
        length = next;
      }
    }
    Path path = path_;
    for (int r = 0; r < count; ++r) {
      if (stops_) {
        const M going = hn::Gt(path.transmittance, constant(job_.termination));
        length = hn::IfThenElseZero(going, length);
        if (hn::AllFalse(DF(), hn::And(going, float_mask(active)))) break;
        samples_ = hn::Add(samples_, hn::IfThenElseZero(int_mask(going), ones));
      }
      const Lights<kChannels> node = sample(path.position);
      if (job_.shaded) count_gradients(node, active, path.transmittance);
      segment(path, node, length);
      advance(path.position, hop);
      path.node = hn::Add(path.node, hop_nodes);
      length = whole;
    }
    if (kTrapezoid && !indexed_) {
      // A ray that has passed its last lattice node waits there, not behind it.
      const MI waits = hn::AndNot(hn::Lt(path.node, limit), active);
      if (!hn::AllFalse(d, waits)) retreat(path.position, masked(step_, waits));
    }
    // A ray that waits was passed segments of no length, which open nothing.
    if (kTrapezoid) path.left_node = hn::IfThenElse(active, path.left_node, path_.left_node);
    path_ = path;
    fresh_ = hn::AndNot(active, fresh_);
    if (stops_) {
      stop();
    } else {
      samples_ = hn::Add(samples_, count == 1 ? ones : hn::Mul(ones, constant_i(count)));
    }
  }

  /// Only nodes that emit are lit.
  HWY_INLINE void count_gradients(const Lights<kChannels>& node, MI active, F transmittance) {
    const M lit = hn::And(hn::Lt(node.y, constant(0.0F)), hn::Gt(transmittance, constant(job_.termination)));
    gradients_ = hn::Add(gradients_, hn::IfThenElseZero(hn::And(active, int_mask(lit)), constant_i(1)));
  }

  HWY_INLINE void stop() {
    const MI stopped = hn::And(alive_, int_mask(hn::Le(path_.transmittance, constant(job_.termination))));
    if (HWY_LIKELY(hn::AllFalse(DI(), stopped))) return;
    alive_ = hn::AndNot(stopped, alive_);
    // A rectangle's last segment, if it was passed here, has ended its ray anyway.
    const MI early = indexed_ && !kTrapezoid ? hn::Lt(path_.node, segments_) : stopped;
    stopped_ = hn::Or(stopped_, hn::And(stopped, early));
  }

  /// Macrocells whose values are all invisible are left behind without sampling.
  HWY_INLINE void leap(I limit) {
    const MI able = hn::And(alive_, hn::Lt(path_.node, limit));
    const I distance = hn::IfThenElseZero(able, visible_distance(job_, rays_.distances, path_.position));
    if (!hn::AllFalse(DI(), hn::Gt(distance, hn::Zero(DI())))) leap_on(distance);
  }
  HWY_NOINLINE void leap_on(I distance);
  HWY_NOINLINE void close_before_leap(MI here);
  void finish();
  void store(PacketPixels& pixels) const;

  const PacketJob& job_;
  const PacketRays& rays_;
  const bool indexed_;
  Path path_;
  Position step_;
  Leaps leaps_;
  Halfway halfway_;
  I segments_, samples_, skipped_, gradients_;
  F remainder_, left_length_;
  F ray_[3];
  MI alive_, fresh_, end_invisible_, stopped_ = hn::Lt(hn::Zero(DI()), hn::Zero(DI()));
  int phase_ = 0;  // of all active lanes: node mod kRun (an index: 0, every node looks)
  bool stops_, gentle_;
};

/// A node known to be invisible closes the segment of the visible one before it.
template <PacketVoxels kVoxels, bool kTrapezoid, int kChannels>
HWY_NOINLINE void Composite<kVoxels, kTrapezoid, kChannels>::close_before_leap(MI here) {
  const MI open = hn::AndNot(hn::Or(fresh_, int_mask(hn::Eq(path_.left.y, constant(0.0F)))), here);
  if (hn::AllFalse(DI(), open)) return;
  Lights<kChannels> nothing;
  nothing.y = hn::Zero(DF());
  for (int c = 0; c < kChannels; ++c) nothing.yq[c] = hn::Zero(DF());
  Path closed = path_;
  segment(closed, nothing, hn::IfThenElseZero(float_mask(open), indexed_ ? left_length_ : constant(1.0F)));
  path_.transmittance = closed.transmittance;
  for (int c = 0; c < kChannels; ++c) path_.sum[c] = closed.sum[c];
  if (stops_) stop();
}

/// `distance` is 0 for lanes that stay.
template <PacketVoxels kVoxels, bool kTrapezoid, int kChannels>
HWY_NOINLINE void Composite<kVoxels, kTrapezoid, kChannels>::leap_on(I distance) {
  const DI d;
  MI here = hn::Gt(distance, hn::Zero(d));
  if (kTrapezoid) close_before_leap(here);
  here = hn::And(here, alive_);
  const MI leaps = here;
  while (!hn::AllFalse(d, here)) {
    const I nodes = hn::IfThenElseZero(here, leaps_.nodes_inside(path_.position, distance));
    const I next = hn::Min(hn::Add(path_.node, nodes), segments_);
    const MI ends = hn::And(here, hn::Not(hn::Lt(next, segments_)));
    skipped_ = hn::Add(skipped_, hn::Sub(next, path_.node));
    // A lane that reaches the end stays where it is: the last node has a place of its own.
    here = hn::AndNot(ends, here);
    advance(path_.position, scaled(step_, hn::IfThenElseZero(here, nodes)));
    path_.node = next;
    if (!kTrapezoid) alive_ = hn::AndNot(ends, alive_);
    distance = visible_distance(job_, rays_.distances, path_.position);
    here = hn::And(here, hn::Gt(distance, hn::Zero(d)));
  }
  const MI goes_on = hn::And(hn::And(leaps, alive_), hn::Lt(path_.node, segments_));
  if (!indexed_) {
    const I back = hn::IfThenElseZero(goes_on, hn::And(path_.node, constant_i(kRun - 1)));
    retreat(path_.position, scaled(step_, back));
    path_.node = hn::Sub(path_.node, back);
    skipped_ = hn::Sub(skipped_, back);
  }
  if constexpr (kTrapezoid) {
    // The node before is invisible: it counts without being sampled.
    const M m = float_mask(leaps);
    path_.left_node = hn::IfThenElse(leaps, hn::Sub(path_.node, constant_i(1)), path_.left_node);
    path_.left.y = hn::IfThenElse(m, constant(0.0F), path_.left.y);
    for (int c = 0; c < kChannels; ++c)
      path_.left.yq[c] = hn::IfThenElse(m, constant(0.0F), path_.left.yq[c]);
    left_length_ =
        hn::IfThenElse(m, hn::IfThenElse(float_mask(goes_on), constant(1.0F), remainder_), left_length_);
    fresh_ = hn::AndNot(leaps, fresh_);
  }
}

/// The last segment, shorter than the others.
template <PacketVoxels kVoxels, bool kTrapezoid, int kChannels>
void Composite<kVoxels, kTrapezoid, kChannels>::finish() {
  MI active = alive_;
  if (kTrapezoid) {
    const MI needless = hn::And(end_invisible_, int_mask(hn::Eq(path_.left.y, hn::Zero(DF()))));
    skipped_ = hn::Add(skipped_, hn::IfThenElseZero(hn::And(active, needless), constant_i(1)));
    active = hn::AndNot(needless, active);
  } else if (rays_.distances) {
    const MI needless =
        hn::And(active, hn::Gt(visible_distance(job_, rays_.distances, path_.position), hn::Zero(DI())));
    skipped_ = hn::Add(skipped_, hn::IfThenElseZero(needless, constant_i(1)));
    active = hn::AndNot(needless, active);
  }
  if (hn::AllFalse(DI(), active)) return;
  const Position end = kTrapezoid ? load(rays_.exit_whole, rays_.exit_part) : path_.position;
  const Lights<kChannels> node = sample(end);
  if (job_.shaded) count_gradients(node, active, path_.transmittance);
  F length = remainder_;
  if (kTrapezoid && indexed_) length = left_length_;
  segment(path_, node, hn::IfThenElseZero(float_mask(active), length));
  samples_ = hn::Add(samples_, hn::IfThenElseZero(active, constant_i(1)));
}

template <PacketVoxels kVoxels, bool kTrapezoid, int kChannels>
void Composite<kVoxels, kTrapezoid, kChannels>::store(PacketPixels& pixels) const {
  store_colour<kChannels>(job_.transfer, path_.sum, path_.transmittance, pixels);
  halfway_.store(pixels);
  store_counts(samples_, skipped_, gradients_, stopped_, pixels);
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
