#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <string_view>

#include "curvilinear/grid.h"

namespace vol::curvilinear {

/// World position and value of the scalar.
using Point4 = Eigen::Vector4d;

/// How a cell becomes a solid: Catmull-Rom through the neighbouring points (C1 across cells), or the
/// trilinear map of its eight corners (C0).
enum class CellKind { tricubic, trilinear };

/// Tricubic Bezier solid of position and value after Bethel 1993: sum of b_rst B_r(u) B_s(v) B_t(w), B the
/// cubic Bernstein polynomials, (u, v, w) in [0,1]^3; b[r + 4 (s + 4 t)].
struct Solid {
  std::array<Point4, 64> b;

  [[nodiscard]] Point4 operator()(const Vec3& u) const;
  /// Position, value and their derivatives along u, v, w (the columns of `d`).
  [[nodiscard]] Point4 operator()(const Vec3& u, Eigen::Matrix<double, 4, 3>& d) const;
  /// The latter at (1/2, 1/2, 1/2).
  [[nodiscard]] Point4 centre(Eigen::Matrix<double, 4, 3>& d) const;
  /// The latter in the middle of the face where the parameter of an axis is 1.
  [[nodiscard]] Point4 face_centre(int axis, Eigen::Matrix<double, 4, 3>& d) const;
  /// Box of the control points, which holds the solid.
  [[nodiscard]] Box3 hull() const;
};

/// Control values of a cubic curve through samples as a linear map of them: b_r = sum_s w[r][s] P[first + s],
/// s < count.
///
/// Tricubic: with D_i = beta/2 (P[i+1] - P[i-1]), b_1 = P[i] + D_i/3 and b_2 = P[i+1] - D_{i+1}/3: offsets of
/// beta/6 (P[i+1] - P[i-1]). At the border D_0 = beta/2 (-3 P0 + 4 P1 - P2), of the same order (the paper
/// leaves it open); of two samples beta (P1 - P0). Trilinear: D = P[i+1] - P[i] at both ends of the cell. b_0
/// and b_3 are the samples to the bit.
struct CurveWeights {
  std::int64_t first = 0;
  int count = 0;
  double w[4][4] = {};
};
[[nodiscard]] CurveWeights curve_weights(std::int64_t cell, std::int64_t points, CellKind kind, double beta);

/// curve_weights() at work. Inner cells of tricubic solids, which are most, go by their two differences
/// alone; solids and faces both use it, so that their points are the same to the bit.
class CurveOperator {
 public:
  CurveOperator(std::int64_t cell, std::int64_t points, CellKind kind, double beta)
      : weights_(curve_weights(cell, points, kind, beta)),
        inner_(kind == CellKind::tricubic && cell > 0 && cell + 2 < points),
        offset_(beta / 6) {}
  [[nodiscard]] std::int64_t first() const { return weights_.first; }
  [[nodiscard]] int count() const { return weights_.count; }
  /// \param p  count() samples from first() on
  template <class Point>
  void operator()(const Point* p, Point (&b)[4]) const {
    if (inner_) {
      b[0] = p[1];
      b[1] = p[1] + offset_ * (p[2] - p[0]);
      b[2] = p[2] - offset_ * (p[3] - p[1]);
      b[3] = p[2];
      return;
    }
    for (int r = 0; r < 4; ++r) {
      b[r] = weights_.w[r][0] * p[0];
      for (int i = 1; i < weights_.count; ++i) b[r] += weights_.w[r][i] * p[i];
    }
  }

 private:
  CurveWeights weights_;
  bool inner_;
  double offset_;
};

/// The solids of a block. The curve operator along i, then j, then k: the tensor product, which gives the
/// mixed terms of the paper with their right signs (beta^2/36 (P++ - P-+ - P+- + P--)). Faces, edges and
/// corners of neighbours have the same control points to the bit. Refers to block and values, which must live
/// longer.
class Solids {
 public:
  /// \param values  of the block's points; empty: 0
  /// \param beta    tension, > 0 and finite; 1 is Catmull-Rom, of order 3, and reproduces linear maps
  Solids(const Block& block, std::span<const double> values, CellKind kind, double beta);
  [[nodiscard]] Solid operator()(const Dims& cell) const;
  [[nodiscard]] const Block& block() const { return *block_; }

 private:
  const Block* block_;
  std::span<const double> values_;
  CellKind kind_;
  double beta_;
};

}  // namespace vol::curvilinear
