#pragma once
#include <cstdint>

#include "curvilinear/ray_solids.h"
#include "render/ray_polynomial.h"

namespace vol::curvilinear {

/// The field of one solid along a ray: f(t) = value at (u, v, w), x(u, v, w) = o + t d.
///
/// The parameters are found by Newton from the cubic through the ends of a stretch, whose parameters and
/// slopes are known; where that does not converge inside the solid, by halving it (hulls that do not hold the
/// point are dropped) and Newton from what is left. Where a solid covers a point several times, in a fold,
/// any of its values may come.
class SolidPath {
 public:
  /// \param handedness  sign of the Jacobian that is preferred where the solid is folded
  SolidPath(const Solid& solid, const camera::Ray& ray, const SolidInterval& interval, int handedness);

  /// The smallest and largest control value: the field is between.
  [[nodiscard]] double least() const { return least_; }
  [[nodiscard]] double most() const { return most_; }

  /// Polynomials of degree 4 or 8 through f at Chebyshev's extreme points, on pieces of [t0, t1] halved until
  /// f between the points is met to within `tolerance` (or its rounding). \returns false if the sink stops
  bool pieces(double t0, double t1, double tolerance, const render::PieceSink& sink);

  /// World gradient of the field at t; 0 where the map is singular.
  [[nodiscard]] Vec3 gradient(double t);

  /// Of the solid, so far.
  [[nodiscard]] std::int64_t evaluations() const { return evaluations_; }

 private:
  /// A point of the path, and the slopes of its parameters by t.
  struct Node {
    double t = 0;
    Vec3 u, slope;
    double f = 0;
  };
  [[nodiscard]] Vec3 guess(const Node& a, const Node& b, double t) const;
  [[nodiscard]] Node solve(double t, const Vec3& start);
  [[nodiscard]] bool newton(const Vec3& p, Node& node);
  [[nodiscard]] Vec3 search(const Vec3& p);
  bool fit(const Node& a, const Node& b, int depth, double parent_residual);

  const Solid& solid_;
  const camera::Ray& ray_;
  int handedness_;
  Node entry_, exit_;
  double least_ = 0, most_ = 0;
  double scale_ = 0;  ///< largest coordinate: what positions are rounded relative to
  double tolerance_ = 0;
  const render::PieceSink* sink_ = nullptr;
  std::int64_t evaluations_ = 0;
};

}  // namespace vol::curvilinear
