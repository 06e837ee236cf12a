#include "curvilinear/cell_order.h"

#include <algorithm>

namespace vol::curvilinear {

Dims first_cell(const VisibleCell& cell, const std::vector<Dims>& block_cells) {
  const Dims& n = block_cells[cell.block];
  return {cell.number % n[0], cell.number / n[0] % n[1], cell.number / (n[0] * n[1])};
}

CellPlaces::CellPlaces(const std::vector<VisibleCell>& cells, const std::vector<Dims>& block_cells)
    : block_cells_(block_cells) {
  for (const Dims& n : block_cells) place_.emplace_back(static_cast<std::size_t>(n[0] * n[1] * n[2]), -1);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const Dims& n = block_cells[cells[c].block];
    std::vector<std::int32_t>& place = place_[cells[c].block];
    const std::int64_t size = std::int64_t{1} << cells[c].level;
    for (std::int64_t k = 0; k < size; ++k) {
      for (std::int64_t j = 0; j < size; ++j) {
        for (std::int64_t i = 0; i < size; ++i) {
          place[static_cast<std::size_t>(cells[c].number + i + n[0] * (j + n[1] * k))] =
              static_cast<std::int32_t>(c);
        }
      }
    }
  }
}

std::int32_t CellPlaces::operator()(std::uint32_t block, const Dims& cell) const {
  const Dims& n = block_cells_[block];
  for (std::size_t a = 0; a < 3; ++a) {
    if (cell[a] < 0 || cell[a] >= n[a]) return -1;
  }
  return place_[block][static_cast<std::size_t>(cell[0] + n[0] * (cell[1] + n[1] * cell[2]))];
}

void sort_by_depth(std::vector<VisibleCell>& cells) {
  std::vector<std::pair<double, std::uint32_t>> nearest_first(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c)
    nearest_first[c] = {cells[c].depth, static_cast<std::uint32_t>(c)};
  std::sort(nearest_first.begin(), nearest_first.end());
  std::vector<VisibleCell> sorted;
  sorted.reserve(cells.size());
  for (const auto& [depth, c] : nearest_first) sorted.push_back(cells[c]);
  cells = std::move(sorted);
}

std::vector<Before> before_by_faces(const std::vector<VisibleCell>& cells,
                                    const std::vector<Dims>& block_cells) {
  const CellPlaces place(cells, block_cells);
  std::vector<Before> before;
  before.reserve(3 * cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const VisibleCell& cell = cells[c];
    const Dims first = first_cell(cell, block_cells);
    const auto relate = [&](std::int32_t other, std::int8_t sign) {
      if (sign == 0) return;
      const auto here = static_cast<std::uint32_t>(c), there = static_cast<std::uint32_t>(other);
      before.emplace_back(sign > 0 ? here : there, sign > 0 ? there : here);
    };
    for (std::size_t a = 0; a < 3; ++a) {
      Dims beside = first;
      beside[a] += std::int64_t{1} << cell.level;
      const std::int32_t next = place(cell.block, beside);
      if (next >= 0 && cells[static_cast<std::size_t>(next)].level >= cell.level)
        relate(next, cell.before_next[a]);
      beside[a] = first[a] - 1;
      const std::int32_t previous = place(cell.block, beside);
      if (previous >= 0 && cells[static_cast<std::size_t>(previous)].level > cell.level)
        relate(previous, cell.before_previous[a]);
    }
  }
  return before;
}

}  // namespace vol::curvilinear
