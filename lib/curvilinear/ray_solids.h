#pragma once
#include <vector>

#include "curvilinear/face_tree.h"
#include "curvilinear/ray_patch.h"

namespace vol::curvilinear {

/// A stretch t0 < t < t1 of a ray in the solid of one cell, with the solid's parameters at its ends.
struct SolidInterval {
  std::uint32_t block = 0;
  Dims cell{};
  double t0 = 0, t1 = 0;
  Vec3 u0, u1;
  /// How often the solid covers the stretch: 1; where it is folded or turned over also 2, -1, ...
  int degree = 1;
};

/// The part t0 < t < t1 of an interval that is drawn in its solid.
struct RaySegment {
  SolidInterval in;
  double t0 = 0, t1 = 0;
};

/// A passage of the ray through a face.
struct Crossing {
  Face face;
  PatchHit hit;
  double t = 0;
};

/// What one ray needs while it is cast; keep it for the next one.
struct RayScratch {
  std::vector<PatchHit> hits;
  std::vector<Crossing> crossings;
  struct Change {
    std::uint64_t cell;
    double t;
    int by;
    std::uint32_t crossing;
    bool before;
  };
  std::vector<Change> changes;
  std::vector<SolidInterval> intervals;
};

/// Rays through the solids of a grid.
///
/// The crossings are found face by face, each face once, and each changes the degree of the cells on its two
/// sides by opposite amounts at the same t. What a ray leaves, it enters next, therefore, to the bit; and
/// since the windings of a cell's faces sum to 0 (ray_patch.h), a cell that is entered is left. There is
/// nothing between cells that a ray could slip through or count twice, at edges and corners either.
///
/// The degree of a point in a grid is the sum over its cells: a fold, where the solids cover a point with
/// Jacobians of one sign, of the other and of the one again, counts once.
class SolidRays {
 public:
  /// Refers to the grid and the values, which must live longer.
  /// \param values  one list a block, or none at all: 0
  /// \throws vol::Error as Solids does; where no cell is left
  SolidRays(const Grid& grid, const std::vector<std::vector<double>>& values, CellKind kind, double beta);

  /// All passages of the line of the ray through faces, in no order.
  void crossings(const camera::Ray& ray, RayScratch& scratch) const;

  /// Where the ray's line is in which solid, cell by cell, degrees other than 0 only. In scratch.intervals.
  /// \returns false where a cell's changes do not sum to 0, which cannot happen
  bool intervals(const camera::Ray& ray, RayScratch& scratch) const;

  /// The stretches from t_min on where the degree of all cells together is positive, front to back, none
  /// overlapping; each given to one solid that covers it: of several, to the one that was entered first.
  void segments(const camera::Ray& ray, double t_min, RayScratch& scratch,
                std::vector<RaySegment>& segments) const;

  [[nodiscard]] Solid solid(const SolidInterval& at) const { return solids_[at.block](at.cell); }
  [[nodiscard]] const Grid& grid() const { return *grid_; }
  /// Largest less smallest value of the points.
  [[nodiscard]] double value_range() const { return value_range_; }
  [[nodiscard]] const FaceTree& faces() const { return faces_; }
  /// Sign of the block's volume.
  [[nodiscard]] int handedness(std::uint32_t block) const { return handedness_[block]; }

 private:
  const Grid* grid_;
  CellKind kind_;
  double beta_;
  std::vector<Solids> solids_;
  std::vector<int> handedness_;
  FaceTree faces_;
  double value_range_ = 0;
};

}  // namespace vol::curvilinear
