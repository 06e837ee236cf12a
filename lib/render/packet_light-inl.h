// Included once per instruction set by packet_split_kernel.cpp.
#if defined(VOL_RENDER_PACKET_LIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_LIGHT_INL_H_
#undef VOL_RENDER_PACKET_LIGHT_INL_H_
#else
#define VOL_RENDER_PACKET_LIGHT_INL_H_
#endif

#include "render/packet_optics-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

/// Lighting along a ray's way through a cell, by the place s in [0,1] of that way.
template <PacketVoxels kVoxels>
class CellLight {
 public:
  HWY_INLINE CellLight(const PacketJob& job, const Sampler<kVoxels>& corners, const F* at, const F* way,
                       const F* ray)
      : job_(job), sampler_(corners), at_(at), way_(way), ray_(ray) {}

  /// Lights the colour q of a point.
  HWY_INLINE void shade(F s, F* q) {
    if (!job_.shaded) return;
    F gx, gy, gz, diffuse, specular;
    gradient(s, gx, gy, gz);
    blinn_phong(job_, gx, gy, gz, ray_, diffuse, specular);
    for (int c = 0; c < 3; ++c) q[c] = hn::MulAdd(q[c], diffuse, specular);
  }

  /// Whether the normal turns between the ends and the middle of a stretch by more than nodes see. Where a
  /// ray passes a point of no gradient the normal flips within an arbitrarily short way, and both of its
  /// sides are lit alike.
  HWY_INLINE M turns(F from, F to) {
    const F middle = hn::Mul(constant(0.5F), hn::Add(from, to));
    F n0[3], n1[3], n2[3];
    normal(from, n0);
    normal(middle, n1);
    normal(to, n2);
    const F cosine = hn::Min(cosine_between(n0, n1), cosine_between(n1, n2));
    const M turns = hn::Lt(cosine, constant(job_.steady));
    return job_.headlight ? turns : hn::Or(turns, hn::Or(sides(n0, n1), sides(n1, n2)));
  }

 private:
  /// Whether the light falls on different sides.
  HWY_INLINE M sides(const F* a, const F* b) const {
    const auto on = [&](const F* n) HWY_ATTR {
      return hn::MulAdd(n[0], constant(job_.light[0]),
                        hn::MulAdd(n[1], constant(job_.light[1]), hn::Mul(n[2], constant(job_.light[2]))));
    };
    return hn::Lt(hn::Mul(on(a), on(b)), constant(0.0F));
  }

  HWY_INLINE void gradient(F s, F& gx, F& gy, F& gz) {
    sampler_.x = hn::MulAdd(s, way_[0], at_[0]);
    sampler_.y = hn::MulAdd(s, way_[1], at_[1]);
    sampler_.z = hn::MulAdd(s, way_[2], at_[2]);
    sampler_.gradient(gx, gy, gz);
  }

  /// Of length 1, or 0 where the gradient is 0.
  HWY_INLINE void normal(F s, F* n) {
    F gx, gy, gz;
    gradient(s, gx, gy, gz);
    to_world(job_, gx, gy, gz, n);
    const F most = hn::Max(hn::Abs(n[0]), hn::Max(hn::Abs(n[1]), hn::Abs(n[2])));
    const F down = hn::Div(constant(1.0F), hn::Max(most, constant(1e-37F)));
    for (int r = 0; r < 3; ++r) n[r] = hn::Mul(n[r], down);
    const F square = hn::MulAdd(n[0], n[0], hn::MulAdd(n[1], n[1], hn::Mul(n[2], n[2])));
    const F unit = hn::Div(constant(1.0F), hn::Sqrt(hn::Max(square, constant(1e-30F))));
    for (int r = 0; r < 3; ++r) n[r] = hn::Mul(n[r], unit);
  }

  /// 1 where neither has a direction, 0 where one has.
  static HWY_INLINE F cosine_between(const F* a, const F* b) {
    const F dot = hn::MulAdd(a[0], b[0], hn::MulAdd(a[1], b[1], hn::Mul(a[2], b[2])));
    const auto square = [](const F* v) HWY_ATTR {
      return hn::MulAdd(v[0], v[0], hn::MulAdd(v[1], v[1], hn::Mul(v[2], v[2])));
    };
    const M flat = hn::Lt(hn::Max(square(a), square(b)), constant(0.5F));
    return hn::IfThenElse(flat, constant(1.0F), dot);
  }

  const PacketJob& job_;
  Sampler<kVoxels> sampler_;
  const F* at_;
  const F* way_;
  const F* ray_;
};

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
