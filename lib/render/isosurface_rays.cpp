#include "render/isosurface_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "render/surface_picture.h"
#include "render/visibility.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

constexpr double kNarrowest = 0x1p-46;
constexpr std::int64_t kBlock = 4;  // macrocells along a block's edge

/// The change of side in [0, 1] of a polynomial whose ends are on different sides and which changes once.
double bisect(const Bernstein& p) {
  const bool start = p.b[0] >= 0;
  double low = 0;
  double high = 1;
  for (int n = 0; n < 52; ++n) {
    const double middle = 0.5 * (low + high);
    ((p(middle) >= 0) == start ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

int side_changes(const Bernstein& p) {
  int changes = 0;
  for (int k = 0; k < p.degree; ++k) changes += (p.b[k] >= 0) != (p.b[k + 1] >= 0);
  return changes;
}

/// Hands the changes of side to f, in order; false once f does not want more.
template <class F>
bool search(const Bernstein& p, double from, double width, bool* undecided, const F& f) {
  const int changes = side_changes(p);
  if (changes == 0) return true;
  if (changes == 1) return f(from + width * bisect(p));
  if (width <= kNarrowest) {
    if ((p.b[0] >= 0) != (p.b[p.degree] >= 0)) return f(from + 0.5 * width);
    if (undecided != nullptr) *undecided = true;
    return true;
  }
  Bernstein left, right;
  p.halve(left, right);
  return search(left, from, 0.5 * width, undecided, f) &&
         search(right, from + 0.5 * width, 0.5 * width, undecided, f);
}

}  // namespace

std::optional<double> first_crossing(const Bernstein& p, double value, bool* undecided) {
  Bernstein shifted = p;
  for (int k = 0; k <= p.degree; ++k) shifted.b[k] -= value;
  std::optional<double> first;
  (void)search(shifted, 0, 1, undecided, [&](double u) {
    first = u;
    return false;
  });
  return first;
}

IsosurfaceRays::Counts& IsosurfaceRays::Counts::operator+=(const Counts& other) {
  rays += other.rays;
  hits += other.hits;
  cells += other.cells;
  undecided += other.undecided;
  return *this;
}

IsosurfaceRays::IsosurfaceRays(const volume::Volume& volume, volume::Reconstruction reconstruction,
                               double isovalue, bool close)
    : geometry_(volume.geometry()),
      bounds_(volume::field_bounds(geometry_)),
      world_to_index_(geometry_.world_to_index_matrix()),
      pieces_(volume, reconstruction, isovalue),
      box_(bounds_),
      close_(close) {
  if (!std::isfinite(isovalue)) throw Error("an isovalue must be finite");
  if (reconstruction == volume::Reconstruction::nearest) {
    throw Error("an isosurface needs a continuous field: trilinear, catmull-rom or b-spline");
  }
  (void)volume::value_range(volume);  // refuses NaN and infinity
  const index::Macrocells cells = index::macrocells(volume, reconstruction);
  macrocells_ = cells.dims;
  crossed_.resize(cells.ranges.size());
  for (std::size_t n = 0; n < crossed_.size(); ++n) {
    const volume::Range range = widened(cells.ranges[n], cells.all);
    crossed_[n] = range.min <= isovalue && range.max >= isovalue;
  }
  for (std::size_t a = 0; a < 3; ++a) blocks_[a] = (macrocells_[a] + kBlock - 1) / kBlock;
  block_crossed_.assign(static_cast<std::size_t>(blocks_[0] * blocks_[1] * blocks_[2]), 0);
  std::size_t n = 0;
  for (std::int64_t k = 0; k < macrocells_[2]; ++k) {
    for (std::int64_t j = 0; j < macrocells_[1]; ++j) {
      std::uint8_t* row =
          &block_crossed_[static_cast<std::size_t>(blocks_[0] * (j / kBlock + blocks_[1] * (k / kBlock)))];
      for (std::int64_t i = 0; i < macrocells_[0]; ++i) row[i / kBlock] |= crossed_[n++];
    }
  }
}

template <class F>
void IsosurfaceRays::for_crossed_stretches(const camera::Ray& ray, const Chord& chord, const F& f) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Vec3 o = world_to_index_ * (ray.origin - geometry_.origin);
  const Vec3 d = world_to_index_ * ray.direction;
  std::int64_t at[3];
  double leave[3];
  const auto meets_plane = [&](int a, std::int64_t plane) {
    return (static_cast<double>(plane * index::Macrocells::kEdge) - o[a]) / d[a];
  };
  const auto leaves_by = [&](int a, std::int64_t plane) {
    const bool last =
        d[a] == 0 || (d[a] > 0 ? plane >= macrocells_[static_cast<std::size_t>(a)] : plane <= 0);
    return last ? kInfinity : meets_plane(a, plane);
  };
  const auto next_plane = [&](int a) { return leaves_by(a, d[a] > 0 ? at[a] + 1 : at[a]); };
  const auto first_of = [](const double* t) {
    return t[0] <= t[1] ? (t[0] <= t[2] ? 0 : 2) : (t[1] <= t[2] ? 1 : 2);
  };
  // Leaves the block that the ray is in, for the macrocell that steps would lead to; \returns where.
  const auto leave_block = [&] {
    double block_leave[3];
    for (int a = 0; a < 3; ++a) {
      block_leave[a] = leaves_by(a, d[a] > 0 ? (at[a] / kBlock + 1) * kBlock : at[a] / kBlock * kBlock);
    }
    const int axis = first_of(block_leave);
    const double end = block_leave[axis];
    if (end >= chord.exit) return end;
    for (int a = 0; a < 3; ++a) {
      if (d[a] == 0) continue;
      const std::int64_t step = d[a] > 0 ? 1 : -1;
      if (a == axis) {
        at[a] = d[a] > 0 ? (at[a] / kBlock + 1) * kBlock : at[a] / kBlock * kBlock - 1;
      } else {
        // Planes up to there are behind; those met just there as well where their axis comes first in order.
        const auto is_behind = [&](double t) { return t < end || (t == end && a < axis); };
        const std::int64_t start = at[a];
        const std::int64_t low = start / kBlock * kBlock;
        const double x = (o[a] + end * d[a]) / index::Macrocells::kEdge;
        at[a] = std::clamp(static_cast<std::int64_t>(x), low,
                           std::min(low + kBlock, macrocells_[static_cast<std::size_t>(a)]) - 1);
        if ((at[a] - start) * step < 0) at[a] = start;
        while (at[a] != start && !is_behind(meets_plane(a, d[a] > 0 ? at[a] : at[a] + 1))) at[a] -= step;
        while (is_behind(next_plane(a))) at[a] += step;
      }
      leave[a] = next_plane(a);
    }
    return end;
  };
  for (int a = 0; a < 3; ++a) {
    const double x = (o[a] + chord.entry * d[a]) / index::Macrocells::kEdge;
    at[a] =
        !(x > 0) ? 0 : std::min(static_cast<std::int64_t>(x), macrocells_[static_cast<std::size_t>(a)] - 1);
    leave[a] = next_plane(a);
  }
  // A stretch goes on through neighbours that are crossed too; stretches and gaps meet without a space
  // between.
  double t = chord.entry;
  bool open = false;  // a stretch, from `start` on
  double start = t;
  while (t < chord.exit) {
    if (!block_crossed_[static_cast<std::size_t>(
            at[0] / kBlock + blocks_[0] * (at[1] / kBlock + blocks_[1] * (at[2] / kBlock)))]) {
      if (open && start < t && !f({start, t})) return;
      open = false;
      const double end = leave_block();
      if (end >= chord.exit) return;
      t = std::max(t, end);
      continue;
    }
    const int axis = first_of(leave);
    const bool crossed =
        crossed_[static_cast<std::size_t>(at[0] + macrocells_[0] * (at[1] + macrocells_[1] * at[2]))] != 0;
    if (crossed && !open) start = t;
    if (!crossed && open && start < t && !f({start, t})) return;
    open = crossed;
    t = std::max(t, std::min(leave[axis], chord.exit));
    if (leave[axis] >= chord.exit) break;
    at[axis] += d[axis] > 0 ? 1 : -1;
    leave[axis] = next_plane(axis);
  }
  if (open && start < chord.exit) (void)f({start, chord.exit});
}

IsosurfaceRays::Hit IsosurfaceRays::hit_at(const camera::Ray& ray, const RayPiece& piece, double t) const {
  Vec3 gradient = pieces_.gradient(ray, piece, t);
  // On the rim of a plateau it may be 0: towards the piece's end outside it is not, for the field falls.
  const double outside = piece.p.b[0] < 0 && t > piece.t0 ? piece.t0 : piece.t1;
  for (double share = 0x1p-20; share <= 1 && gradient.isZero(0); share *= 2) {
    gradient = pieces_.gradient(ray, piece, t + share * (outside - t));
  }
  const double length = gradient.stableNorm();
  return {t, ray.origin + t * ray.direction, length > 0 ? Vec3(-gradient / length) : Vec3(Vec3::Zero())};
}

bool IsosurfaceRays::begins_inside(const camera::Ray& ray, const Chord& chord) const {
  bool inside = false;
  pieces_(ray, chord, [&](const RayPiece& piece) {
    inside = piece.p.b[0] >= 0;
    return false;
  });
  return inside;
}

IsosurfaceRays::Hit IsosurfaceRays::border_hit(const camera::Ray& ray, double t) const {
  const Vec3 p = ray.origin + t * ray.direction;
  return {t, p, outward_normal(box_, p)};
}

void IsosurfaceRays::for_hits(const camera::Ray& ray, const Chord& chord,
                              const std::function<bool(const Hit&)>& f, Counts& counts,
                              bool& undecided) const {
  std::optional<bool> inside;  // where the last cell ended
  if (close_) {
    inside = begins_inside(ray, chord);
    const auto whole = box_.chord(ray, -std::numeric_limits<double>::infinity());
    if (*inside && whole && chord.entry == whole->entry) {  // else the chord begins at the eye, in the box
      if (!f(border_hit(ray, chord.entry))) return;
    }
  }
  bool more = true;
  CellSpan last;
  const auto look = [&](const CellSpan& span) {
    // Most cells beside the surface are on one side of it, which their samples tell.
    const std::optional<bool> side = pieces_.at_least_zero(span.cell);
    if (side && (!inside || *inside == *side)) {
      inside = side;
      last = span;
      return true;
    }
    ++counts.cells;
    const RayPiece piece = pieces_.piece(ray, span);
    const bool starts_inside = piece.p.b[0] >= 0;
    if (inside && *inside != starts_inside) {
      // The gradient on the side that is outside, as within a piece.
      const bool before = starts_inside && last.t1 == span.t0;
      more = f(hit_at(ray, before ? pieces_.piece(ray, last) : piece, span.t0));
    }
    if (more) {
      more = search(piece.p, 0, 1, &undecided,
                    [&](double u) { return f(hit_at(ray, piece, piece.t0 + u * (piece.t1 - piece.t0))); });
    }
    inside = piece.p.b[piece.p.degree] >= 0;
    last = span;
    return more;
  };
  for_crossed_stretches(ray, chord, [&](const Chord& stretch) {
    pieces_.for_cells(ray, stretch, look);
    return more;
  });
  if (more && close_ && *inside) (void)f(border_hit(ray, chord.exit));
}

std::optional<IsosurfaceRays::Hit> IsosurfaceRays::first_hit(const camera::Ray& ray, const Chord& chord,
                                                             Counts& counts) const {
  ++counts.rays;
  std::optional<Hit> hit;
  bool undecided = false;
  const auto take = [&](const Hit& first) {
    hit = first;
    return false;
  };
  for_hits(ray, chord, take, counts, undecided);
  counts.undecided += undecided && !hit;
  counts.hits += hit.has_value();
  return hit;
}

IsosurfaceImage draw_isosurface(const IsosurfaceRays& surface, const Scene& scene, const Vec3& colour,
                                int width, int height) {
  IsosurfaceImage result;
  result.image = draw_first_hits(surface, scene, colour, width, height, result.counts);
  return result;
}

}  // namespace vol::render
