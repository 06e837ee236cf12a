// Included once per instruction set by packet_split_kernel.cpp.
#if defined(VOL_RENDER_PACKET_SPLIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_SPLIT_INL_H_
#undef VOL_RENDER_PACKET_SPLIT_INL_H_
#else
#define VOL_RENDER_PACKET_SPLIT_INL_H_
#endif

#include <limits>

#include "render/packet_path-inl.h"
#include "render/packet_pieces-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// Rays on their way from cell to cell: whole cells, the place inside as floats. A ray that crosses a face is
/// set on it exactly, so that its rounding does not add up;
/// the others gather half an ulp a cell (6e-8 voxel).
class CellWalk {
 public:
  CellWalk(const PacketJob& job, const PacketRays& rays) {
    const Position entry = load(rays.entry_whole, rays.entry_part);
    const Position step = load(rays.step_whole, rays.step_part);
    const I wholes[] = {step.whole0, step.whole1, step.whole2},
            parts[] = {step.part0, step.part1, step.part2};
    cell_[0] = entry.whole0, cell_[1] = entry.whole1, cell_[2] = entry.whole2;
    at_[0] = fraction(entry.part0), at_[1] = fraction(entry.part1), at_[2] = fraction(entry.part2);
    for (int a = 0; a < 3; ++a) {
      along_[a] = hn::Add(to_float(wholes[a]), fraction(parts[a]));
      up_[a] = hn::Gt(along_[a], constant(0.0F));
      still_[a] = hn::Eq(along_[a], constant(0.0F));
      pace_[a] = hn::Div(constant(1.0F), hn::Max(hn::Abs(along_[a]), constant(1e-20F)));
      last_[a] = constant_i(job.last_cell[a]);
    }
  }

  /// Of the next face: steps to it, by axis and the least.
  struct Faces {
    F exit[3], nearest;
  };
  HWY_INLINE Faces faces() const {
    Faces f;
    for (int a = 0; a < 3; ++a) {
      const F way = hn::IfThenElse(up_[a], hn::Sub(constant(1.0F), at_[a]), at_[a]);
      f.exit[a] = hn::IfThenElse(still_[a], constant(1e30F), hn::Mul(way, pace_[a]));
    }
    f.nearest = hn::Min(f.exit[0], hn::Min(f.exit[1], f.exit[2]));
    return f;
  }

  /// Into the next cell, for the lanes of `m`; returns those that leave the grid.
  HWY_INLINE MI cross(const Faces& f, MI m) {
    MI out = hn::Lt(hn::Zero(DI()), hn::Zero(DI()));
    const M moving = float_mask(m);
    for (int a = 0; a < 3; ++a) {
      const M crosses = hn::And(moving, hn::Le(f.exit[a], f.nearest));
      const F on = hn::IfThenElseZero(hn::Not(up_[a]), constant(1.0F));
      const F inside =
          hn::Min(hn::Max(hn::MulAdd(f.nearest, along_[a], at_[a]), hn::Zero(DF())), constant(1.0F));
      at_[a] = hn::IfThenElse(crosses, on, hn::IfThenElse(moving, inside, at_[a]));
      const I side = hn::IfThenElse(int_mask(up_[a]), constant_i(1), constant_i(-1));
      cell_[a] = hn::Add(cell_[a], hn::IfThenElseZero(int_mask(crosses), side));
      out = hn::Or(out, hn::Or(hn::Lt(cell_[a], hn::Zero(DI())), hn::Gt(cell_[a], last_[a])));
    }
    out = hn::And(out, m);
    for (int a = 0; a < 3; ++a) cell_[a] = hn::Min(hn::Max(cell_[a], hn::Zero(DI())), last_[a]);
    return out;
  }

  /// Steps that stay within macrocells less than `distance` away, by a margin of 1e-4 voxel.
  HWY_INLINE F room(I distance) const {
    constexpr std::int32_t kEdge = ::vol::index::Macrocells::kEdge;
    const F reach = to_float(hn::Mul(distance, constant_i(kEdge)));
    F least = constant(1e30F);
    for (int a = 0; a < 3; ++a) {
      const F local = hn::Add(to_float(hn::And(cell_[a], constant_i(kEdge - 1))), at_[a]);
      const F way = hn::IfThenElse(up_[a], hn::Sub(reach, local),
                                   hn::Add(local, hn::Sub(reach, constant(float(kEdge)))));
      const F steps = hn::Mul(hn::MulSub(way, constant(1 - 1e-6F), constant(1e-4F)), pace_[a]);
      least = hn::Min(least, hn::IfThenElse(still_[a], constant(1e30F), steps));
    }
    return least;
  }

  /// `length` steps on, any number of cells, for the lanes of `m`; returns those that leave the grid.
  HWY_INLINE MI jump(F length, MI m) {
    MI out = hn::Lt(hn::Zero(DI()), hn::Zero(DI()));
    for (int a = 0; a < 3; ++a) {
      const F there = hn::MulAdd(length, along_[a], at_[a]);
      const F whole = hn::Floor(there);
      at_[a] = hn::IfThenElse(float_mask(m), hn::Sub(there, whole), at_[a]);
      cell_[a] = hn::Add(cell_[a], hn::IfThenElseZero(m, truncated(whole)));
      out = hn::Or(out, hn::Or(hn::Lt(cell_[a], hn::Zero(DI())), hn::Gt(cell_[a], last_[a])));
      cell_[a] = hn::Min(hn::Max(cell_[a], hn::Zero(DI())), last_[a]);
    }
    return hn::And(out, m);
  }

  [[nodiscard]] HWY_INLINE Position cell() const {
    return {cell_[0], cell_[1], cell_[2], hn::Zero(DI()), hn::Zero(DI()), hn::Zero(DI())};
  }
  [[nodiscard]] HWY_INLINE F at(int a) const { return at_[a]; }
  [[nodiscard]] HWY_INLINE F along(int a) const { return along_[a]; }

 private:
  I cell_[3], last_[3];
  F at_[3], along_[3], pace_[3];
  M up_[3], still_[3];
};

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
  const F a = hn::Mul(constant(3.0F), p.c[3]), b = p.c[2], c = p.c[1];  // a s^2 + 2 b s + c
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
  for (int i = 0; i < 4; ++i) {
    const F over = hn::Sub(p(s), value);
    const M before = hn::Xor(hn::Gt(over, constant(0.0F)), rising);  // the crossing lies behind s
    lo = hn::IfThenElse(before, s, lo);
    hi = hn::IfThenElse(before, hi, s);
    const F slope = p.slope(s);
    const F next =
        hn::Sub(s, hn::Div(over, hn::IfThenElse(hn::Eq(slope, constant(0.0F)), constant(1e-30F), slope)));
    const M good = hn::And(hn::Ge(next, lo), hn::Le(next, hi));
    s = hn::IfThenElse(good, next, hn::Mul(constant(0.5F), hn::Add(lo, hi)));
  }
  return s;
}

/// A packet cell by cell: in each, the cubic along the ray is cut where it crosses the transfer function's
/// points (and `cuts` of packet_transfer.h), and its smooth pieces are integrated by kNodes Gauss nodes
/// (after Weiss and Westermann 2021).
template <PacketVoxels kVoxels, int kChannels, int kNodes>
class Split {
 public:
  Split(const PacketJob& job, const PacketRays& rays) : job_(job), walk_(job, rays) {
    const DI d;
    alive_ = hn::Gt(hn::Load(d, rays.segments), hn::Zero(d));
    stopped_ = hn::Lt(hn::Zero(d), hn::Zero(d));
    samples_ = skipped_ = gradients_ = hn::Zero(d);
    passed_ = hn::Zero(DF());
    halfway_.begin(alive_);
    path_.transmittance = constant(1.0F);
    for (int c = 0; c < kChannels; ++c) path_.sum[c] = hn::Zero(DF());
    for (int a = 0; a < 3; ++a) ray_[a] = job.shaded ? hn::Load(DF(), rays.direction[a]) : hn::Zero(DF());
  }

  void cast(PacketPixels& pixels) {
    while (!hn::AllFalse(DI(), alive_)) {
      if (job_.distances) leave_empty_space();
      if (hn::AllFalse(DI(), alive_)) break;
      pass_cell();
    }
    store(pixels);
  }

 private:
  HWY_INLINE void leave_empty_space() {
    const DI d;
    for (;;) {
      const I distance = hn::IfThenElseZero(alive_, visible_distance(job_, walk_.cell()));
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
    pass_cubic(p, hn::IfThenElseZero(float_mask(alive_), faces.nearest), [&](F s, F* q) HWY_ATTR {
      if constexpr (kChannels == 3) {
        if (job_.shaded) {
          sampler.x = hn::MulAdd(s, way[0], at[0]);
          sampler.y = hn::MulAdd(s, way[1], at[1]);
          sampler.z = hn::MulAdd(s, way[2], at[2]);
          F gx, gy, gz, diffuse, specular;
          sampler.gradient(gx, gy, gz);
          blinn_phong(job_, gx, gy, gz, ray_, diffuse, specular);
          for (int c = 0; c < 3; ++c) q[c] = hn::MulAdd(q[c], diffuse, specular);
        }
      }
    });
    passed_ = hn::Add(passed_, faces.nearest);
    const MI out = walk_.cross(faces, alive_);
    alive_ = hn::AndNot(out, alive_);
    const MI stopped = hn::And(alive_, int_mask(hn::Le(path_.transmittance, constant(job_.termination))));
    alive_ = hn::AndNot(stopped, alive_);
    stopped_ = hn::Or(stopped_, stopped);
  }

  /// The whole of a cell, `length` steps (0: nothing happens).
  template <class Shade>
  HWY_INLINE void pass_cubic(const Cubic& p, F length, const Shade& shade) {
    const PacketTransfer& t = job_.transfer;
    F lo, hi;
    hull(p, lo, hi);
    const I lowest = interval_of(t, lo), highest = interval_of(t, hi);
    const M some = hn::Gt(length, constant(0.0F));
    const M whole = hn::Or(hn::Not(some), float_mask(hn::Eq(lowest, highest)));
    const F clarity = hn::GatherIndex(DF(), t.clarity.data(), lowest);
    if (HWY_LIKELY(hn::AllTrue(DF(), hn::And(whole, hn::Or(hn::Not(some), hn::Ge(clarity, length)))))) {
      const M seen = hn::And(some, hn::Lt(clarity, constant(1e29F)));
      if (hn::AllFalse(DF(), seen)) return;
      piece(p, hn::Zero(DF()), constant(1.0F), length, seen, shade);
    } else {
      pass_in_pieces(p, length, shade);
    }
  }

  /// From `from` to `to` of a cell `length` steps long, for the lanes of `seen`.
  template <class Shade>
  HWY_INLINE void piece(const Cubic& p, F from, F to, F length, M seen, const Shade& shade) {
    F nodes[kNodes], values[kNodes];
    const F width = hn::Sub(to, from);
    for (int i = 0; i < kNodes; ++i) {
      nodes[i] = hn::MulAdd(constant(Gauss<kNodes>::node[i]), width, from);
      values[i] = p(nodes[i]);
    }
    const I evaluated = hn::IfThenElseZero(int_mask(seen), constant_i(kNodes));
    samples_ = hn::Add(samples_, evaluated);
    if (job_.shaded) gradients_ = hn::Add(gradients_, evaluated);
    const F before = path_.transmittance, stretch = hn::IfThenElseZero(seen, hn::Mul(width, length));
    const F depth = pass_piece<kNodes>(
        job_.transfer, values, stretch, [&](int i, F* q) HWY_ATTR { shade(nodes[i], q); }, path_);
    const F start = hn::MulAdd(from, length, passed_);
    const I node = truncated(start);
    halfway_.pass(node, hn::Sub(start, to_float(node)), before, path_.transmittance, depth, stretch);
  }

  template <class Shade>
  HWY_NOINLINE void pass_in_pieces(const Cubic& p, F length, const Shade& shade) {
    const PacketTransfer& t = job_.transfer;
    const F one = constant(1.0F);
    const F per_length = hn::Div(one, hn::Max(length, constant(1e-20F)));
    F turn, second;
    turns(p, turn, second);
    F from = hn::IfThenElseZero(hn::Not(hn::Gt(length, constant(0.0F))), one);
    F value = p.c[0];
    I k = interval_of(t, value);
    do {
      // The next stretch on which the cubic is monotone.
      const F end = hn::IfThenElse(hn::Lt(from, turn), hn::Min(turn, one),
                                   hn::IfThenElse(hn::Lt(from, second), hn::Min(second, one), one));
      const F value_end = p(end);
      const M open = hn::Lt(from, one);
      const F upper = hn::GatherIndex(DF(), t.cuts.data(), k);
      const F beneath =
          hn::GatherIndex(DF(), t.cuts.data(), hn::Max(hn::Sub(k, constant_i(1)), hn::Zero(DI())));
      const F lower = hn::IfThenElse(float_mask(hn::Eq(k, hn::Zero(DI()))),
                                     constant(-std::numeric_limits<float>::infinity()), beneath);
      const M rises = hn::Ge(value_end, upper), falls = hn::Lt(value_end, lower);
      const M cuts = hn::Or(rises, falls);
      const F cut = hn::IfThenElse(rises, upper, lower);
      F to = end;
      if (!hn::AllFalse(DF(), cuts)) {
        const F place = crossing(p, from, end, value, value_end, hn::IfThenElse(cuts, cut, value));
        to = hn::IfThenElse(cuts, place, end);
      }
      const F clarity = hn::GatherIndex(DF(), t.clarity.data(), k);
      const F reach = hn::MulAdd(clarity, per_length, from);
      const M capped = hn::Lt(reach, to);
      to = hn::IfThenElse(capped, reach, to);
      const F width = hn::Sub(to, from);
      const M seen = hn::And(hn::Gt(width, constant(0.0F)), hn::Lt(clarity, constant(1e29F)));
      if (!hn::AllFalse(DF(), seen)) {
        piece(p, from, to, length, seen, shade);
      }
      const I beside = hn::IfThenElse(int_mask(rises), constant_i(1), constant_i(-1));
      k = hn::Add(k, hn::IfThenElseZero(int_mask(hn::And(open, hn::AndNot(capped, cuts))), beside));
      value = hn::IfThenElse(hn::AndNot(capped, cuts), cut, hn::IfThenElse(capped, p(to), value_end));
      from = to;
      // What lies behind nothing is seen through is left out.
    } while (!hn::AllFalse(DF(), hn::And(hn::Lt(from, one), hn::Gt(path_.transmittance, constant(0.0F)))));
  }

  void store(PacketPixels& pixels) const {
    store_colour<kChannels>(job_.transfer, path_.sum, path_.transmittance, pixels);
    halfway_.store(pixels);
    store_counts(samples_, skipped_, gradients_, stopped_, pixels);
  }

  const PacketJob& job_;
  CellWalk walk_;
  Gathered<kChannels> path_;
  Halfway halfway_;
  I samples_, skipped_, gradients_;
  F passed_;  // steps from the entry
  F ray_[3];
  MI alive_, stopped_;
};

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
