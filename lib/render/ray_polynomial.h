#pragma once
#include <functional>
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
};

/// Receives pieces front to back; returns false to stop.
using PieceSink = std::function<bool(const RayPiece&)>;

/// A reconstructed grid along a ray, cell by cell and without error: the product of the three axes' kernels,
/// each a polynomial of t within a cell. Degree 0 for nearest, 3 for trilinear, 9 for the cubics.
class GridPieces {
 public:
  /// Refers to the volume, which must live longer.
  GridPieces(const volume::Volume& volume, volume::Reconstruction reconstruction);

  /// Pieces of the chord, whose ends must lie in the grid's box. A point on a cell's face belongs to the
  /// piece the ray is entering.
  void operator()(const camera::Ray& ray, const Chord& chord, const PieceSink& sink) const;

 private:
  /// Weights of an axis's samples in a cell: polynomials in u = x - cell, by powers; sample index of each.
  struct AxisKernel {
    std::int64_t index[4];
    double power[4][4];
  };
  [[nodiscard]] AxisKernel kernel(int axis, std::int64_t cell) const;
  [[nodiscard]] Bernstein polynomial(const std::int64_t cell[3], const Vec3& from, const Vec3& to) const;

  const volume::GridGeometry& geometry_;
  Mat3 world_to_index_;
  volume::Reconstruction reconstruction_;
  int taps_;
  Buffer<double> coefficients_;  // of b_spline only
  const void* samples_;
  double (*load_)(const void*, std::int64_t);
};

/// Any field along a ray, by adaptive fits of degree 9 (see raycast_reference).
/// \returns the number of evaluations of the field
std::int64_t fit_pieces(const FieldView& field, const camera::Ray& ray, const Chord& chord,
                        const PieceSink& sink);

}  // namespace vol::render
