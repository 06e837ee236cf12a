#include "curvilinear/solid_path.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace vol::curvilinear {
namespace {

using render::Bernstein;

/// Point k of 9 on [0, 1]; those of even k are the 5 points of the lower degree.
double chebyshev(int k) {
  return k == 4 ? 0.5 : 0.5 - 0.5 * std::cos(std::numbers::pi * k / 8);
}

/// Samples at the degree + 1 points to Bernstein coefficients.
template <int degree>
const Eigen::Matrix<double, degree + 1, degree + 1>& to_bernstein() {
  using Matrix = Eigen::Matrix<double, degree + 1, degree + 1>;
  static const Matrix inverse = [] {
    Matrix values;
    for (int i = 0; i <= degree; ++i) {
      for (int k = 0; k <= degree; ++k) {
        Bernstein basis;
        basis.degree = degree;
        basis.b[k] = 1;
        values(i, k) = basis(chebyshev(i * (8 / degree)));
      }
    }
    return Matrix(values.inverse());
  }();
  return inverse;
}

/// Relative to the first sample, so that a constant stays one to the last bit.
template <int degree>
Bernstein interpolant(const double (&f)[9]) {
  Eigen::Matrix<double, degree + 1, 1> samples;
  for (int i = 0; i <= degree; ++i) samples[i] = f[i * (8 / degree)] - f[0];
  samples = to_bernstein<degree>() * samples;
  Bernstein p;
  p.degree = degree;
  for (int k = 0; k <= degree; ++k) p.b[k] = f[0] + samples[k];
  return p;
}

/// Part of a solid's map, for the search.
struct Part {
  std::array<Vec3, 64> b;
  Vec3 from = Vec3::Zero();
  Vec3 width = Vec3::Ones();
};

void halve(const Part& part, int axis, Part& left, Part& right) {
  left.from = right.from = part.from;
  left.width = right.width = part.width;
  left.width[axis] = right.width[axis] = 0.5 * part.width[axis];
  right.from[axis] += left.width[axis];
  const std::size_t stride = axis == 0 ? 1 : axis == 1 ? 4 : 16;
  for (std::size_t n = 0; n < 64; ++n) {
    if (n / stride % 4 != 0) continue;
    Vec3 c[4];
    for (std::size_t k = 0; k < 4; ++k) c[k] = part.b[n + k * stride];
    for (std::size_t level = 0; level < 4; ++level) {
      left.b[n + level * stride] = c[0];
      right.b[n + (3 - level) * stride] = c[3 - level];
      for (std::size_t k = 0; k + level < 3; ++k) c[k] = 0.5 * (c[k] + c[k + 1]);
    }
  }
}

}  // namespace

SolidPath::SolidPath(const Solid& solid, const camera::Ray& ray, const SolidInterval& interval,
                     int handedness)
    : solid_(solid), ray_(ray), handedness_(handedness) {
  least_ = most_ = solid.b[0][3];
  for (const Point4& p : solid.b) {
    least_ = std::min(least_, p[3]);
    most_ = std::max(most_, p[3]);
    scale_ = std::max(scale_, p.head<3>().cwiseAbs().maxCoeff());
  }
  entry_ = {interval.t0, interval.u0, Vec3::Zero(), 0};
  exit_ = {interval.t1, interval.u1, Vec3::Zero(), 0};
  // Until the ends have been solved: the straight line between them.
  entry_.slope = exit_.slope = (interval.u1 - interval.u0) / (interval.t1 - interval.t0);
}

Vec3 SolidPath::guess(const Node& a, const Node& b, double t) const {
  const double h = b.t - a.t;
  if (!(h > 0)) return a.u;
  const double x = (t - a.t) / h, y = 1 - x;
  const Vec3 line = y * a.u + x * b.u;
  const Vec3 chord = b.u - a.u;
  // Hermite's cubic as the line and what the slopes differ from it.
  const Vec3 bent = line + x * y * (y * (h * a.slope - chord) - x * (h * b.slope - chord));
  if (!((bent - line).cwiseAbs().maxCoeff() < 0.5)) return line;  // a singular end; NaN too
  return bent.cwiseMax(0).cwiseMin(1);
}

bool SolidPath::newton(const Vec3& p, Node& node) {
  Vec3 u = node.u;
  Eigen::Matrix<double, 4, 3> d;
  for (int step = 0; step < 12; ++step) {
    const Point4 x = solid_(u, d);
    ++evaluations_;
    const Mat3 jacobian = d.topRows<3>();
    const Vec3 rest = p - x.head<3>();
    const Vec3 vw = jacobian.col(1).cross(jacobian.col(2)), wu = jacobian.col(2).cross(jacobian.col(0)),
               uv = jacobian.col(0).cross(jacobian.col(1));
    const double det = jacobian.col(0).dot(vw);
    const auto solved = [&](const Vec3& r) {
      return Vec3(vw.dot(r) / det, wu.dot(r) / det, uv.dot(r) / det);
    };
    Vec3 du = solved(rest);
    const double size = du.cwiseAbs().maxCoeff();
    // Quadratic: from 1e-7 the next point is known to 1e-14. At a collapsed edge the parameters are not
    // unique; there it counts that the point is met.
    const bool close = size < 1e-7, met = rest.cwiseAbs().maxCoeff() <= 4e-16 * scale_;
    if (close || met) {
      if (!close) du.setZero();
      node.u = u + du;
      constexpr double kBeside = 1e-6;
      if (node.u.minCoeff() < -kBeside || node.u.maxCoeff() > 1 + kBeside) return false;
      node.f = std::clamp(x[3] + d.row(3).dot(du), least_, most_);
      node.slope = solved(ray_.direction);
      if (!node.slope.allFinite()) node.slope.setZero();
      return true;
    }
    if (!(size < std::numeric_limits<double>::infinity())) return false;
    if (size > 0.5) du *= 0.5 / size;
    u = (u + du).cwiseMax(-0.05).cwiseMin(1.05);
  }
  return false;
}

SolidPath::Node SolidPath::solve(double t, const Vec3& start) {
  const Vec3 p = ray_.origin + t * ray_.direction;
  Node node{t, start, Vec3::Zero(), 0};
  if (newton(p, node)) return node;
  node.u = search(p);
  if (newton(p, node)) return node;
  Eigen::Matrix<double, 4, 3> d;
  node.f = std::clamp(solid_(node.u, d)[3], least_, most_);
  node.slope.setZero();
  return node;
}

Vec3 SolidPath::search(const Vec3& p) {
  constexpr int kMostParts = 2000;
  const double margin = 1e-12 * scale_;
  std::vector<Part> stack(1);
  for (std::size_t n = 0; n < 64; ++n) stack[0].b[n] = solid_.b[n].head<3>();
  Vec3 nearest = Vec3::Constant(0.5), other = nearest;
  double distance = std::numeric_limits<double>::infinity();
  bool has_other = false;
  for (int parts = 0; !stack.empty() && parts < kMostParts; ++parts) {
    const Part part = stack.back();
    stack.pop_back();
    Vec3 low = part.b[0], high = low;
    for (const Vec3& b : part.b) {
      low = low.cwiseMin(b);
      high = high.cwiseMax(b);
    }
    if (((p - low).array() < -margin).any() || ((high - p).array() < -margin).any()) continue;
    Node node;
    node.u = part.from + 0.5 * part.width;
    const Vec3 centre = node.u;
    if (newton(p, node)) {
      const Vec3 u = node.u.cwiseMax(0).cwiseMin(1);
      Eigen::Matrix<double, 4, 3> d;
      (void)solid_(u, d);
      if (handedness_ * d.topRows<3>().determinant() > 0) return u;
      other = u;  // on the sheet that is turned over: only if there is no other
      has_other = true;
    }
    const double away = (solid_(centre).head<3>() - p).norm();
    if (away < distance) {
      distance = away;
      nearest = centre;
    }
    int axis = 0;
    part.width.maxCoeff(&axis);
    if (part.width[axis] < 1e-6) continue;
    stack.resize(stack.size() + 2);
    halve(part, axis, stack[stack.size() - 1], stack[stack.size() - 2]);
  }
  return has_other ? other : nearest;
}

bool SolidPath::pieces(double t0, double t1, double tolerance, const render::PieceSink& sink) {
  if (least_ == most_) {
    render::RayPiece piece{t0, t1, {}};
    piece.p.b[0] = least_;
    return sink(piece);
  }
  sink_ = &sink;
  // Values carry the rounding of the positions: 1e-14 of the solid's own range, and of themselves.
  const double largest = std::max(std::abs(least_), std::abs(most_));
  tolerance_ = std::max(tolerance, 1e-14 * (most_ - least_) + 4e-15 * largest);
  entry_ = solve(entry_.t, entry_.u);
  exit_ = solve(exit_.t, exit_.u);
  const Node a = t0 == entry_.t ? entry_ : solve(t0, guess(entry_, exit_, t0));
  const Node b = t1 == exit_.t ? exit_ : solve(t1, guess(entry_, exit_, t1));
  return fit(a, b, 0, std::numeric_limits<double>::infinity());
}

bool SolidPath::fit(const Node& a, const Node& b, int depth, double parent_residual) {
  const double h = b.t - a.t;
  double f[9] = {a.f, 0, 0, 0, 0, 0, 0, 0, b.f};
  const Node middle = solve(0.5 * (a.t + b.t), guess(a, b, 0.5 * (a.t + b.t)));
  f[4] = middle.f;
  const auto at = [&](double x) {
    const double t = a.t + x * h;
    return solve(t, x < 0.5 ? guess(a, middle, t) : guess(middle, b, t)).f;
  };
  const auto sample = [&](int k) { f[k] = at(chebyshev(k)); };
  for (const int k : {2, 6, 1, 5}) sample(k);
  render::RayPiece piece{a.t, b.t, interpolant<4>(f)};
  const auto residual_at = [&](double x, double value) { return std::abs(piece.p(x) - value); };
  if (std::max(residual_at(chebyshev(1), f[1]), residual_at(chebyshev(5), f[5])) <= tolerance_) {
    return (*sink_)(piece);
  }
  for (const int k : {3, 7}) sample(k);
  piece.p = interpolant<8>(f);
  const double residual = std::max(residual_at(0.09, at(0.09)), residual_at(0.58, at(0.58)));
  // Halving divides the residual of a smooth stretch by 2^9. Where it hardly shrinks and is small already, it
  // is rounding; 40 halvings reach the last digits of t, and what is left there is a jump, in a fold.
  const bool noise = residual <= 1e-9 * (most_ - least_) && residual > 0.1 * parent_residual;
  if (residual <= tolerance_ || noise || depth >= 40 || !(middle.t > a.t && middle.t < b.t)) {
    return (*sink_)(piece);
  }
  return fit(a, middle, depth + 1, residual) && fit(middle, b, depth + 1, residual);
}

Vec3 SolidPath::gradient(double t) {
  const Node node = solve(t, guess(entry_, exit_, t));
  Eigen::Matrix<double, 4, 3> d;
  (void)solid_(node.u, d);
  const Mat3 jacobian = d.topRows<3>();
  const Vec3 gradient = jacobian.transpose().inverse() * d.row(3).transpose();
  return gradient.allFinite() ? gradient : Vec3::Zero();
}

}  // namespace vol::curvilinear
