#pragma once
#include <array>

namespace vol::render {

/// Gauss-Legendre collocation on [0, 1]: nodes x, weights w, the integrals of the nodes' Lagrange polynomials
/// up to each node, and the analysis that yields the two highest Legendre coefficients of a sampled function.
struct GaussCollocation {
  static constexpr int kNodes = 12;
  using Row = std::array<double, kNodes>;

  Row x;
  Row w;
  std::array<Row, kNodes> up_to;  ///< up_to[i][j] = integral_0^x[i] of the j-th Lagrange polynomial
  Row coefficient_last;           ///< Legendre coefficient of degree kNodes - 1: dot product with the samples
  Row coefficient_before;         ///< of degree kNodes - 2
};
[[nodiscard]] const GaussCollocation& gauss_collocation();

/// Integral of f over [a, b] by adaptive 7-15 Gauss-Kronrod quadrature to an absolute tolerance.
template <class F>
double gauss_kronrod(const F& f, double a, double b, double tolerance, int depth = 0) {
  // Abscissae and weights: Piessens et al., QUADPACK, 1983, routine QK15.
  static constexpr double kX[8] = {0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
                                   0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
                                   0.586087235467691130294144691693013, 0.405845151377397166906606412076961,
                                   0.207784955007898467600689403773245, 0};
  static constexpr double kK[8] = {0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
                                   0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
                                   0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
                                   0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
  static constexpr double kG[4] = {0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
                                   0.381830050505118944950369775488975, 0.417959183673469387755102040816327};
  const double centre = 0.5 * (a + b);
  const double half = 0.5 * (b - a);
  double kronrod = 0;
  double gauss = 0;
  for (int i = 0; i < 8; ++i) {
    const double y = i == 7 ? f(centre) : f(centre - half * kX[i]) + f(centre + half * kX[i]);
    kronrod += kK[i] * y;
    if (i % 2 == 1) gauss += kG[i / 2] * y;
  }
  const double difference = half * (kronrod > gauss ? kronrod - gauss : gauss - kronrod);
  // The difference is the error of the 7-point rule; the 15-point rule is far better. 48 halvings exhaust the
  // digits of a singular end.
  if (!(difference > tolerance) || depth == 48) return half * kronrod;
  return gauss_kronrod(f, a, centre, 0.7 * tolerance, depth + 1) +
         gauss_kronrod(f, centre, b, 0.7 * tolerance, depth + 1);
}

}  // namespace vol::render
