#include "wavelet/filter_design.h"

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/error.h"
#include "wavelet/filters.h"

namespace vol::wavelet {
namespace {

using Real = long double;
using Complex = std::complex<Real>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

constexpr Real kPi = std::numbers::pi_v<Real>;
constexpr Real kSqrt2 = std::numbers::sqrt2_v<Real>;

/// All roots of sum_k a[k] y^k at once (Durand and Kerner), to long double rounding.
std::vector<Complex> roots(std::vector<Real> a) {
  const auto n = a.size() - 1;
  const Real lead = a.back();
  for (auto& x : a) x /= lead;
  std::vector<Complex> y(n);
  for (std::size_t i = 0; i < n; ++i) y[i] = std::pow(Complex(0.4L, 0.9L), static_cast<Real>(i));
  for (int step = 0; step < 400; ++step) {
    Real moved = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Complex value = 1;
      for (std::size_t k = n; k-- > 0;) value = value * y[i] + a[k];
      Complex others = 1;
      for (std::size_t j = 0; j < n; ++j) {
        if (j != i) others *= y[i] - y[j];
      }
      y[i] -= value / others;
      moved = std::max(moved, std::abs(value / others) / std::abs(y[i]));
    }
    if (moved < 4e-19L) break;
  }
  return y;
}

/// Daubechies' branch to five digits: where Gauss-Newton starts, not what it returns.
const std::vector<Real>& coiflet_start(int order) {
  static const std::vector<std::vector<Real>> start = {
      {-.07273L, .33790L, .85257L, .38486L, -.07273L, -.01566L},
      {.01639L, -.04146L, -.06737L, .38611L, .81272L, .41701L, -.07649L, -.05943L, .02368L, .00561L, -.00182L,
       -.00072L},
      {-.00379L, .00778L, .02345L, -.06577L, -.06112L, .40518L, .79378L, .42848L, -.07180L, -.08230L, .03456L,
       .01588L, -.00901L, -.00257L, .00112L, .00047L, -.00007L, -.00003L},
      {.00089L, -.00163L, -.00735L, .01607L,  .02668L, -.08127L, -.05608L, .41531L,
       .78224L, .43439L,  -.06663L, -.09622L, .03933L, .02508L,  -.01521L, -.00566L,
       .00375L, .00127L,  -.00059L, -.00026L, .00006L, .00003L,  0,        0},
      {-.00021L, .00036L,  .00218L,  -.00416L, -.01013L, .02341L,  .02817L,  -.09192L, -.05205L, .42157L,
       .77429L,  .43798L,  -.06204L, -.10556L, .04129L,  .03267L,  -.01976L, -.00916L, .00676L,  .00243L,
       -.00166L, -.00064L, .00030L,  .00014L,  -.00004L, -.00002L, 0,        0,        0,        0}};
  return start.at(static_cast<std::size_t>(order - 1));
}

/// Residuals of the defining equations and their Jacobian. With K the order, L = 6K taps and u = (n - 2K) /
/// (3K):
///   sum h = sqrt 2;  sum h[n] h[n + 2s] = delta_s, s < 3K;
///   sum (-1)^n u^j h[n] = 0, j < 2K;   sum u^j h[n] = 0, 1 <= j < 2K.
/// One more equation than unknowns a moment: consistent, so that Gauss-Newton converges quadratically.
void coiflet_equations(int order, const Vector& h, Vector& residual, Matrix& jacobian) {
  const int taps = 6 * order;
  residual.setZero(7 * order);
  jacobian.setZero(7 * order, taps);
  int row = 0;
  const auto moment = [&](bool alternating, int power, Real target) {
    for (int n = 0; n < taps; ++n) {
      const Real u = static_cast<Real>(n - 2 * order) / static_cast<Real>(3 * order);
      jacobian(row, n) = (alternating && n % 2 == 1 ? -1 : 1) * (power == 0 ? 1 : std::pow(u, power));
    }
    residual(row) = jacobian.row(row).dot(h) - target;
    ++row;
  };
  moment(false, 0, kSqrt2);
  for (int j = 0; j < 2 * order; ++j) moment(true, j, 0);
  for (int j = 1; j < 2 * order; ++j) moment(false, j, 0);
  for (int s = 0; s < 3 * order; ++s, ++row) {
    residual(row) = s == 0 ? -1 : 0;
    for (int n = 0; n + 2 * s < taps; ++n) {
      residual(row) += h(n) * h(n + 2 * s);
      jacobian(row, n) += h(n + 2 * s);
      jacobian(row, n + 2 * s) += h(n);
    }
  }
}

}  // namespace

// |H|^2 = 2 cos(w/2)^(2N) P(sin(w/2)^2), P(y) = sum_{k<N} C(N-1+k, k) y^k (Daubechies 1988, eq. 4.18 for R =
// 0). y = (2 - z - 1/z)/4 gives a pair z, 1/z a root of P; the inner one is taken.
std::vector<double> daubechies_taps(int taps) {
  const int n = taps / 2;
  std::vector<Real> p{1};
  for (int k = 1; k < n; ++k) p.push_back(p.back() * static_cast<Real>(n - 1 + k) / static_cast<Real>(k));
  std::vector<Complex> h{1};
  const auto times = [&h](Complex root) {  // h *= 1 - root / z
    h.push_back(0);
    for (auto i = h.size() - 1; i > 0; --i) h[i] -= root * h[i - 1];
  };
  for (int i = 0; i < n; ++i) times(-1);
  if (n > 1) {
    for (const Complex y : roots(p)) {
      const Complex b = Real(1) - Real(2) * y;
      const Complex r = std::sqrt(b * b - Real(1));
      times(std::abs(b + r) < 1 ? b + r : b - r);
    }
  }
  Complex sum = 0;
  for (const auto& x : h) sum += x;
  std::vector<double> result;
  for (const auto& x : h) result.push_back(static_cast<double>((x / sum).real() * kSqrt2));
  return result;
}

std::vector<double> coiflet_taps(int taps) {
  const int order = taps / 6;
  const auto& start = coiflet_start(order);
  Vector h = Eigen::Map<const Vector>(start.data(), taps);
  Vector residual;
  Matrix jacobian;
  for (int step = 0; step < 30; ++step) {
    coiflet_equations(order, h, residual, jacobian);
    const Vector change = jacobian.colPivHouseholderQr().solve(residual);
    h -= change;
    if (change.norm() < 1e-17L) break;
  }
  coiflet_equations(order, h, residual, jacobian);
  // Solved to rounding, 1e-17 or better; far less is asked for, since long double is double on some machines.
  if (!(residual.norm() < 1e-13L))
    throw Error("coiflet-" + std::to_string(taps) + ": filter design did not converge");
  std::vector<double> result;
  for (int n = 0; n < taps; ++n) result.push_back(static_cast<double>(h(n)));
  return result;
}

long double battle_lemarie_response(int degree, long double w) {
  // B-splines of degree 3 and 7 at the integers.
  const auto e = [degree](Real v) {
    return degree == 1 ? (2 + std::cos(v)) / 3
                       : (2416 + 2382 * std::cos(v) + 240 * std::cos(2 * v) + 2 * std::cos(3 * v)) / 5040;
  };
  return std::pow(std::cos(w / 2), degree + 1) * std::sqrt(e(w) / e(2 * w));
}

std::vector<double> battle_lemarie_periodised(int degree, int period) {
  std::vector<Real> response, cosine;
  for (int k = 0; k < period; ++k) {
    const Real w = 2 * kPi * static_cast<Real>(k) / static_cast<Real>(period);
    response.push_back(battle_lemarie_response(degree, w));
    cosine.push_back(std::cos(w));
  }
  std::vector<double> h;
  for (int n = 0; n < period; ++n) {
    Real sum = 0;
    for (int k = 0; k < period; ++k) {
      const auto phase = static_cast<std::size_t>(static_cast<std::int64_t>(n) * k % period);
      sum += response[static_cast<std::size_t>(k)] * cosine[phase];
    }
    h.push_back(static_cast<double>(kSqrt2 * sum / static_cast<Real>(period)));
  }
  return h;
}

// The taps fall as 0.74^|n| (degree 3), so that what a period of 1024 folds back onto |n| <= 200 is below
// 1e-100.
std::vector<double> battle_lemarie_taps(int degree, int radius) {
  constexpr int kPeriod = 1024;
  const auto wrapped = battle_lemarie_periodised(degree, kPeriod);
  std::vector<double> h;
  for (int n = -radius; n <= radius; ++n)
    h.push_back(wrapped[static_cast<std::size_t>((n + kPeriod) % kPeriod)]);
  return h;
}

}  // namespace vol::wavelet
