#pragma once
#include <array>
#include <cstdint>

namespace vol::isosurface {

/// The corner values of a cell, corner x + 2 y + 4 z, and the isovalue. All finite.
struct CellValues {
  std::array<double, 8> value{};
  double isovalue = 0;
};

/// What connects regions of a cell through its interior: a tube about one of the cell's diagonals.
enum class TubeKind : std::uint8_t { none, inside, outside };
struct Tube {
  TubeKind kind = TubeKind::none;
  std::uint8_t diagonal = 0;  ///< from corner `diagonal` (0 to 3) to corner 7 - diagonal
};

// The questions below are decided exactly: by floating point with a running bound of its error where that
// suffices, else in integers (128 bits, or as many as it takes). A tie counts as inside, which is the
// topology of the isovalue less any small enough e > 0.

/// Asymptotic decider (Nielson & Hamann 1991) of a face whose corners a, b, c, d, in cyclic order, are
/// a, c >= isovalue > b, d: are a and c joined on the face? With values relative to the isovalue the bilinear
/// saddle is (a c - b d) / (a + c - b - d), its denominator positive.
[[nodiscard]] bool face_joins_inside(double a, double b, double c, double d, double isovalue);

/// The tube that a saddle in the open cell may make, wherever the regions it would join are on the faces.
///
/// With f = a0 + a1 x + a2 y + a3 z + a12 xy + a13 xz + a23 yz + k xyz relative to the isovalue and
///   A1 = k a1 - a12 a13,  A2 = k a2 - a12 a23,  A3 = k a3 - a13 a23,  D = -A1 A2 A3,
///   C = k^2 a0 - k (a1 a23 + a2 a13 + a3 a12) + 2 a12 a13 a23
/// the gradient vanishes at most in two isolated points, which there are where D > 0. At one, p, the
/// Hessian's determinant is positive and the set inside has a bridge; at the other, q, it is negative and the
/// set outside has one. k^2 f(p) = C - 2 sqrt D, k^2 f(q) = C + 2 sqrt D, and C^2 - 4 D = k^2 H with Cayley's
/// hyperdeterminant H of the corner values, so that
///   f(p) >= 0  <=>  C > 0 and H >= 0,    f(q) < 0  <=>  C < 0 and H > 0;
/// never both. (For k = 0 one of the two is at infinity, and the same conditions hold for the other.)
/// Coordinates of p and q are compared with 0 and 1 without the root: see the implementation.
[[nodiscard]] Tube interior_tube(const CellValues& cell);

/// p or q as above in cell coordinates, rounded; the cell must have it.
[[nodiscard]] std::array<double, 3> saddle_position(const CellValues& cell, TubeKind kind);

}  // namespace vol::isosurface
