#pragma once
#include <Eigen/Core>
#include <array>

#include "curvilinear/solid.h"

namespace vol::curvilinear {

/// Evenly spaced points of a solid along its three parameters: u = (first + i) / steps and so on, i = 0 ..
/// count - 1.
struct Lattice {
  std::array<int, 3> steps{1, 1, 1};   ///< to the unit of the parameter, 1 to kMostSteps
  std::array<int, 3> counts{2, 2, 2};  ///< points, 1 or more
  Vec3 first{0, 0, 0};                 ///< 0: at the face; 1/2: middles of the steps
};
inline constexpr int kMostSteps = 4096;

/// Forward differences of a cubic along its parameter after Bethel 1993 (E M G of Kaufman 1987): value,
/// first, second and third difference. advance() takes the next point by three additions.
template <class T>
struct Differences {
  using Point = Eigen::Array<T, 4, 1>;
  std::array<Point, 4> d;
  [[nodiscard]] const Point& value() const { return d[0]; }
  void advance() {
    d[0] += d[1];
    d[1] += d[2];
    d[2] += d[3];
  }
};

/// Three-dimensional forward differences of a solid: the 4 x 4 x 4 differences along w, then v, then u. Rows
/// of a plane are cubics in v of cubics in u; sheets of the solid are planes of constant w.
///
/// Set up from control points the errors grow about as n eps of the coordinates, n the steps; so coordinates
/// are the cell's own: `origin` is subtracted before and is for the caller to add. In float that stays under
/// 1e-5 of the cell to kFloatSteps steps along each axis; in double it does always. Along an axis whose
/// points are its two ends alone, those of the line between them.
template <class T>
class ForwardDifferences {
 public:
  using Point = typename Differences<T>::Point;

  /// E M G along each axis, in double precision, then rounded to T.
  ForwardDifferences(const Solid& solid, const Point4& origin, const Lattice& lattice);
  /// For comparison: the differences of the 4^3 first points of the lattice, evaluated directly and rounded
  /// to T. Their errors grow as n^3 eps.
  [[nodiscard]] static ForwardDifferences from_samples(const Solid& solid, const Point4& origin,
                                                       const Lattice& lattice);

  /// The plane of points at the current w. \param visit (row v, Differences<T>& along u)
  template <class Visit>
  void each_row(const Visit& visit) const {
    std::array<Differences<T>, 4> rows;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j)
        rows[i].d[j] = i < orders_[0] && j < orders_[1] ? d_[i + 4 * j].value() : Point::Zero();
    }
    Differences<T> row;
    for (std::size_t i = orders_[0]; i < 4; ++i) row.d[i].setZero();
    for (int v = 0; v < lattice_.counts[1]; ++v) {
      for (std::size_t i = 0; i < orders_[0]; ++i) row.d[i] = rows[i].value();
      Differences<T> along_u = row;
      visit(v, along_u);
      for (std::size_t i = 0; i < orders_[0]; ++i) rows[i].advance();
    }
  }
  /// To the next w.
  void next_plane() {
    for (std::size_t j = 0; j < orders_[1]; ++j) {
      for (std::size_t i = 0; i < orders_[0]; ++i) d_[i + 4 * j].advance();
    }
  }
  [[nodiscard]] const Lattice& lattice() const { return lattice_; }

 private:
  ForwardDifferences() = default;
  /// d_[i + 4 j]: the difference of order i along u and j along v, and its differences along w.
  std::array<Differences<T>, 16> d_;
  Lattice lattice_;
  /// Differences along each axis that are not 0: of an axis whose points are its two ends, 2.
  std::array<std::size_t, 3> orders_{4, 4, 4};
};

/// Steps along each axis up to which float stays under 1e-5 of the cell (test_forward_difference).
inline constexpr int kFloatSteps = 16;

/// The same point by the Bernstein sum in extended precision, less origin: what drift is measured against.
[[nodiscard]] Eigen::Array<long double, 4, 1> direct_point(const Solid& solid, const Point4& origin,
                                                           const Lattice& lattice,
                                                           const std::array<int, 3>& at);

}  // namespace vol::curvilinear
