// Included once per instruction set by the kernels.
#if defined(VOL_RENDER_PACKET_OPTICS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VOL_RENDER_PACKET_OPTICS_INL_H_
#undef VOL_RENDER_PACKET_OPTICS_INL_H_
#else
#define VOL_RENDER_PACKET_OPTICS_INL_H_
#endif

#include <bit>

#include "render/packet_job.h"
#include "render/packet_sampling-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

constexpr float kOpaque = -1e30F;  // y of an opaque node; finite, so that times 0 it is 0
constexpr float kOpaqueTest = -1e29F;

/// Optical properties of a node. y: log2 of the transmittance that the node contributes to a whole step (its
/// half of a trapezoid's, all of a rectangle's). yq: y times the colour; one channel, y u, where colour is
/// one unshaded line in u (the picture's colour is then colour0 A + colour1 sum), else three.
template <int kChannels>
struct Lights {
  F y;
  F yq[kChannels];
};

/// The world gradient from the one along the index axes.
HWY_INLINE void to_world(const PacketJob& job, F gx, F gy, F gz, F* n) {
  for (int r = 0; r < 3; ++r) {
    n[r] = hn::MulAdd(
        gx, constant(job.to_world[3 * r]),
        hn::MulAdd(gy, constant(job.to_world[3 * r + 1]), hn::Mul(gz, constant(job.to_world[3 * r + 2]))));
  }
}

/// Diffuse factor and highlight of Blinn-Phong (shading.h), from the gradient along the index axes.
HWY_INLINE void blinn_phong(const PacketJob& job, F gx, F gy, F gz, const F* ray, F& diffuse, F& specular) {
  F n[3];
  to_world(job, gx, gy, gz, n);
  const F n0 = n[0], n1 = n[1], n2 = n[2];
  const auto dot = [](F a0, F a1, F a2, F b0, F b1, F b2)
                       HWY_ATTR { return hn::MulAdd(a0, b0, hn::MulAdd(a1, b1, hn::Mul(a2, b2))); };
  // First scaled by a power of two, the largest component to [1, 4) (2^-22 on from denormal ones): squares
  // neither overflow nor vanish.
  const F most = hn::Max(hn::Abs(n0), hn::Max(hn::Abs(n1), hn::Abs(n2)));
  const M flat = hn::Not(hn::Gt(most, constant(0.0F)));
  const I exponent = hn::And(hn::BitCast(DI(), most), constant_i(0x7f800000));
  const F down =
      hn::BitCast(DF(), hn::Max(hn::Sub(constant_i(0x7f000000), exponent), constant_i(0x00800000)));
  const F m0 = hn::Mul(n0, down), m1 = hn::Mul(n1, down), m2 = hn::Mul(n2, down);
  const F unit = reciprocal_root(hn::Max(dot(m0, m1, m2, m0, m1, m2), constant(1e-30F)));
  F n_dot_l, n_dot_h;
  if (job.headlight) {  // L = V = H
    n_dot_l = n_dot_h = hn::Mul(hn::Abs(dot(m0, m1, m2, ray[0], ray[1], ray[2])), unit);
  } else {
    const F l0 = constant(job.light[0]), l1 = constant(job.light[1]), l2 = constant(job.light[2]);
    const F h0 = hn::Sub(l0, ray[0]), h1 = hn::Sub(l1, ray[1]), h2 = hn::Sub(l2, ray[2]);
    const F half = reciprocal_root(hn::Max(dot(h0, h1, h2, h0, h1, h2), constant(1e-30F)));
    n_dot_l = hn::Mul(hn::Abs(dot(m0, m1, m2, l0, l1, l2)), unit);
    n_dot_h = hn::Mul(hn::Mul(hn::Abs(dot(m0, m1, m2, h0, h1, h2)), half), unit);
  }
  diffuse = hn::MulAdd(constant(job.diffuse), n_dot_l, constant(job.ambient));
  const F logarithm = log2_positive(hn::Max(hn::Min(n_dot_h, constant(1.0F)), constant(1e-30F)));
  const F power = hn::Sub(constant(1.0F), one_minus_exp2(hn::Mul(logarithm, constant(job.exponent))));
  specular = hn::Mul(constant(job.specular), power);
  diffuse = hn::IfThenElse(flat, constant(job.ambient), diffuse);
  specular = hn::IfThenElse(flat, constant(0.0F), specular);
}

/// Of a table of pairs, those that are numbered. A pair is loaded as one number of 64 bits: half as many
/// loads as of its floats.
HWY_INLINE void load_pairs(const float* table, I pair, F& first, F& second) {
#if HWY_TARGET == HWY_SCALAR
  const I at = hn::Add(pair, pair);
  first = hn::GatherIndex(DF(), table, at);
  second = hn::GatherIndex(DF(), table + 1, at);
#else
  const hn::Repartition<std::int64_t, DF> wide;
  const hn::Half<DI> half;
  const auto* pairs = reinterpret_cast<const std::int64_t*>(table);
  const F low =
      hn::BitCast(DF(), hn::GatherIndex(wide, pairs, hn::PromoteTo(wide, hn::LowerHalf(half, pair))));
  const F high =
      hn::BitCast(DF(), hn::GatherIndex(wide, pairs, hn::PromoteTo(wide, hn::UpperHalf(half, pair))));
  first = hn::ConcatEven(DF(), high, low);
  second = hn::ConcatOdd(DF(), high, low);
#endif
}

/// a + slope w from a table of pairs {a, slope}.
HWY_INLINE F on_line(const float* table, I pair, F w) {
  F a, slope;
  load_pairs(table, pair, a, slope);
  return hn::MulAdd(slope, w, a);
}

/// Bucket coordinate of a value.
HWY_INLINE F table_coordinate(const PacketTransfer& t, F value) {
  const F u = hn::Mul(hn::Sub(value, constant(t.lo)), constant(t.scale));
  return hn::Min(hn::Max(u, constant(0.0F)), constant(t.last));
}

/// Whether a table of this many entries fits two registers.
HWY_INLINE bool in_registers(int entries) {
  return entries > 0 && entries <= 2 * static_cast<int>(hn::Lanes(DF()));
}

/// By lane, an entry of such a table of kMaxLanes numbers: no load waits for the value.
struct Entry {
  decltype(hn::IndicesFromVec(DF(), I())) lane;
  M second;  // in the second register, where one does not hold all
};
HWY_INLINE Entry entry(I number) {
  const I last = constant_i(static_cast<int>(hn::Lanes(DI())) - 1);
  return {hn::IndicesFromVec(DF(), hn::And(number, last)), float_mask(hn::Gt(number, last))};
}
HWY_INLINE F at(const float* table, const Entry& which) {
  const DF d;
  const F first = hn::TableLookupLanes(hn::Load(d, table), which.lane);
  if (hn::Lanes(d) == kMaxLanes) return first;
  const F second = hn::TableLookupLanes(hn::Load(d, table + hn::Lanes(d)), which.lane);
  return hn::IfThenElse(which.second, second, first);
}

/// The number of the piece a value lies in, of those that begin at from[k]: by halving. Behind the last piece
/// `from` is infinite, up to a power of two.
HWY_INLINE I piece_of(const float* from, int pieces, F value) {
  I piece = hn::Zero(DI());
  for (int half = static_cast<int>(std::bit_ceil(static_cast<unsigned>(pieces))) / 2; half > 0; half /= 2) {
    const I probe = hn::Or(piece, constant_i(half));
    piece = hn::IfThenElse(int_mask(hn::Ge(value, at(from, entry(probe)))), probe, piece);
  }
  return piece;
}

/// Where a value is looked up: a line of the tables, w from where its bucket begins.
struct TablePlace {
  F w;
  I line;
};
HWY_INLINE TablePlace table_place(const PacketTransfer& t, F value, F u) {
  TablePlace place;
  const F bucket = hn::Floor(u);
  place.w = hn::Sub(u, bucket);
  place.line = small_integer(bucket);
  if (t.split) {
    const F split = hn::GatherIndex(DF(), t.splits.data(), place.line);
    const I second = hn::Add(place.line, constant_i(t.buckets));
    place.line = hn::IfThenElse(int_mask(hn::Ge(value, split)), second, place.line);
  }
  return place;
}

/// The y of a node, from registers. Its rounding may leave it above 0, as that of the tables.
HWY_INLINE F extinction_of_few(const PacketTransfer& t, F value) {
  constexpr int kDegree = ExtinctionPiece::kDegree;
  const Entry piece = entry(piece_of(t.ramp_from, t.ramps, value));
  const F x = hn::Mul(hn::Sub(value, at(t.ramp_origin, piece)), constant(t.ramp_scale));
  F y = at(t.ramp[kDegree], piece);
  for (int j = kDegree - 1; j >= 0; --j) y = hn::MulAdd(y, x, at(t.ramp[j], piece));
  return hn::Min(y, constant(0.0F));
}

/// The y of a node, from the tables. A line's rounding may leave it above 0, beside a point between
/// transparent and not: light would be emitted without end there.
HWY_INLINE F extinction_at(const PacketTransfer& t, const TablePlace& place) {
  const F w = place.w;
  if (HWY_UNLIKELY(t.logarithm)) {
    const I two = hn::Add(place.line, place.line);
    const F opacity = on_line(t.extinctions.data(), two, w);
    // Below 0.9 the subtraction loses no digit that matters.
    const F clear = t.dense ? on_line(t.extinctions.data() + 2, two, w) : hn::Sub(constant(1.0F), opacity);
    // Small opacities keep their digits by log1p's polynomial, clear values near 0 by their own line.
    const F small = log2p1_reduced(hn::Neg(hn::Min(opacity, constant(0.25F))));
    const F large = log2_positive(hn::Max(clear, constant(1e-30F)));
    const F logarithm = hn::IfThenElse(hn::Lt(opacity, constant(0.25F)), small, large);
    const F y = hn::Min(hn::Mul(logarithm, constant(t.exponent)), constant(0.0F));
    return hn::IfThenElse(hn::Le(clear, constant(0.0F)), constant(kOpaque), y);
  }
  return hn::Min(on_line(t.extinctions.data(), place.line, w), constant(0.0F));
}

/// The transfer function at a value: y, then the colour if it is asked for.
template <int kChannels>
class Look {
 public:
  HWY_INLINE Look(const PacketTransfer& t, F value)
      : t_(t), few_(in_registers(t.ramps)), few_colours_(in_registers(t.pieces)) {
    // Beyond the data's range, where rounding may lead, polynomials know nothing.
    value_ = hn::Min(hn::Max(value, constant(t.lo)), constant(t.hi));
    u_ = table_coordinate(t, value_);
    if (!few_ || !(kChannels == 1 || t.affine || few_colours_)) place_ = table_place(t, value_, u_);
  }

  [[nodiscard]] HWY_INLINE F extinction() const {
    return few_ ? extinction_of_few(t_, value_) : extinction_at(t_, place_);
  }

  /// As q the colour, or u where there is one channel.
  HWY_INLINE void colour(F* q) const {
    if constexpr (kChannels == 1) {
      q[0] = u_;
    } else if (t_.affine) {
      for (int c = 0; c < 3; ++c) q[c] = hn::MulAdd(constant(t_.colour1[c]), u_, constant(t_.colour0[c]));
    } else if (few_colours_) {
      const Entry piece = entry(piece_of(t_.from, t_.pieces, value_));
      const F beyond = hn::Sub(value_, at(t_.from, piece));
      for (int c = 0; c < 3; ++c) {
        q[c] = hn::MulAdd(at(t_.slope[c], piece), beyond, at(t_.at[c], piece));
      }
    } else {
      const I three = hn::Add(hn::Add(place_.line, place_.line), place_.line);
      for (int c = 0; c < 3; ++c) q[c] = on_line(t_.colours.data() + 2 * c, three, place_.w);
    }
  }

 private:
  const PacketTransfer& t_;
  F value_, u_;
  TablePlace place_;
  bool few_, few_colours_;
};

/// The transfer function at a value: y, and as q the colour, or u where there is one channel.
template <int kChannels>
HWY_INLINE void look_up(const PacketTransfer& t, F value, F& y, F* q) {
  const Look<kChannels> look(t, value);
  y = look.extinction();
  look.colour(q);
}

template <int kChannels, class S>
HWY_INLINE Lights<kChannels> lights(const PacketJob& job, F value, const S& sampler, const F* ray) {
  Lights<kChannels> node;
  F q[kChannels];
  const Look<kChannels> look(job.transfer, value);
  node.y = look.extinction();
  if constexpr (kChannels == 3) {  // no colour where no lane has anything to show
    if (hn::AllTrue(DF(), hn::Eq(node.y, constant(0.0F)))) {
      for (int c = 0; c < 3; ++c) node.yq[c] = hn::Zero(DF());
      return node;
    }
  }
  look.colour(q);
  if constexpr (kChannels == 3) {
    if (job.shaded) {
      F gx, gy, gz, diffuse, specular;
      sampler.gradient(gx, gy, gz);
      blinn_phong(job, gx, gy, gz, ray, diffuse, specular);
      for (int c = 0; c < 3; ++c) q[c] = hn::MulAdd(q[c], diffuse, specular);
    }
  }
  for (int c = 0; c < kChannels; ++c) node.yq[c] = hn::Mul(node.y, q[c]);
  return node;
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
