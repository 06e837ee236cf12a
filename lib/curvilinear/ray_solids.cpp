#include "curvilinear/ray_solids.h"

#include <algorithm>
#include <limits>

#include "base/error.h"

namespace vol::curvilinear {
namespace {

/// Stretches in order of their start, none overlapping, each covered once.
bool is_plain(const std::vector<SolidInterval>& intervals) {
  for (std::size_t n = 0; n < intervals.size(); ++n) {
    if (intervals[n].degree != 1 || (n > 0 && intervals[n].t0 < intervals[n - 1].t1)) return false;
  }
  return true;
}

/// Where the degrees of overlapping intervals, in order of their start, sum to more than 0.
void sweep(const std::vector<SolidInterval>& intervals, std::vector<RaySegment>& segments) {
  std::vector<double> ends;
  for (const auto& i : intervals) ends.insert(ends.end(), {i.t0, i.t1});
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  std::vector<const SolidInterval*> active;
  const SolidInterval* last = nullptr;
  std::size_t next = 0;
  for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
    while (next < intervals.size() && intervals[next].t0 <= ends[e]) active.push_back(&intervals[next++]);
    std::erase_if(active, [&](const SolidInterval* i) { return i->t1 <= ends[e]; });
    int degree = 0;
    const SolidInterval* first = nullptr;
    for (const SolidInterval* i : active) {
      degree += i->degree;
      if (first == nullptr && i->degree > 0) first = i;
    }
    if (degree <= 0) {
      last = nullptr;
    } else if (first == last) {
      segments.back().t1 = ends[e + 1];
    } else {
      segments.push_back({*first, ends[e], ends[e + 1]});
      last = first;
    }
  }
}

}  // namespace

SolidRays::SolidRays(const Grid& grid, const std::vector<std::vector<double>>& values, CellKind kind,
                     double beta)
    : grid_(&grid), kind_(kind), beta_(beta), faces_(grid, kind, beta) {
  if (!values.empty() && values.size() != grid.blocks.size()) throw Error("rays need values for every block");
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const auto& list : values) {
    for (const double f : list) {
      least = std::min(least, f);
      most = std::max(most, f);
    }
  }
  if (most > least) value_range_ = most - least;
  for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
    const Block& block = grid.blocks[b];
    solids_.emplace_back(block, values.empty() ? std::span<const double>() : values[b], kind, beta);
    handedness_.push_back(curvilinear::handedness(block));
  }
}

void SolidRays::crossings(const camera::Ray& ray, RayScratch& scratch) const {
  scratch.crossings.clear();
  const RayFrame frame(ray, faces_.bounds().centre());
  faces_.visit({frame.origin, frame.along}, [&](const Face& face) {
    scratch.hits.clear();
    append_hits(RayPatch(face_patch(grid_->blocks[face.block], face, kind_, beta_), frame), scratch.hits);
    for (const PatchHit& hit : scratch.hits) {
      scratch.crossings.push_back({face, hit, frame.t_origin + hit.z});
    }
  });
}

bool SolidRays::intervals(const camera::Ray& ray, RayScratch& scratch) const {
  crossings(ray, scratch);
  scratch.changes.clear();
  for (std::size_t n = 0; n < scratch.crossings.size(); ++n) {
    const Crossing& c = scratch.crossings[n];
    const Block& block = grid_->blocks[c.face.block];
    for (const bool before : {true, false}) {
      Dims cell{c.face.at[0], c.face.at[1], c.face.at[2]};
      if (before) --cell[c.face.axis];
      if (cell[c.face.axis] < 0 || cell[c.face.axis] >= block.dims[c.face.axis] - 1) continue;
      if (block.is_missing(cell)) continue;
      const std::uint64_t key = std::uint64_t{c.face.block} << 34 | block.offset(cell[0], cell[1], cell[2]);
      const int by = c.hit.sign * handedness_[c.face.block] * (before ? -1 : 1);
      scratch.changes.push_back({key, c.t, by, static_cast<std::uint32_t>(n), before});
    }
  }
  std::sort(scratch.changes.begin(), scratch.changes.end(), [](const auto& a, const auto& b) {
    if (a.cell != b.cell) return a.cell < b.cell;
    return a.t != b.t ? a.t < b.t : a.crossing < b.crossing;
  });
  scratch.intervals.clear();
  bool closed = true;
  int degree = 0;
  const auto parameters = [&](const RayScratch::Change& c) {
    const Crossing& crossing = scratch.crossings[c.crossing];
    return cell_parameters(crossing.face, c.before, crossing.hit.u, crossing.hit.v);
  };
  for (std::size_t n = 0; n < scratch.changes.size(); ++n) {
    const auto& change = scratch.changes[n];
    degree += change.by;
    if (n + 1 == scratch.changes.size() || scratch.changes[n + 1].cell != change.cell) {
      closed = closed && degree == 0;
      degree = 0;
      continue;
    }
    const auto& next = scratch.changes[n + 1];
    if (degree == 0 || !(next.t > change.t)) continue;
    const Face& face = scratch.crossings[change.crossing].face;
    SolidInterval interval{face.block, {face.at[0], face.at[1], face.at[2]}, change.t, next.t, {}, {},
                           degree};
    if (change.before) --interval.cell[face.axis];
    interval.u0 = parameters(change);
    interval.u1 = parameters(next);
    scratch.intervals.push_back(interval);
  }
  return closed;
}

void SolidRays::segments(const camera::Ray& ray, double t_min, RayScratch& scratch,
                         std::vector<RaySegment>& segments) const {
  segments.clear();
  (void)intervals(ray, scratch);
  auto& intervals = scratch.intervals;
  // Stable: of those that start together, the lower cell comes first.
  std::stable_sort(intervals.begin(), intervals.end(),
                   [](const SolidInterval& a, const SolidInterval& b) { return a.t0 < b.t0; });
  if (is_plain(intervals)) {
    for (const SolidInterval& i : intervals) segments.push_back({i, i.t0, i.t1});
  } else {
    sweep(intervals, segments);
  }
  std::erase_if(segments, [&](const RaySegment& s) { return s.t1 <= t_min; });
  for (auto& s : segments) s.t0 = std::max(s.t0, t_min);
}

}  // namespace vol::curvilinear
