#include "curvilinear/cell_order.h"

#include <algorithm>
#include <functional>
#include <queue>

namespace vol::curvilinear {
namespace {

/// Which cells lie behind the faces of each, by their places in the list.
struct Behind {
  std::vector<std::array<std::int32_t, 6>> of;  // -1: none
  std::vector<std::int8_t> waits_for;           // cells in front that are not drawn yet

  Behind(const std::vector<VisibleCell>& cells, const std::vector<Dims>& block_cells)
      : of(cells.size(), {-1, -1, -1, -1, -1, -1}), waits_for(cells.size(), 0) {
    std::vector<std::vector<std::int32_t>> place;
    for (const Dims& n : block_cells) place.emplace_back(static_cast<std::size_t>(n[0] * n[1] * n[2]), -1);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      place[cells[c].block][static_cast<std::size_t>(cells[c].number)] = static_cast<std::int32_t>(c);
    }
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const Dims& n = block_cells[cells[c].block];
      std::int64_t stride = 1;
      for (std::size_t a = 0; a < 3; stride *= n[a], ++a) {
        if (cells[c].number / stride % n[a] + 1 == n[a]) continue;
        const std::int32_t next = place[cells[c].block][static_cast<std::size_t>(cells[c].number + stride)];
        if (next < 0 || cells[c].before_next[a] == 0) continue;
        const auto other = static_cast<std::size_t>(next);
        const bool first = cells[c].before_next[a] > 0;
        of[first ? c : other][2 * a + (first ? 0 : 1)] = static_cast<std::int32_t>(first ? other : c);
        ++waits_for[first ? other : c];
      }
    }
  }
};

}  // namespace

std::int64_t put_in_order(std::vector<VisibleCell>& cells, const std::vector<Dims>& block_cells,
                          CellOrder order) {
  // By their place, so block and number, where depths are equal: the same picture on every machine.
  std::vector<std::pair<double, std::uint32_t>> nearest_first(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c)
    nearest_first[c] = {cells[c].depth, static_cast<std::uint32_t>(c)};
  std::sort(nearest_first.begin(), nearest_first.end());
  std::vector<VisibleCell> sorted;
  sorted.reserve(cells.size());
  for (const auto& [depth, c] : nearest_first) sorted.push_back(cells[c]);
  cells = std::move(sorted);
  if (order == CellOrder::depth) return 0;
  Behind behind(cells, block_cells);
  std::priority_queue<std::uint32_t, std::vector<std::uint32_t>, std::greater<>> ready;  // the nearest first
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (behind.waits_for[c] == 0) ready.push(static_cast<std::uint32_t>(c));
  }
  std::vector<bool> done(cells.size(), false);
  std::vector<VisibleCell> ordered;
  ordered.reserve(cells.size());
  std::int64_t cuts = 0;
  for (std::size_t nearest = 0; ordered.size() < cells.size();) {
    while (nearest < cells.size() && done[nearest]) ++nearest;
    cuts += ready.empty();
    const std::size_t c = ready.empty() ? nearest : ready.top();
    if (!ready.empty()) ready.pop();
    done[c] = true;
    ordered.push_back(cells[c]);
    for (const std::int32_t next : behind.of[c]) {
      if (next < 0) continue;
      const auto n = static_cast<std::size_t>(next);
      if (--behind.waits_for[n] == 0 && !done[n]) ready.push(static_cast<std::uint32_t>(next));
    }
  }
  cells = std::move(ordered);
  return cuts;
}

}  // namespace vol::curvilinear
