#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "fit/least_squares.h"

namespace vol::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The unknowns that are free, solved by QR with the others held.
VectorXd solve_free(const MatrixXd& a, const VectorXd& b, const std::vector<Index>& free) {
  MatrixXd columns(a.rows(), static_cast<Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) columns.col(static_cast<Index>(k)) = a.col(free[k]);
  return columns.completeOrthogonalDecomposition().solve(b);
}

/// min ||E u - f|| with u >= 0 (Lawson & Hanson 1974, chapter 23, algorithm NNLS).
VectorXd non_negative(const MatrixXd& e, const VectorXd& f) {
  const Index m = e.cols();
  VectorXd u = VectorXd::Zero(m);
  std::vector<Index> free;
  // Below this a gradient is rounding: the sums of E'(f - E u).
  const double zero = 64 * std::numeric_limits<double>::epsilon() * e.norm() * f.norm();
  for (Index round = 0; round < 10 * m; ++round) {
    const VectorXd gradient = e.transpose() * (f - e * u);
    Index best = -1;
    for (Index i = 0; i < m; ++i) {
      if (std::find(free.begin(), free.end(), i) != free.end()) continue;
      if (gradient[i] > zero && (best < 0 || gradient[i] > gradient[best])) best = i;
    }
    if (best < 0) return u;
    free.push_back(best);
    while (!free.empty()) {
      const VectorXd z = solve_free(e, f, free);
      double way = 1;
      for (std::size_t k = 0; k < free.size(); ++k) {
        const double at = z[static_cast<Index>(k)];
        if (at <= 0) way = std::min(way, u[free[k]] / (u[free[k]] - at));
      }
      if (free.back() == best && z[static_cast<Index>(free.size()) - 1] <= 0)
        return u;  // rounding alone wanted it
      for (std::size_t k = 0; k < free.size(); ++k)
        u[free[k]] += way * (z[static_cast<Index>(k)] - u[free[k]]);
      if (way == 1) break;
      std::erase_if(free, [&](Index i) {
        if (u[i] > 1e-300) return false;
        u[i] = 0;
        return true;
      });
    }
  }
  return u;
}

/// Every place where the curve is farthest out of its bounds, or nearest to them from within, and by how
/// much.
std::vector<std::pair<double, double>> farthest_out(const VectorXd& p, double least, double most) {
  const std::span<const double> points(p.data(), static_cast<std::size_t>(p.size()));
  const auto out = [&](double value) { return std::max(least - value, value - most); };
  std::vector<std::pair<double, double>> found{{0, out(points.front())}, {1, out(points.back())}};
  // A polynomial of degree 20 has at most 19 extremes; each where the slope changes sign, by bisection.
  constexpr int kFine = 1024;
  auto before = transfer::de_casteljau(points, 0);
  for (int i = 1; i <= kFine; ++i) {
    double lo = double(i - 1) / kFine, hi = double(i) / kFine;
    const auto here = transfer::de_casteljau(points, hi);
    if ((before.slope > 0) != (here.slope > 0)) {
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (lo + hi);
        ((transfer::de_casteljau(points, middle).slope > 0) == (before.slope > 0) ? lo : hi) = middle;
      }
      found.emplace_back(lo, out(transfer::de_casteljau(points, lo).value));
    }
    before = here;
  }
  return found;
}

}  // namespace

bool solve_bounded(const Triangle& problem, double least, double most, VectorXd& p) {
  const Index n = p.size();
  std::vector<bool> held(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) held[static_cast<std::size_t>(i)] = p[i] <= least || p[i] >= most;
  // A gradient below this is what rounding leaves of sums of products of this size.
  const double zero = 16 * static_cast<double>(n) * std::numeric_limits<double>::epsilon() *
                      problem.r.norm() * (problem.c.norm() + problem.r.norm() * p.norm());
  for (Index exchange = 0; exchange < 50 * n; ++exchange) {
    std::vector<Index> free;
    VectorXd rest = problem.c;
    for (Index i = 0; i < n; ++i) {
      if (held[static_cast<std::size_t>(i)]) {
        rest -= p[i] * problem.r.col(i);
      } else {
        free.push_back(i);
      }
    }
    if (!free.empty()) {
      const VectorXd z = solve_free(problem.r, rest, free);
      double way = 1;
      Index first = -1;
      for (std::size_t k = 0; k < free.size(); ++k) {
        const double from = p[free[k]], to = z[static_cast<Index>(k)];
        const double edge = to < least ? least : to > most ? most : to;
        if (edge == to) continue;
        const double part = (edge - from) / (to - from);
        if (first < 0 || part < way) {
          way = part;
          first = free[k];
        }
      }
      for (std::size_t k = 0; k < free.size(); ++k) {
        const Index i = free[k];
        p[i] = std::clamp(p[i] + way * (z[static_cast<Index>(k)] - p[i]), least, most);
      }
      if (first >= 0) {
        p[first] = p[first] - least < most - p[first] ? least : most;
        held[static_cast<std::size_t>(first)] = true;
        continue;
      }
    }
    const VectorXd gradient = problem.r.transpose() * (problem.r * p - problem.c);
    Index worst = -1;
    double pull = zero;
    for (Index i = 0; i < n; ++i) {
      if (!held[static_cast<std::size_t>(i)]) continue;
      const double inward = p[i] == least ? -gradient[i] : gradient[i];
      if (inward > pull) {
        pull = inward;
        worst = i;
      }
    }
    if (worst < 0) return true;
    held[static_cast<std::size_t>(worst)] = false;
  }
  return false;
}

namespace {

/// The problem of solve_curve_bounded() for curves of the size of 1.
VectorXd solve_scaled(const Triangle& problem, double least, double most) {
  const Index n = problem.r.cols();
  std::vector<double> places;
  const int first = 4 * static_cast<int>(n);
  for (int i = 0; i <= first; ++i) places.push_back(static_cast<double>(i) / first);
  const auto r = problem.r.triangularView<Eigen::Upper>();
  const VectorXd origin = r.solve(problem.c);
  constexpr double kKept = 1e-9;
  for (int exchange = 0; exchange < 40; ++exchange) {
    // With z = R p - c the curve at a place is g'(z + c), g' = b' R^-1: at least `least`, at most `most`.
    const auto m = static_cast<Index>(places.size());
    MatrixXd basis(n, m);
    for (Index k = 0; k < m; ++k) {
      std::vector<double> b(static_cast<std::size_t>(n));
      transfer::bernstein_basis(places[static_cast<std::size_t>(k)], b);
      basis.col(k) = Eigen::Map<const VectorXd>(b.data(), n);
    }
    const MatrixXd g = problem.r.transpose().triangularView<Eigen::Lower>().solve(basis);
    const VectorXd at_origin = basis.transpose() * origin;
    MatrixXd e(n + 1, 2 * m);
    e.topLeftCorner(n, m) = g;
    e.topRightCorner(n, m) = -g;
    e.row(n).head(m) = (VectorXd::Constant(m, least) - at_origin).transpose();
    e.row(n).tail(m) = (at_origin - VectorXd::Constant(m, most)).transpose();
    e.colwise().normalize();  // no matter to u >= 0, but a bound far away must not hide the others in its rounding
    VectorXd f = VectorXd::Zero(n + 1);
    f[n] = 1;
    const VectorXd residual = e * non_negative(e, f) - f;
    const VectorXd z = -residual.head(n) / residual[n];
    const VectorXd p = origin + r.solve(z);
    const auto farthest = farthest_out(p, least, most);
    bool kept = true;
    for (const auto& [place, out] : farthest) {
      if (out <= kKept) continue;
      kept = false;
      places.push_back(place);
    }
    if (kept) return p;
  }
  throw Error("bounds on the curve could not be kept to 1e-9; bound the control points instead");
}

}  // namespace

// The polynomials sum to 1: with p = least + size q the curve is least + size times that of the q, and
// R p - c is size (R q - (c - R least)/size).
VectorXd solve_curve_bounded(const Triangle& problem, double least, double most) {
  const VectorXd lowest = VectorXd::Constant(problem.r.cols(), least);
  const VectorXd origin = problem.r.triangularView<Eigen::Upper>().solve(problem.c);
  // Of bounds far wider than the curve its own size counts.
  const double size = std::min(most - least, (origin - lowest).cwiseAbs().maxCoeff());
  if (!(size > 0)) return lowest;  // it is that curve
  const Triangle scaled{problem.r, (problem.c - problem.r * lowest) / size};
  return lowest + size * solve_scaled(scaled, 0, (most - least) / size);
}

}  // namespace vol::fit
