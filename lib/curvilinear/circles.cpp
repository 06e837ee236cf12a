#include "curvilinear/circles.h"

#include <algorithm>
#include <limits>
#include <map>

#include "curvilinear/halves.h"
#include "curvilinear/sheet_parts.h"

namespace vol::curvilinear {

struct Circles::Part {
  CellPart of;
  Solid solid;     // in view coordinates
  Vec3 low, high;  // parameters of the block, counted in cells
  double depth;    // smallest of its corners
};

namespace {

/// The axis along which two boxes of one block meet face to face, the first's higher end at the second's
/// lower; -1: none.
int meeting_axis(const Vec3& low, const Vec3& high, const Vec3& other_low, const Vec3& other_high) {
  int axis = -1;
  for (int a = 0; a < 3; ++a) {
    if (high[a] == other_low[a]) {
      if (axis >= 0) return -1;
      axis = a;
    } else if (!(low[a] < other_high[a] && other_low[a] < high[a])) {
      return -1;
    }
  }
  return axis;
}

}  // namespace

Circles::Part Circles::part_of(std::uint32_t cell, const Solid& solid, const Vec3& low,
                               const Vec3& high) const {
  const Dims first = first_cell(cells_[cell], block_cells_);
  const double size = static_cast<double>(std::int64_t{1} << cells_[cell].level);
  const Vec3 corner(static_cast<double>(first[0]), static_cast<double>(first[1]),
                    static_cast<double>(first[2]));
  Part part{{cell, low, high},
            solid,
            corner + size * low,
            corner + size * high,
            std::numeric_limits<double>::infinity()};
  for (const std::size_t n : {0, 3, 12, 15, 48, 51, 60, 63})
    part.depth = std::min(part.depth, solid.b[n].z());
  return part;
}

void Circles::split(std::span<const std::uint32_t> members, std::vector<CellPart>& parts,
                    CircleCounts& counts) const {
  ++counts.circles;
  if (members.size() >= kMostParts) {  // a solid is 2 KB, and pairs are compared
    ++counts.unresolved;
    for (const std::uint32_t c : members) parts.push_back({c, Vec3::Zero(), Vec3::Ones()});
    return;
  }
  std::vector<Part> whole;
  std::vector<std::uint32_t> sorted(members.begin(), members.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<const GapCrossing*> gaps;
  for (const std::uint32_t c : sorted) {
    whole.push_back(part_of(c, solid_of_(cells_[c]), Vec3::Zero(), Vec3::Ones()));
    auto gap = std::lower_bound(gaps_.begin(), gaps_.end(), c,
                                [](const GapCrossing& g, std::uint32_t front) { return g.front < front; });
    for (; gap != gaps_.end() && gap->front == c; ++gap) {
      if (std::binary_search(sorted.begin(), sorted.end(), gap->back)) gaps.push_back(&*gap);
    }
  }
  const std::size_t before = parts.size();
  order(std::move(whole), std::move(gaps), kMostSplits, parts, counts);
  std::map<std::uint32_t, int> parts_of;
  for (std::size_t n = before; n < parts.size(); ++n) ++parts_of[parts[n].cell];
  for (const auto& [cell, count] : parts_of) counts.split += count > 1;
}

void Circles::order(std::vector<Part> parts, std::vector<const GapCrossing*> gaps, int splits,
                    std::vector<CellPart>& out, CircleCounts& counts) const {
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& a, const Part& b) { return a.depth < b.depth; });
  std::vector<Before> before;
  // Faces that meet, of blocks by themselves: those whose boxes overlap along the first axis.
  std::vector<std::uint32_t> by_low(parts.size());
  for (std::size_t n = 0; n < parts.size(); ++n) by_low[n] = static_cast<std::uint32_t>(n);
  const auto block = [&](std::uint32_t n) { return cells_[parts[n].of.cell].block; };
  std::sort(by_low.begin(), by_low.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (block(a) != block(b)) return block(a) < block(b);
    return parts[a].low[0] != parts[b].low[0] ? parts[a].low[0] < parts[b].low[0] : a < b;
  });
  const auto relate = [&](std::uint32_t p, std::uint32_t q) {
    const Part &one = parts[p], &two = parts[q];
    const int axis = meeting_axis(one.low, one.high, two.low, two.high);
    if (axis < 0) return false;
    // In the middle of what they share, on the first's face.
    const Vec3 middle = 0.5 * (one.low.cwiseMax(two.low) + one.high.cwiseMin(two.high));
    Vec3 at = (middle - one.low).cwiseQuotient(one.high - one.low);
    at[axis] = 1;
    Eigen::Matrix<double, 4, 3> d;
    const Vec3 point = one.solid(at, d).head<3>();
    const int sign = screen_.runs_away(point, d, axis);
    if (sign != 0) before.emplace_back(sign > 0 ? p : q, sign > 0 ? q : p);
    return true;
  };
  for (std::size_t n = 0; n < by_low.size(); ++n) {
    for (std::size_t m = n + 1; m < by_low.size() && block(by_low[m]) == block(by_low[n]) &&
                                parts[by_low[m]].low[0] <= parts[by_low[n]].high[0];
         ++m) {
      if (!relate(by_low[n], by_low[m])) (void)relate(by_low[m], by_low[n]);
    }
  }
  // Rays that pass from one to another.
  std::map<std::uint32_t, std::vector<std::uint32_t>> of_cell;
  for (std::size_t n = 0; n < parts.size(); ++n)
    of_cell[parts[n].of.cell].push_back(static_cast<std::uint32_t>(n));
  const auto holder = [&](std::uint32_t cell, const Vec3& at) {
    const auto found = of_cell.find(cell);
    if (found == of_cell.end()) return -1;
    for (const std::uint32_t n : found->second) {
      if ((at - parts[n].low).minCoeff() >= 0 && (parts[n].high - at).minCoeff() >= 0)
        return static_cast<int>(n);
    }
    return -1;
  };
  Before last{0, 0};
  std::erase_if(gaps, [&](const GapCrossing* gap) {
    const int front = holder(gap->front, gap->left_at), back = holder(gap->back, gap->entered_at);
    if (front < 0 || back < 0 || front == back) return true;
    const Before now(static_cast<std::uint32_t>(front), static_cast<std::uint32_t>(back));
    if (now != last) before.push_back(now);
    last = now;
    return false;
  });

  const FrontToBack found = front_to_back(static_cast<std::uint32_t>(parts.size()), before);
  std::size_t in_circles = 0;
  for (const auto& [begin, end] : found.circles) in_circles += end - begin;
  const bool fewer = 2 * in_circles <= parts.size();
  auto circle = found.circles.begin();
  for (std::size_t n = 0; n < found.order.size();) {
    if (circle == found.circles.end() || n < circle->begin) {
      out.push_back(parts[found.order[n++]].of);
      continue;
    }
    const std::size_t count = circle->end - circle->begin;
    std::vector<Part> smaller;
    bool halved = false;
    for (std::size_t k = circle->begin; k < circle->end; ++k) {
      const Part& part = parts[found.order[k]];
      const Extents e = extents(part.solid, screen_);
      const auto axis = static_cast<std::size_t>(std::max_element(e.length, e.length + 3) - e.length);
      if (!(e.length[axis] > kLeastPartPixels)) {
        smaller.push_back(part);
        continue;
      }
      halved = true;
      const std::array<Solid, 2> two = halves(part.solid, axis);
      Vec3 middle_low = part.of.low, middle_high = part.of.high;
      const auto a = static_cast<int>(axis);
      middle_low[a] = middle_high[a] = 0.5 * (part.of.low[a] + part.of.high[a]);
      smaller.push_back(part_of(part.of.cell, two[0], part.of.low, middle_high));
      smaller.push_back(part_of(part.of.cell, two[1], middle_low, part.of.high));
    }
    if (halved && (fewer || splits > 0) && count < kMostParts) {
      order(std::move(smaller), gaps, fewer ? kMostSplits : splits - 1, out, counts);
    } else {
      ++counts.unresolved;
      for (std::size_t k = circle->begin; k < circle->end; ++k) out.push_back(parts[found.order[k]].of);
    }
    n = circle->end;
    ++circle;
  }
}

}  // namespace vol::curvilinear
