#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "curvilinear/solid.h"

namespace vol::curvilinear {

/// By how much a solid may miss those that it stands for.
struct MergeTolerance {
  double position, value;
};

/// Cells of a block drawn as one: Bezier solids through every second point, every fourth and so on, of groups
/// of 2^level cells along each axis, where these miss the cells' own solids by no more than a tolerance. As
/// solids differ by no more than their control points do, the bound is that of the control points of a
/// group's eight halves less those of the groups below, summed over the levels.
class MergedCells {
 public:
  static constexpr int kMostLevels = 4;

  using ToleranceAt = std::function<MergeTolerance(const Vec3&)>;  ///< at a point of the block

  /// Refers to block and values, which must live longer.
  MergedCells(const Block& block, std::span<const double> values, CellKind kind, double beta,
              const ToleranceAt& tolerance_at);

  /// Of the largest group that holds a cell; 0: the cell by itself.
  [[nodiscard]] int level(const Dims& cell) const;
  /// Of a group (level 1 and more) by its first cell.
  [[nodiscard]] Solid solid(int level, const Dims& first) const;

 private:
  struct Level {
    Block block;
    std::vector<double> values;
    std::vector<MergeTolerance> missed;  ///< by each group; infinite where it is not drawn
  };
  Solids solids_;
  CellKind kind_;
  double beta_;
  std::vector<std::unique_ptr<const Level>> levels_;

  [[nodiscard]] Solids solids(int level) const;
  [[nodiscard]] std::unique_ptr<const Level> next_level(std::span<const double> values,
                                                        const ToleranceAt& tolerance_at) const;
  [[nodiscard]] MergeTolerance missed_below(int level, const Dims& group) const;
};

}  // namespace vol::curvilinear
