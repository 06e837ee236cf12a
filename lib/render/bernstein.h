#pragma once
#include <array>
#include <vector>

namespace vol::render {

/// Polynomial on [0, 1] by its Bernstein coefficients: p(u) = sum_k b[k] C(n,k) u^k (1-u)^(n-k). Its graph
/// lies in the hull of the coefficients, which is what root isolation and bounds rest on (Farouki & Rajan
/// 1987: among all such bases the one whose values move least when the coefficients are rounded).
struct Bernstein {
  static constexpr int kMaxDegree = 9;

  int degree = 0;
  std::array<double, kMaxDegree + 1> b{};

  [[nodiscard]] double operator()(double u) const;
  [[nodiscard]] double min() const;  ///< of the coefficients: a lower bound of p
  [[nodiscard]] double max() const;
  /// Integral over [0, 1]: the mean of the coefficients.
  [[nodiscard]] double integral() const;
  /// p', of one degree less; 0 for degree 0.
  [[nodiscard]] Bernstein derivative() const;
  /// The two halves, each on [0, 1] again (de Casteljau).
  void halve(Bernstein& left, Bernstein& right) const;
  /// The same of [0, u] and [u, 1], u in [0, 1].
  void split(double u, Bernstein& left, Bernstein& right) const;
};

/// Of the polynomial sum_k powers[k] s^k, |s| <= 1/2, with u = s + 1/2.
[[nodiscard]] Bernstein bernstein_of_powers(std::array<double, Bernstein::kMaxDegree + 1> powers);

/// Appends all u in (0, 1) where p(u) = value and changes sign, ascending, to within 1e-15. Roots of even
/// order, where p only touches the value, may appear (once or in a close cluster) or not.
void append_crossings(const Bernstein& p, double value, std::vector<double>& roots);

/// Largest value on [0, 1] and where it is taken, to within `tolerance` of the value. Looks only for values
/// above `at_least`, and returns false where there is none.
bool find_maximum(const Bernstein& p, double at_least, double tolerance, double& maximum, double& where);

}  // namespace vol::render
