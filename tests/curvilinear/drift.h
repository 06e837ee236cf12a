#pragma once
#include <algorithm>

#include "curvilinear/forward_difference.h"

namespace vol::curvilinear {

enum class SetUp { control_points, samples };

/// Largest distance of forward-differenced positions from direct evaluation in extended precision, over the
/// size of the cell (the largest edge of its box): of the last rows of the last planes, where errors have
/// grown longest, and of some between.
/// \param axes    1: along u alone, at v = w = 0; 3: the lattice of steps^3
/// \param origin  subtracted before the differences are made
template <class T>
double drift(const Solid& solid, int steps, int axes, SetUp set_up, const Point4& origin) {
  Lattice lattice;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool along = static_cast<int>(a) < axes;
    lattice.steps[a] = steps;
    lattice.counts[a] = along ? steps + 1 : 1;
  }
  auto f = set_up == SetUp::samples ? ForwardDifferences<T>::from_samples(solid, origin, lattice)
                                    : ForwardDifferences<T>(solid, origin, lattice);
  const auto looked_at = [&](int n, int count) { return n == count - 1 || n % std::max(1, count / 3) == 0; };
  long double worst = 0;
  for (int w = 0; w < lattice.counts[2]; ++w) {
    if (looked_at(w, lattice.counts[2])) {
      f.each_row([&](int v, Differences<T>& row) {
        if (!looked_at(v, lattice.counts[1])) return;
        for (int u = 0; u <= steps; ++u) {
          if (looked_at(u, steps + 1)) {
            const auto right = direct_point(solid, origin, lattice, {u, v, w});
            const Eigen::Array<long double, 4, 1> off = row.value().template cast<long double>() - right;
            worst = std::max(worst, off.template head<3>().abs().maxCoeff());
          }
          row.advance();
        }
      });
    }
    f.next_plane();
  }
  return static_cast<double>(worst) / solid.hull().size().maxCoeff();
}

/// Origin of cell-local coordinates: the middle of the control points' box and of their values.
inline Point4 local_origin(const Solid& solid) {
  Point4 low = solid.b[0], high = solid.b[0];
  for (const Point4& p : solid.b) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return 0.5 * (low + high);
}

}  // namespace vol::curvilinear
