#include "curvilinear/merged_cells.h"

#include <algorithm>
#include <limits>

#include "base/parallel.h"
#include "curvilinear/halves.h"
#include "curvilinear/larger_error.h"

namespace vol::curvilinear {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Largest distance of two solids' control points; infinite where one is not a number.
MergeTolerance difference(const Solid& a, const Solid& b) {
  MergeTolerance largest{0, 0};
  for (std::size_t n = 0; n < 64; ++n) {
    const Point4 d = a.b[n] - b.b[n];
    largest.position = larger_error(largest.position, d.head<3>().squaredNorm());
    largest.value = larger_error(largest.value, std::abs(d[3]));
  }
  largest.position = std::sqrt(largest.position);
  return largest;
}

/// A solid's eight halves, along x first.
std::array<Solid, 8> eighths(const Solid& whole) {
  std::array<Solid, 8> parts;
  const auto z = halves(whole, 2);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto y = halves(z[k], 1);
    for (std::size_t j = 0; j < 2; ++j) {
      const auto x = halves(y[j], 0);
      parts[4 * k + 2 * j] = x[0];
      parts[4 * k + 2 * j + 1] = x[1];
    }
  }
  return parts;
}

std::size_t number(const Dims& cell, const Dims& cells) {
  return static_cast<std::size_t>(cell[0] + cells[0] * (cell[1] + cells[1] * cell[2]));
}

}  // namespace

MergedCells::MergedCells(const Block& block, std::span<const double> values, CellKind kind, double beta,
                         const ToleranceAt& tolerance_at)
    : solids_(block, values, kind, beta), kind_(kind), beta_(beta) {
  while (levels_.size() < kMostLevels) {
    auto next =
        next_level(levels_.empty() ? values : std::span<const double>(levels_.back()->values), tolerance_at);
    if (!next) return;
    levels_.push_back(std::move(next));
  }
}

Solids MergedCells::solids(int level) const {
  if (level == 0) return solids_;
  const Level& of = *levels_[static_cast<std::size_t>(level - 1)];
  return {of.block, of.values, kind_, beta_};
}

MergeTolerance MergedCells::missed_below(int level, const Dims& group) const {
  if (level == 0) {
    if (solids_.block().is_missing(group)) return {kNever, kNever};
    return {0, 0};
  }
  const Level& of = *levels_[static_cast<std::size_t>(level - 1)];
  return of.missed[number(group, of.block.cells())];
}

std::unique_ptr<const MergedCells::Level> MergedCells::next_level(std::span<const double> values,
                                                                  const ToleranceAt& tolerance_at) const {
  const int below = static_cast<int>(levels_.size());
  const Solids fine = solids(below);
  const Block& from = fine.block();
  if (*std::min_element(from.dims.begin(), from.dims.end()) < 3) return nullptr;
  auto level = std::make_unique<Level>();
  Block& to = level->block;
  for (std::size_t a = 0; a < 3; ++a) to.dims[a] = (from.dims[a] - 1) / 2 + 1;
  for (std::int64_t k = 0; k < to.dims[2]; ++k) {
    for (std::int64_t j = 0; j < to.dims[1]; ++j) {
      for (std::int64_t i = 0; i < to.dims[0]; ++i) {
        const std::size_t n = from.offset(2 * i, 2 * j, 2 * k);
        to.points.push_back(from.points[n]);
        level->values.push_back(values[n]);
      }
    }
  }
  const Solids coarse(to, level->values, kind_, beta_);
  const Dims groups = to.cells();
  level->missed.assign(static_cast<std::size_t>(to.cell_count()), {kNever, kNever});
  parallel_for(0, groups[1] * groups[2], 4, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      for (std::int64_t i = 0; i < groups[0]; ++i) {
        const Dims group{i, row % groups[1], row / groups[1]};
        const auto child = [&](std::int64_t n) -> Dims {
          return {2 * group[0] + n % 2, 2 * group[1] + n / 2 % 2, 2 * group[2] + n / 4};
        };
        bool all = true;
        for (std::int64_t n = 0; n < 8 && all; ++n) all = missed_below(below, child(n)).position < kNever;
        if (!all) continue;
        const Solid solid = coarse(group);
        const std::array<Solid, 8> parts = eighths(solid);
        MergeTolerance missed{0, 0};
        for (std::int64_t n = 0; n < 8; ++n) {
          const MergeTolerance before = missed_below(below, child(n));
          const MergeTolerance here = difference(parts[static_cast<std::size_t>(n)], fine(child(n)));
          missed.position = std::max(missed.position, before.position + here.position);
          missed.value = std::max(missed.value, before.value + here.value);
        }
        const MergeTolerance allowed = tolerance_at(solid.b[21].head<3>());
        if (missed.position <= allowed.position && missed.value <= allowed.value)
          level->missed[number(group, groups)] = missed;
      }
    }
  });
  const bool any = std::any_of(level->missed.begin(), level->missed.end(),
                               [](const MergeTolerance& m) { return m.position < kNever; });
  if (!any) return nullptr;
  return level;
}

int MergedCells::level(const Dims& cell) const {
  for (int level = static_cast<int>(levels_.size()); level > 0; --level) {
    const Dims groups = levels_[static_cast<std::size_t>(level - 1)]->block.cells();
    const Dims group{cell[0] >> level, cell[1] >> level, cell[2] >> level};
    if (group[0] >= groups[0] || group[1] >= groups[1] || group[2] >= groups[2]) continue;
    if (missed_below(level, group).position < kNever) return level;
  }
  return 0;
}

Solid MergedCells::solid(int level, const Dims& first) const {
  return solids(level)({first[0] >> level, first[1] >> level, first[2] >> level});
}

}  // namespace vol::curvilinear
