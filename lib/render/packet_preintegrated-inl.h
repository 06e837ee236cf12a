// Included once per instruction set by packet_kernel.cpp.
#if defined(VOL_RENDER_PACKET_PREINTEGRATED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_PREINTEGRATED_INL_H_
#undef VOL_RENDER_PACKET_PREINTEGRATED_INL_H_
#else
#define VOL_RENDER_PACKET_PREINTEGRATED_INL_H_
#endif

#include "render/packet_path-inl.h"
#include "render/packet_pieces-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// A packet whose segments take the field as linear between their nodes: each is cut where the field crosses
/// the transfer function's points, and its pieces are integrated by Gauss rules.
///
/// Values between two nodes matter even where both are invisible, so a segment is left out only if both its
/// nodes lie in invisible macrocells that touch: then the values between theirs are invisible too. A ray that
/// leaves empty space starts anew (`fresh_`) from the last node inside it.
template <PacketVoxels kVoxels, int kChannels>
class Preintegrated {
 public:
  Preintegrated(const PacketJob& job, const PacketRays& rays)
      : job_(job), rays_(rays), indexed_(job.nibbles != nullptr) {
    const DI d;
    segments_ = hn::Load(d, rays.segments);
    remainder_ = hn::Load(DF(), rays.remainder);
    position_ = load(rays.entry_whole, rays.entry_part);
    step_ = load(rays.step_whole, rays.step_part);
    node_ = left_node_ = samples_ = skipped_ = gradients_ = hn::Zero(d);
    alive_ = hn::Gt(segments_, hn::Zero(d));
    fresh_ = alive_;
    left_invisible_ = end_invisible_ = stopped_ = hn::Lt(segments_, hn::Zero(d));
    halfway_.begin(alive_);
    path_.transmittance = constant(1.0F);
    for (int c = 0; c < kChannels; ++c) path_.sum[c] = hn::Zero(DF());
    left_length_ = hn::Zero(DF());
    left_ = {hn::Zero(DF()), hn::Zero(d), hn::Zero(DF()), hn::Zero(DF())};
    for (int a = 0; a < 3; ++a) ray_[a] = job.shaded ? hn::Load(DF(), rays.direction[a]) : hn::Zero(DF());
    if (rays.distances) {
      end_invisible_ =
          hn::Gt(visible_distance(job, rays.distances, load(rays.exit_whole, rays.exit_part)), hn::Zero(d));
      leaps_.prepare(step_);
    }
  }

  void cast(PacketPixels& pixels) {
    for (;;) {
      const MI active = hn::And(alive_, hn::Lt(node_, segments_));
      if (hn::AllFalse(DI(), active)) break;
      run(active);
    }
    finish();
    store(pixels);
  }

 private:
  struct Node {
    F value;
    I interval;
    F diffuse, specular;
  };

  HWY_INLINE F ahead(I node) const { return length_ahead(node, segments_, remainder_); }

  HWY_INLINE Node sample(const Position& p) {
    Sampler<kVoxels> sampler;
    Node node;
    node.value = sampler.value(job_, p);
    node.interval = interval_of(job_.transfer, node.value);
    node.diffuse = constant(1.0F);
    node.specular = hn::Zero(DF());
    if (kChannels == 3 && job_.shaded) {
      F gx, gy, gz;
      sampler.gradient(gx, gy, gz);
      blinn_phong(job_, gx, gy, gz, ray_, node.diffuse, node.specular);
    }
    return node;
  }

  /// One node of every active lane, and the segment that it closes.
  HWY_INLINE void run(MI active) {
    MI invisible = hn::Lt(segments_, hn::Zero(DI()));
    if (rays_.distances) {
      const I distance = hn::IfThenElseZero(active, visible_distance(job_, rays_.distances, position_));
      invisible = hn::Gt(distance, hn::Zero(DI()));
      const MI leaps = hn::And(invisible, hn::Or(fresh_, left_invisible_));
      if (!hn::AllFalse(DI(), leaps)) {
        leap(leaps, distance);
        active = hn::And(active, alive_);
      }
    }
    I nodes = hn::IfThenElseZero(active, constant_i(1));
    if (indexed_) {
      const I level = hn::IfThenElse(hn::Eq(node_, hn::Zero(DI())), hn::Load(DI(), rays_.first_level),
                                     index_level(job_, position_));
      // Inside empty space no entry counts.
      nodes = hn::IfThenElse(hn::AndNot(invisible, active), power_of_two(level), nodes);
    }
    const Node node = sample(position_);
    count(active);
    pass_segment(node, hn::IfThenElseZero(float_mask(hn::AndNot(fresh_, active)), left_length_));
    const M m = float_mask(active);
    left_.value = hn::IfThenElse(m, node.value, left_.value);
    left_.interval = hn::IfThenElse(active, node.interval, left_.interval);
    left_.diffuse = hn::IfThenElse(m, node.diffuse, left_.diffuse);
    left_.specular = hn::IfThenElse(m, node.specular, left_.specular);
    left_node_ = hn::IfThenElse(active, node_, left_node_);
    left_length_ = hn::IfThenElse(m, hn::Min(to_float(nodes), ahead(node_)), left_length_);
    left_invisible_ = hn::Or(hn::And(active, invisible), hn::AndNot(active, left_invisible_));
    fresh_ = hn::AndNot(active, fresh_);
    node_ = hn::Add(node_, hn::Min(nodes, hn::Sub(segments_, node_)));
    // A lane that reaches the end stays where it is: the last node has a place of its own.
    const MI goes_on = hn::And(active, hn::Lt(node_, segments_));
    advance(position_, indexed_ ? scaled(step_, hn::IfThenElseZero(goes_on, nodes)) : masked(step_, goes_on));
    stop();
  }

  HWY_INLINE void count(MI active) {
    const I ones = hn::IfThenElseZero(active, constant_i(1));
    samples_ = hn::Add(samples_, ones);
    if (job_.shaded) gradients_ = hn::Add(gradients_, ones);
  }

  HWY_INLINE void stop() {
    const MI stopped = hn::And(alive_, int_mask(hn::Le(path_.transmittance, constant(job_.termination))));
    alive_ = hn::AndNot(stopped, alive_);
    stopped_ = hn::Or(stopped_, stopped);
  }

  /// From the left node to `right`, `length` steps (0: nothing happens).
  HWY_INLINE void pass_segment(const Node& right, F length) {
    const PacketTransfer& t = job_.transfer;
    const F before = path_.transmittance;
    const F difference = hn::Sub(right.value, left_.value);
    const MI up = int_mask(hn::Gt(difference, constant(0.0F)));
    const F inverse = hn::Div(constant(1.0F),
                              hn::IfThenElse(hn::Eq(difference, constant(0.0F)), constant(1.0F), difference));
    const F diffuse = hn::Mul(constant(0.5F), hn::Add(left_.diffuse, right.diffuse));
    const F specular = hn::Mul(constant(0.5F), hn::Add(left_.specular, right.specular));
    const auto shade = [&](int, F* q) HWY_ATTR {
      if constexpr (kChannels == 3) {
        if (job_.shaded) {
          for (int c = 0; c < 3; ++c) q[c] = hn::MulAdd(q[c], diffuse, specular);
        }
      }
    };
    const F whole = constant(1.0F);
    // Lanes without a segment are at its end already.
    F from = hn::IfThenElseZero(hn::Eq(length, constant(0.0F)), whole);
    // A lane without a segment may have no left node: it stays where its right one is.
    I k = hn::IfThenElse(int_mask(hn::Eq(length, constant(0.0F))), right.interval, left_.interval);
    F depth = hn::Zero(DF());
    do {
      const MI last = hn::Eq(k, right.interval);
      const F cut = hn::IfThenElse(float_mask(up), cut_above(t, k), cut_beneath(t, k));
      F to = hn::Min(hn::Max(hn::Mul(hn::Sub(cut, left_.value), inverse), from), whole);
      to = hn::IfThenElse(float_mask(last), whole, to);
      const F clarity = clarity_of(t, k);
      const F reach = hn::MulAdd(clarity, reciprocal(hn::Max(length, constant(1e-20F))), from);
      const M capped = hn::Lt(reach, to);
      to = hn::IfThenElse(capped, reach, to);
      const F width = hn::Sub(to, from);
      const M seen = hn::And(hn::Gt(width, constant(0.0F)), hn::Lt(clarity, constant(1e29F)));
      if (!hn::AllFalse(DF(), seen)) {
        F values[3];
        for (int i = 0; i < 3; ++i) {
          values[i] =
              hn::MulAdd(difference, hn::MulAdd(constant(Gauss<3>::node[i]), width, from), left_.value);
        }
        depth = hn::Add(
            depth, pass_piece<3>(t, values, hn::IfThenElseZero(seen, hn::Mul(width, length)), shade, path_));
      }
      const I beside = hn::IfThenElse(up, constant_i(1), constant_i(-1));
      k = hn::IfThenElse(hn::Or(last, int_mask(capped)), k, hn::Add(k, beside));
      from = to;
    } while (!hn::AllFalse(DF(), hn::Lt(from, whole)));
    halfway_.pass(left_node_, hn::Zero(DF()), before, path_.transmittance, depth, length);
  }

  /// To the last node inside empty space, or the ray's last lattice node if it lies there too.
  HWY_NOINLINE void leap(MI here, I distance) {
    const DI d;
    const I start = node_, last = hn::Sub(segments_, constant_i(1));
    fresh_ = hn::Or(fresh_, here);
    MI landed = here;  // on the last lattice node, still in empty space
    while (!hn::AllFalse(d, here)) {
      const I next = hn::Min(hn::Add(node_, leaps_.nodes_inside(position_, distance)), last);
      advance(position_, scaled(step_, hn::IfThenElseZero(here, hn::Sub(next, node_))));
      node_ = hn::IfThenElse(here, next, node_);
      distance = visible_distance(job_, rays_.distances, position_);
      const MI inside = hn::Gt(distance, hn::Zero(d));
      const MI back = hn::AndNot(inside, here);
      landed = hn::AndNot(back, landed);
      retreat(position_, masked(step_, back));
      node_ = hn::Sub(node_, hn::IfThenElseZero(back, constant_i(1)));
      here = hn::And(hn::And(here, inside), hn::Lt(node_, last));
    }
    // Nothing is left of a ray whose last two nodes are invisible.
    const MI over = hn::And(hn::And(landed, hn::Eq(node_, last)), end_invisible_);
    alive_ = hn::AndNot(over, alive_);
    skipped_ = hn::Add(skipped_, hn::Add(hn::Sub(node_, start), hn::IfThenElseZero(over, constant_i(2))));
  }

  void finish() {
    const MI needless = hn::And(alive_, hn::And(end_invisible_, left_invisible_));
    skipped_ = hn::Add(skipped_, hn::IfThenElseZero(needless, constant_i(1)));
    const MI active = hn::AndNot(needless, alive_);
    if (hn::AllFalse(DI(), active)) return;
    const Node node = sample(load(rays_.exit_whole, rays_.exit_part));
    count(active);
    pass_segment(node, hn::IfThenElseZero(float_mask(active), left_length_));
  }

  void store(PacketPixels& pixels) const {
    store_colour<kChannels>(job_.transfer, path_.sum, path_.transmittance, pixels);
    halfway_.store(pixels);
    store_counts(samples_, skipped_, gradients_, stopped_, pixels);
  }

  const PacketJob& job_;
  const PacketRays& rays_;
  const bool indexed_;
  Gathered<kChannels> path_;
  Position position_, step_;
  Leaps leaps_;
  Halfway halfway_;
  Node left_;
  I segments_, node_, left_node_, samples_, skipped_, gradients_;
  F remainder_, left_length_;
  F ray_[3];
  MI alive_, fresh_, left_invisible_, end_invisible_, stopped_;
};

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
