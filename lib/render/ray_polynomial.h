#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "render/bernstein.h"
#include "render/field_view.h"
#include "render/ray_box.h"
#include "volume/volume.h"

namespace vol::render {

/// The field on a stretch t0 <= t <= t1 of a ray: f(t) = p((t - t0) / (t1 - t0)).
struct RayPiece {
  double t0 = 0;
  double t1 = 0;
  Bernstein p;
  std::array<std::int64_t, 3> cell = {0, 0, 0};  ///< of a grid: its first sample
};

/// A stretch of a ray in one cell of a grid.
struct CellSpan {
  double t0 = 0;
  double t1 = 0;
  std::array<std::int64_t, 3> cell = {0, 0, 0};
};

/// Receives pieces front to back; returns false to stop.
using PieceSink = std::function<bool(const RayPiece&)>;

/// A reconstructed grid along a ray, cell by cell and without error: the product of the three axes' kernels,
/// each a polynomial of t within a cell. Degree 0 for nearest, 3 for trilinear, 9 for the cubics.
///
/// Points on a cell's face, but for the rounding of o + t d, are taken to be on it. So the field less a
/// sample value (`less`) is exactly 0 on plateaus of that value, and a trilinear piece's coefficients are on
/// the side of 0 that all of its cell's samples are on.
class GridPieces {
 public:
  /// Refers to the volume, which must live longer.
  /// \param less  subtracted from the samples before they are interpolated; b_spline then needs 16 bytes a
  /// voxel for a moment
  GridPieces(const volume::Volume& volume, volume::Reconstruction reconstruction,
             std::optional<double> less = {});

  /// Pieces of the chord, whose ends must lie in the grid's box. A point on a cell's face belongs to the
  /// piece the ray is entering.
  void operator()(const camera::Ray& ray, const Chord& chord, const PieceSink& sink) const;

  /// The same without the polynomials: f(CellSpan) returns false to stop.
  template <class F>
  void for_cells(const camera::Ray& ray, const Chord& chord, const F& f) const;
  /// The polynomial of a cell that for_cells() gave.
  [[nodiscard]] RayPiece piece(const camera::Ray& ray, const CellSpan& span) const;

  /// On which side of 0 all of a trilinear cell's samples are, and so its polynomials; none where they
  /// differ, and for other kernels.
  [[nodiscard]] std::optional<bool> at_least_zero(const std::array<std::int64_t, 3>& cell) const {
    return reconstruction_ == volume::Reconstruction::trilinear ? side_(samples_, geometry_.dims, cell, less_)
                                                                : std::nullopt;
  }

  /// World gradient of the field at t, t0 <= t <= t1, by the cell's own polynomial: on a face, from within.
  [[nodiscard]] Vec3 gradient(const camera::Ray& ray, const RayPiece& piece, double t) const;

 private:
  /// Weights of an axis's samples in a cell: polynomials in u = x - cell, by powers; sample index of each.
  struct AxisKernel {
    std::int64_t index[4];
    double power[4][4];
  };
  [[nodiscard]] AxisKernel kernel(int axis, std::int64_t cell) const;
  [[nodiscard]] Bernstein polynomial(const std::array<std::int64_t, 3>& cell, const Vec3& from,
                                     const Vec3& to) const;
  /// Coordinates within a cell of o + t d, index coordinates.
  [[nodiscard]] Vec3 local(const std::array<std::int64_t, 3>& cell, const Vec3& o, const Vec3& d,
                           double t) const;

  const volume::GridGeometry& geometry_;
  Mat3 world_to_index_;
  volume::Reconstruction reconstruction_;
  int taps_;
  double less_;
  bool shifted_;                 // sums are taken relative to `less`
  Buffer<double> coefficients_;  // of b_spline only
  const void* samples_;
  double (*load_)(const void*, std::int64_t);
  std::optional<bool> (*side_)(const void*, const Dims&, const std::array<std::int64_t, 3>&,
                               double) = nullptr;
};

template <class F>
void GridPieces::for_cells(const camera::Ray& ray, const Chord& chord, const F& f) const {
  const Vec3 o = world_to_index_ * (ray.origin - geometry_.origin);
  const Vec3 d = world_to_index_ * ray.direction;
  // Cells meet in planes at integers; those of nearest, around the samples, at integers and a half.
  const double shift = reconstruction_ == volume::Reconstruction::nearest ? 0.5 : 0;
  std::array<std::int64_t, 3> cell, cells;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t n = geometry_.dims[a];
    cells[a] = n == 1 ? 1 : shift > 0 ? n : n - 1;
    const auto n_a = static_cast<Eigen::Index>(a);
    const double x = o[n_a] + chord.entry * d[n_a] + shift;
    cell[a] = !(x > 0) || n == 1 ? 0 : std::min(static_cast<std::int64_t>(x), cells[a] - 1);
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto next_plane = [&](int a) {  // t at which the ray leaves its cell along an axis
    const auto n = static_cast<std::size_t>(a);
    const std::int64_t plane = d[a] > 0 ? cell[n] + 1 : cell[n];
    const bool last = d[a] == 0 || (d[a] > 0 ? plane >= cells[n] : plane <= 0);
    return last ? kInfinity : (static_cast<double>(plane) - shift - o[a]) / d[a];
  };
  double leave[3] = {next_plane(0), next_plane(1), next_plane(2)};
  double t = chord.entry;
  while (t < chord.exit) {
    const int axis = leave[0] <= leave[1] ? (leave[0] <= leave[2] ? 0 : 2) : (leave[1] <= leave[2] ? 1 : 2);
    const double end = std::min(leave[axis], chord.exit);
    if (end > t) {
      if (!f(CellSpan{t, end, cell})) return;
      t = end;
    }
    if (leave[axis] >= chord.exit) return;
    cell[static_cast<std::size_t>(axis)] += d[axis] > 0 ? 1 : -1;
    leave[axis] = next_plane(axis);
  }
}

/// Any field along a ray, by adaptive fits of degree 9 (see raycast_reference).
/// \returns the number of evaluations of the field
std::int64_t fit_pieces(const FieldView& field, const camera::Ray& ray, const Chord& chord,
                        const PieceSink& sink);

}  // namespace vol::render
