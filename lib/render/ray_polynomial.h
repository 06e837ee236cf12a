#pragma once
#include <array>
#include <cstdint>
#include <functional>
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
};

/// Any field along a ray, by adaptive fits of degree 9 (see raycast_reference).
/// \returns the number of evaluations of the field
std::int64_t fit_pieces(const FieldView& field, const camera::Ray& ray, const Chord& chord,
                        const PieceSink& sink);

}  // namespace vol::render
