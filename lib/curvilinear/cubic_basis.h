#pragma once

namespace vol::curvilinear {

/// The cubic Bernstein polynomials at u, b[i] = C(3, i) (1 - u)^(3-i) u^i, and their derivatives d[i].
struct CubicBasis {
  double b[4], d[4];
  explicit CubicBasis(double u) {
    const double v = 1 - u;
    b[0] = v * v * v;
    b[1] = 3 * u * v * v;
    b[2] = 3 * u * u * v;
    b[3] = u * u * u;
    d[0] = -3 * v * v;
    d[1] = 3 * v * (v - 2 * u);
    d[2] = 3 * u * (2 * v - u);
    d[3] = 3 * u * u;
  }
};

}  // namespace vol::curvilinear
