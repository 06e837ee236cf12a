// Scan conversion of sheets, compiled once for each instruction set and chosen when the program runs.
#include "curvilinear/sheet_mesh.h"
// The targets come before Highway:
#include "render/packet_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "curvilinear/sheet_scan_kernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file again:
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "render/packet_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::curvilinear::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<DF>;
using F = hn::Vec<DF>;
using I = hn::Vec<DI>;

/// A quantity along a row of pixels, held within its triangle's.
struct Ramp {
  float start, step, low, high;
  [[nodiscard]] HWY_INLINE float one(float pixel) const {
    return std::max(std::min(start + pixel * step, high), low);
  }
  HWY_INLINE F operator()(F pixels) const {
    const DF d;
    return hn::Max(hn::Min(hn::MulAdd(pixels, hn::Set(d, step), hn::Set(d, start)), hn::Set(d, high)),
                   hn::Set(d, low));
  }
};

/// What a ray's crossing of a triangle means: a surface between two sheets, the solid's last surface, or a
/// side, by which it enters or leaves.
enum class Crossing { surface, end, side };

/// Stretches of rays through sheets on their way into the picture: many are looked up at once, then
/// composited in their order.
class Fragments {
 public:
  Fragments(const TransferTable& table, Band& band) : table_(table), band_(band) {
    std::fill(std::begin(front_), std::end(front_), 0.0F);
    std::fill(std::begin(back_), std::end(back_), 0.0F);
    std::fill(std::begin(length_), std::end(length_), 0.0F);
  }

  /// Rays through the pixels [from, from + count) of the band meet a triangle. Those that were inside end a
  /// stretch here, of the depth between; in which order a sheet's sides are met plays no part.
  template <Crossing kCrossing>
  HWY_INLINE void meet(std::size_t from, int count, const Ramp& value, const Ramp& depth) {
    if (count < kFewest) {
      for (int k = 0; k < count; ++k) {
        const auto pixel = static_cast<float>(k);
        meet_one<kCrossing>(from + static_cast<std::size_t>(k), value.one(pixel), depth.one(pixel));
      }
    } else {
      meet_many<kCrossing>(from, count, value, depth);
    }
  }

  /// A stretch's optical depth by Simpson's rule, its value being linear: opaque where an end is beyond what
  /// is opaque, by more than float rounds; where it just comes to it the depth is finite (of an opacity that
  /// rises to 1, the integral of -log(1 - a)).
  void flush() {
    const DF d;
    const DI di;
    const float* depths = &table_.entries()->depth;
    const F within = hn::Set(d, 1e-5F), half = hn::Set(d, 0.5F), four = hn::Set(d, 4.0F);
    const F scale = hn::Set(d, -1.44269504088896341F / 6);  // of Simpson's rule, and log2(e)
    for (int k = 0; k < count_; k += static_cast<int>(hn::Lanes(d))) {
      const F front = hn::Load(d, front_ + k), back = hn::Load(d, back_ + k),
              length = hn::Load(d, length_ + k);
      const I middle = entry(hn::Mul(half, hn::Add(front, back)));
      hn::Store(middle, di, entry_ + k);
      const F ends = hn::Add(hn::GatherIndex(d, depths, hn::ShiftLeft<2>(entry(hn::Sub(front, within)))),
                             hn::GatherIndex(d, depths, hn::ShiftLeft<2>(entry(hn::Sub(back, within)))));
      const F thick = hn::MulAdd(four, hn::GatherIndex(d, depths, hn::ShiftLeft<2>(middle)), ends);
      const F opacity = render::HWY_NAMESPACE::one_minus_exp2(hn::Mul(hn::Mul(thick, length), scale));
      // Of an opaque value over no length the product is none.
      hn::Store(hn::IfThenElseZero(hn::Gt(length, hn::Zero(d)), opacity), d, opacity_ + k);
    }
    for (int k = 0; k < count_; ++k) {
      band_.composite(static_cast<std::size_t>(pixel_[k]), table_.entries()[entry_[k]], opacity_[k]);
    }
    band_.counts.samples += count_;
    count_ = 0;
  }

 private:
  /// Of values, as TransferTable has it.
  [[nodiscard]] HWY_INLINE I entry(F value) const {
    const DF d;
    const DI di;
    const I last = hn::Set(di, table_.last()), first = hn::Zero(di);
    I at = hn::Add(hn::ConvertTo(di, hn::Mul(value, hn::Set(d, TransferTable::steps()))), hn::Set(di, 1));
    at = hn::Max(hn::Min(at, last), first);
    at = hn::IfThenElse(hn::RebindMask(di, hn::Ge(value, hn::Set(d, table_.end()))), last, at);
    return hn::IfThenElse(hn::RebindMask(di, hn::Gt(value, hn::Zero(d))), at, first);
  }

  template <Crossing kCrossing>
  HWY_INLINE void meet_one(std::size_t at, float f, float z) {
    if (count_ == kMost) flush();
    Band::Inside& last = band_.inside;
    if (last.solid[at] == band_.solid) {
      front_[count_] = last.value[at];
      back_[count_] = f;
      length_[count_] = std::abs(z - last.depth[at]);
      pixel_[count_] = static_cast<std::int32_t>(at);
      ++count_;
      if constexpr (kCrossing != Crossing::surface) last.solid[at] = 0;
    } else if constexpr (kCrossing != Crossing::end) {
      last.solid[at] = band_.solid;
    }
    if constexpr (kCrossing != Crossing::end) {
      last.depth[at] = z;
      last.value[at] = f;
    }
  }

  template <Crossing kCrossing>
  HWY_INLINE void meet_many(std::size_t from, int count, const Ramp& value, const Ramp& depth) {
    const DF d;
    const DI di;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const I solid = hn::Set(di, band_.solid), none = hn::Zero(di);
    for (int k = 0; k < count; k += lanes) {
      if (count_ > kMost - lanes) flush();
      const std::size_t at = from + static_cast<std::size_t>(k);
      const F pixels = hn::Iota(d, static_cast<float>(k));
      const F z = depth(pixels), f = value(pixels);
      const auto here = hn::FirstN(d, static_cast<std::size_t>(count - k));
      const auto here_i = hn::RebindMask(di, here);
      // Reads and writes stay within the padding behind the band.
      const auto inside = hn::And(here_i, hn::Eq(hn::LoadU(di, &band_.inside.solid[at]), solid));
      const F length = hn::Abs(hn::Sub(z, hn::LoadU(d, &band_.inside.depth[at])));
      const F before = hn::LoadU(d, &band_.inside.value[at]);
      if constexpr (kCrossing != Crossing::end) {
        hn::BlendedStore(z, here, d, &band_.inside.depth[at]);
        hn::BlendedStore(f, here, d, &band_.inside.value[at]);
      }
      I next = none;
      if constexpr (kCrossing == Crossing::surface) next = solid;
      if constexpr (kCrossing == Crossing::side) next = hn::IfThenElse(inside, none, solid);
      hn::BlendedStore(next, here_i, di, &band_.inside.solid[at]);
      const auto ends = hn::RebindMask(d, inside);
      hn::CompressBlendedStore(before, ends, d, front_ + count_);
      hn::CompressBlendedStore(f, ends, d, back_ + count_);
      hn::CompressBlendedStore(length, ends, d, length_ + count_);
      count_ += static_cast<int>(
          hn::CompressBlendedStore(hn::Iota(di, static_cast<std::int32_t>(at)), inside, di, pixel_ + count_));
    }
  }

  static constexpr int kMost = 1024;
  static constexpr int kFewest = 4;  ///< pixels that are worth a vector
  const TransferTable& table_;
  Band& band_;
  int count_ = 0;
  HWY_ALIGN float front_[kMost + HWY_MAX_BYTES], back_[kMost + HWY_MAX_BYTES], length_[kMost + HWY_MAX_BYTES],
      opacity_[kMost + HWY_MAX_BYTES];
  HWY_ALIGN std::int32_t pixel_[kMost + HWY_MAX_BYTES], entry_[kMost + HWY_MAX_BYTES];
};

/// Where rows' centres cross an edge. From its upper end, whoever asks: both triangles of an edge get the
/// same bits.
struct Edge {
  double x, y, slope;
  HWY_INLINE Edge(const SheetVertex& upper, const SheetVertex& lower)
      : x(upper.x), y(upper.y), slope((lower.x - upper.x) / (lower.y - upper.y)) {}
  [[nodiscard]] HWY_INLINE double at(double row) const { return x + (row - y) * slope; }
};

class Scan {
 public:
  Scan(const TransferTable& table, Band& band) : band_(band), fragments_(table, band) {
    // A vector at the last pixel reaches beyond.
    const std::size_t size = band.pixels.size() + hn::Lanes(DF());
    if (band.inside.solid.size() == size) return;
    band.inside.depth.assign(size, 0);
    band.inside.value.assign(size, 0);
    band.inside.solid.assign(size, 0);
  }

  void draw(const SheetMesh& mesh, const SheetVertex* vertices) {
    if (mesh.starts) ++band_.solid;
    if (mesh.bottom <= band_.top || mesh.top >= band_.bottom || is_between_centres(mesh)) return;
    const auto columns = static_cast<std::size_t>(mesh.columns), rows = static_cast<std::size_t>(mesh.rows);
    const SheetVertex* front = vertices + mesh.first;
    if (mesh.starts) draw_surface<Crossing::surface>(front, columns, rows);
    for (int w = 1; w < mesh.surfaces; ++w) {
      const SheetVertex* back = front + columns * rows;
      draw_side(front, back, 1, columns);
      draw_side(front + columns * (rows - 1), back + columns * (rows - 1), 1, columns);
      draw_side(front, back, columns, rows);
      draw_side(front + columns - 1, back + columns - 1, columns, rows);
      if (mesh.ends && w + 1 == mesh.surfaces) {
        draw_surface<Crossing::end>(back, columns, rows);
      } else {
        draw_surface<Crossing::surface>(back, columns, rows);
      }
      front = back;
    }
  }
  void finish() { fragments_.flush(); }

 private:
  Band& band_;
  Fragments fragments_;

  static bool is_between_centres(const SheetMesh& m) {
    return std::ceil(m.left - 0.5) >= std::ceil(m.right - 0.5) ||
           std::ceil(m.top - 0.5) >= std::ceil(m.bottom - 0.5);
  }
  /// Number of the first pixel from `low` to `high` whose centre is not before p, however far away that is.
  static int first_centre(double p, int low, int high) {
    return static_cast<int>(
        std::ceil(std::clamp(p - 0.5, static_cast<double>(low), static_cast<double>(high))));
  }
  static bool is_above(const SheetVertex& a, const SheetVertex& b) {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
  }

  template <Crossing kCrossing>
  void draw_surface(const SheetVertex* vertices, std::size_t columns, std::size_t rows) {
    for (std::size_t v = 0; v + 1 < rows; ++v) {
      for (std::size_t u = 0; u + 1 < columns; ++u) {
        const SheetVertex* a = vertices + u + columns * v;
        draw_triangle<kCrossing>(a[0], a[1], a[columns]);
        draw_triangle<kCrossing>(a[1], a[columns], a[columns + 1]);
      }
    }
  }
  /// Between the edges of two surfaces.
  void draw_side(const SheetVertex* front, const SheetVertex* back, std::size_t stride, std::size_t count) {
    for (std::size_t n = 0; n + 1 < count; ++n, front += stride, back += stride) {
      draw_triangle<Crossing::side>(front[0], front[stride], back[0]);
      draw_triangle<Crossing::side>(front[stride], back[0], back[stride]);
    }
  }

  template <Crossing kCrossing>
  HWY_INLINE void draw_triangle(const SheetVertex& a, const SheetVertex& b, const SheetVertex& c) {
    const SheetVertex *p = &a, *q = &b, *r = &c;
    if (is_above(*q, *p)) std::swap(p, q);
    if (is_above(*r, *q)) std::swap(q, r);
    if (is_above(*q, *p)) std::swap(p, q);
    // Rows whose centres lie in [top, bottom).
    const int first = first_centre(p->y, band_.top, band_.bottom),
              end = first_centre(r->y, band_.top, band_.bottom);
    if (first >= end) return;
    const double left_most = std::min({p->x, q->x, r->x}), right_most = std::max({p->x, q->x, r->x});
    if (std::ceil(left_most - 0.5) >= std::ceil(right_most - 0.5)) return;
    const double qx = q->x - p->x, qy = q->y - p->y, rx = r->x - p->x, ry = r->y - p->y;
    const double area = qx * ry - qy * rx;
    if (area == 0) return;
    const Edge whole(*p, *r), upper(*p, *q), lower(*q, *r);
    const double scale = 1 / area;
    const Plane value(p->value, q->value, r->value, qx, qy, rx, ry, scale);
    const Plane depth(p->depth, q->depth, r->depth, qx, qy, rx, ry, scale);
    for (int y = first; y < end; ++y) {
      const double row = y + 0.5;
      // Half open: a corner on the row's centre belongs to the edge below it.
      const double x0 = whole.at(row), x1 = row < q->y ? upper.at(row) : lower.at(row);
      const double left = std::min(x0, x1), right = std::max(x0, x1);
      const int from = first_centre(left, 0, band_.width), to = first_centre(right, 0, band_.width);
      if (from >= to) continue;
      const double x = from + 0.5 - p->x, down = row - p->y;
      fragments_.meet<kCrossing>(band_.at(from, y), to - from, value.ramp(x, down), depth.ramp(x, down));
    }
  }

  /// A quantity linear over a triangle, from its upper corner.
  struct Plane {
    double at0, dx, dy;
    float low, high;
    HWY_INLINE Plane(float fp, float fq, float fr, double qx, double qy, double rx, double ry, double scale)
        : at0(fp), low(std::min({fp, fq, fr})), high(std::max({fp, fq, fr})) {
      const double q = static_cast<double>(fq) - at0, r = static_cast<double>(fr) - at0;
      dx = (q * ry - r * qy) * scale;
      dy = (r * qx - q * rx) * scale;
    }
    [[nodiscard]] HWY_INLINE Ramp ramp(double x, double y) const {
      return {static_cast<float>(at0 + dx * x + dy * y), static_cast<float>(dx), low, high};
    }
  };
};

void scan(std::span<const SheetMeshes* const> meshes, const TransferTable& table, Band& band) {
  Scan scan(table, band);
  for (const SheetMeshes* some : meshes) {
    for (const SheetMesh& mesh : some->meshes) scan.draw(mesh, some->vertices.data());
  }
  scan.finish();
}

}  // namespace vol::curvilinear::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::curvilinear {

HWY_EXPORT(scan);

void scan_sheets(std::span<const SheetMeshes* const> meshes, const TransferTable& table, Band& band) {
  HWY_DYNAMIC_DISPATCH(scan)(meshes, table, band);
}

}  // namespace vol::curvilinear
#endif
