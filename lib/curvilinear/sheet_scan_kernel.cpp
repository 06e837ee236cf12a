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
  HWY_INLINE F operator()(F pixels) const {
    const DF d;
    return hn::Max(hn::Min(hn::MulAdd(pixels, hn::Set(d, step), hn::Set(d, start)), hn::Set(d, high)),
                   hn::Set(d, low));
  }
};

/// Pieces of sheets on their way into the picture: many are looked up at once, then composited in their order.
class Fragments {
 public:
  Fragments(const TransferTable& table, Band& band) : table_(table), band_(band) {
    std::fill(std::begin(value_), std::end(value_), 0.0F);
    std::fill(std::begin(depth_), std::end(depth_), 0.0F);
  }

  /// Pixels [from, from + count) of the band.
  HWY_INLINE void add(std::size_t from, int count, Ramp value, Ramp depth) {
    const DF d;
    const DI di;
    while (count > 0) {
      if (count_ == kMost) flush();
      const int some = std::min(count, kMost - count_);
      const int lanes = static_cast<int>(hn::Lanes(d));
      for (int k = 0; k < some; k += lanes) {  // may write beyond, what is written again or not read
        const F at = hn::Iota(d, static_cast<float>(k));
        hn::StoreU(value(at), d, value_ + count_ + k);
        hn::StoreU(depth(at), d, depth_ + count_ + k);
        hn::StoreU(hn::Iota(di, static_cast<std::int32_t>(from) + k), di, pixel_ + count_ + k);
      }
      count_ += some;
      count -= some;
      from += static_cast<std::size_t>(some);
      value.start += static_cast<float>(some) * value.step;
      depth.start += static_cast<float>(some) * depth.step;
    }
  }

  void flush() {
    const DF d;
    const DI di;
    const float* depths = &table_.entries()->depth;
    const F low = hn::Set(d, table_.low()), high = hn::Set(d, table_.high()), scale = hn::Set(d, table_.scale());
    const I last = hn::Set(di, table_.last()), first = hn::Zero(di), one = hn::Set(di, 1);
    const F minus_log2e = hn::Set(d, -1.44269504088896341F);
    for (int k = 0; k < count_; k += static_cast<int>(hn::Lanes(d))) {
      const F value = hn::Load(d, value_ + k), depth = hn::Load(d, depth_ + k);
      I entry = hn::Add(hn::ConvertTo(di, hn::Mul(hn::Sub(value, low), scale)), one);
      entry = hn::Max(hn::Min(entry, last), first);
      entry = hn::IfThenElse(hn::RebindMask(di, hn::Ge(value, high)), last, entry);
      entry = hn::IfThenElse(hn::RebindMask(di, hn::Gt(value, low)), entry, first);
      hn::Store(entry, di, entry_ + k);
      const F thick = hn::GatherIndex(d, depths, hn::ShiftLeft<2>(entry));
      const F opacity = render::HWY_NAMESPACE::one_minus_exp2(hn::Mul(hn::Mul(thick, depth), minus_log2e));
      // Of an opaque value over no length the product is none.
      hn::Store(hn::IfThenElseZero(hn::Gt(depth, hn::Zero(d)), opacity), d, opacity_ + k);
    }
    for (int k = 0; k < count_; ++k) {
      band_.composite(static_cast<std::size_t>(pixel_[k]), table_.entries()[entry_[k]], opacity_[k]);
    }
    band_.counts.samples += count_;
    count_ = 0;
  }

 private:
  static constexpr int kMost = 1024;
  const TransferTable& table_;
  Band& band_;
  int count_ = 0;
  HWY_ALIGN float value_[kMost + HWY_MAX_BYTES], depth_[kMost + HWY_MAX_BYTES], opacity_[kMost + HWY_MAX_BYTES];
  HWY_ALIGN std::int32_t pixel_[kMost + HWY_MAX_BYTES], entry_[kMost + HWY_MAX_BYTES];
};

/// Where rows' centres cross an edge. From its upper end, whoever asks: both triangles of an edge get the same
/// bits.
struct Edge {
  double x, y, slope;
  HWY_INLINE Edge(const SheetVertex& upper, const SheetVertex& lower)
      : x(upper.x), y(upper.y), slope((lower.x - upper.x) / (lower.y - upper.y)) {}
  [[nodiscard]] HWY_INLINE double at(double row) const { return x + (row - y) * slope; }
};

class Scan {
 public:
  Scan(const TransferTable& table, Band& band) : band_(band), fragments_(table, band) {}

  void draw(const SheetMesh& mesh, const SheetVertex* vertices) {
    if (mesh.bottom <= band_.top || mesh.top >= band_.bottom || is_between_centres(mesh)) return;
    const auto columns = static_cast<std::size_t>(mesh.columns), rows = static_cast<std::size_t>(mesh.rows);
    for (std::size_t w = 0; w < static_cast<std::size_t>(mesh.sheets); ++w) {
      const SheetVertex* sheet = vertices + mesh.first + columns * rows * w;
      for (std::size_t v = 0; v + 1 < rows; ++v) {
        for (std::size_t u = 0; u + 1 < columns; ++u) {
          const SheetVertex* a = sheet + u + columns * v;
          draw_triangle(a[0], a[1], a[columns]);
          draw_triangle(a[1], a[columns], a[columns + 1]);
        }
      }
    }
  }
  void finish() { fragments_.flush(); }

 private:
  Band& band_;
  Fragments fragments_;

  static bool is_between_centres(const SheetMesh& m) {
    return std::ceil(m.left - 0.5) >= std::ceil(m.right - 0.5) || std::ceil(m.top - 0.5) >= std::ceil(m.bottom - 0.5);
  }
  static bool is_above(const SheetVertex& a, const SheetVertex& b) {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
  }

  HWY_INLINE void draw_triangle(const SheetVertex& a, const SheetVertex& b, const SheetVertex& c) {
    const SheetVertex *p = &a, *q = &b, *r = &c;
    if (is_above(*q, *p)) std::swap(p, q);
    if (is_above(*r, *q)) std::swap(q, r);
    if (is_above(*q, *p)) std::swap(p, q);
    // Rows whose centres lie in [top, bottom).
    const int first = static_cast<int>(std::ceil(std::max(p->y - 0.5, static_cast<double>(band_.top)))),
              end = static_cast<int>(std::ceil(std::min(r->y - 0.5, static_cast<double>(band_.bottom))));
    if (first >= end) return;
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
      const int from = static_cast<int>(std::ceil(std::max(left - 0.5, 0.0))),
                to = static_cast<int>(std::ceil(std::min(right - 0.5, static_cast<double>(band_.width))));
      if (from >= to) continue;
      const double x = from + 0.5 - p->x, down = row - p->y;
      fragments_.add(band_.at(from, y), to - from, value.ramp(x, down), depth.ramp(x, down));
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
