// Included once per instruction set by packet_split_kernel.cpp.
#if defined(VOL_RENDER_PACKET_WALK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_WALK_INL_H_
#undef VOL_RENDER_PACKET_WALK_INL_H_
#else
#define VOL_RENDER_PACKET_WALK_INL_H_
#endif

#include "render/packet_sampling-inl.h"

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

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
