// Rays of a packet, made in double vectors: compiled once for each instruction set and chosen when the
// program runs. The order of operations is that of camera::Camera::ray, RayBox::chord and
// PacketRayMaker::make_plain, one rounding apart at most.
#include "render/packet_rays.h"
// The targets come before Highway:
#include "render/packet_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/packet_rays_kernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file again:
#include <hwy/highway.h>

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DD = hn::ScalableTag<double>;
using D = hn::Vec<DD>;
using MD = hn::Mask<DD>;
using Whole = hn::Rebind<std::int32_t, DD>;
using Single = hn::Rebind<float, DD>;

HWY_INLINE D number(double v) {
  return hn::Set(DD(), v);
}

/// Row `a` of a matrix times a vector, summed as Eigen does.
HWY_INLINE D row_times(const double (&m)[9], int a, const D (&v)[3]) {
  const D x = hn::Mul(number(m[3 * a]), v[0]), y = hn::Mul(number(m[3 * a + 1]), v[1]),
          z = hn::Mul(number(m[3 * a + 2]), v[2]);
  return hn::Add(hn::Add(x, y), z);
}

HWY_INLINE D clamped(D v, D low, D high) {
  return hn::Min(hn::Max(v, low), high);
}

/// An integer in fixed point as its two words. Exact up to 2^61 in magnitude, the longest step: beyond 2^53 a
/// double is a multiple of its last digit, and so are its words.
HWY_INLINE void store_fixed(D fixed, std::int32_t* whole, std::int32_t* part) {
  const D units = hn::Floor(hn::Mul(fixed, number(1 / kOne)));
  hn::Store(hn::DemoteTo(Whole(), units), Whole(), whole);
  hn::Store(hn::DemoteTo(Whole(), hn::Sub(fixed, hn::Mul(units, number(kOne)))), Whole(), part);
}

struct Lines {
  D origin[3], direction[3];
};

HWY_INLINE Lines lines(const PacketView& view, D x, D y) {
  const D w = number(view.image_width), half = number(0.5);
  const D u = hn::Mul(hn::Sub(hn::Div(hn::Add(x, half), w), half), number(view.width));
  const D v =
      hn::Mul(hn::Div(hn::Sub(number(0.5 * view.image_height), hn::Add(y, half)), w), number(view.width));
  Lines lines;
  for (int a = 0; a < 3; ++a) {
    const D offset = hn::Add(hn::Mul(u, number(view.right[a])), hn::Mul(v, number(view.up[a])));
    if (view.perspective) {
      lines.origin[a] = number(view.eye[a]);
      lines.direction[a] = hn::Add(number(view.distance * view.direction[a]), offset);
    } else {
      lines.origin[a] = hn::Add(number(view.eye[a]), offset);
      lines.direction[a] = number(view.direction[a]);
    }
  }
  if (view.perspective) {
    const D* d = lines.direction;
    const D squares = hn::Add(hn::Add(hn::Mul(d[0], d[0]), hn::Mul(d[1], d[1])), hn::Mul(d[2], d[2]));
    const D length = hn::Sqrt(squares);
    for (D& component : lines.direction) component = hn::Div(component, length);
  }
  return lines;
}

/// By slabs, as RayBox::chord. \returns which lanes meet the box
HWY_INLINE MD chord(const PacketView& view, const Lines& lines, D& entry, D& exit) {
  const D zero = number(0), one = number(1), infinity = number(std::numeric_limits<double>::infinity());
  D from_corner[3];
  for (int a = 0; a < 3; ++a) from_corner[a] = hn::Sub(lines.origin[a], number(view.corner[a]));
  entry = number(view.t_min);
  exit = infinity;
  MD misses = hn::Lt(one, zero);
  for (int a = 0; a < 3; ++a) {
    const D o = row_times(view.to_box, a, from_corner), d = row_times(view.to_box, a, lines.direction);
    const MD parallel = hn::Eq(d, zero);
    misses = hn::Or(misses, hn::And(parallel, hn::Or(hn::Lt(o, zero), hn::Gt(o, one))));
    const D near = hn::Div(hn::Neg(o), d), far = hn::Div(hn::Sub(one, o), d);
    entry = hn::IfThenElse(parallel, entry, hn::Max(entry, hn::Min(near, far)));
    exit = hn::IfThenElse(parallel, exit, hn::Min(exit, hn::Max(near, far)));
  }
  return hn::AndNot(misses, hn::Gt(exit, entry));
}

HWY_INLINE void some_rays(const PacketView& view, D x, D y, int lane, PacketRays& rays,
                          PacketChords& chords) {
  const DD d;
  const D zero = number(0), one = number(1);
  const Lines rays_here = lines(view, x, y);
  D entry, exit;
  const MD hit = chord(view, rays_here, entry, exit);
  hn::Store(entry, d, chords.entry + lane);
  hn::Store(exit, d, chords.exit + lane);
  const D steps = hn::Div(hn::Sub(exit, entry), number(view.step));
  D segments = clamped(hn::Ceil(hn::Sub(steps, number(1e-9))), one, number(kMostSegments));
  D from_origin[3];
  for (int a = 0; a < 3; ++a) from_origin[a] = hn::Sub(rays_here.origin[a], number(view.origin[a]));
  for (int a = 0; a < 3; ++a) {
    D first = zero, last = zero, step = zero;
    if (view.last[a] > 0) {
      const D top = number(view.last[a] * kOne - 1);
      const D start = row_times(view.to_index, a, from_origin),
              along = row_times(view.to_index, a, rays_here.direction);
      const auto fixed = [&](D t) {
        return hn::Floor(clamped(hn::Mul(hn::Add(start, hn::Mul(t, along)), number(kOne)), zero, top));
      };
      first = hn::IfThenElseZero(hit, fixed(entry));
      last = hn::IfThenElseZero(hit, fixed(exit));
      const D exact = hn::Mul(hn::Mul(along, number(view.step)), number(kOne));
      step = hn::IfThenElseZero(hit, hn::Trunc(clamped(exact, number(-kFar), number(kFar))));
      // Should rounding carry the last lattice node across the face, it is left out.
      for (;;) {
        const D node = hn::Add(first, hn::Mul(hn::Sub(segments, one), step));
        const MD outside = hn::And(hn::Gt(segments, one), hn::Or(hn::Lt(node, zero), hn::Gt(node, top)));
        if (HWY_LIKELY(hn::AllFalse(d, outside))) break;
        segments = hn::Sub(segments, hn::IfThenElseZero(outside, one));
      }
    }
    store_fixed(first, rays.entry_whole[a] + lane, rays.entry_part[a] + lane);
    store_fixed(last, rays.exit_whole[a] + lane, rays.exit_part[a] + lane);
    store_fixed(step, rays.step_whole[a] + lane, rays.step_part[a] + lane);
    hn::Store(hn::DemoteTo(Single(), hn::IfThenElseZero(hit, rays_here.direction[a])), Single(),
              rays.direction[a] + lane);
  }
  hn::Store(hn::DemoteTo(Whole(), hn::IfThenElseZero(hit, segments)), Whole(), rays.segments + lane);
  hn::Store(hn::DemoteTo(Single(), hn::IfThenElseZero(hit, hn::Sub(steps, hn::Sub(segments, one)))), Single(),
            rays.remainder + lane);
  hn::Store(hn::Zero(Whole()), Whole(), rays.first_level + lane);
}

void rays_of_packet(const PacketView& view, const std::int32_t* x, const std::int32_t* y, PacketRays& rays,
                    PacketChords& chords) {
  const int lanes = static_cast<int>(hn::Lanes(hn::ScalableTag<float>()));
  for (int lane = 0; lane < lanes; lane += static_cast<int>(hn::Lanes(DD()))) {
    some_rays(view, hn::PromoteTo(DD(), hn::Load(Whole(), x + lane)),
              hn::PromoteTo(DD(), hn::Load(Whole(), y + lane)), lane, rays, chords);
  }
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::render {

HWY_EXPORT(rays_of_packet);

void make_rays(const PacketView& view, const std::int32_t* x, const std::int32_t* y, PacketRays& rays,
               PacketChords& chords) {
  HWY_DYNAMIC_DISPATCH(rays_of_packet)(view, x, y, rays, chords);
}

}  // namespace vol::render
#endif
