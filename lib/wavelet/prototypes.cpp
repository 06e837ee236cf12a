#include "wavelet/prototypes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "base/error.h"
#include "wavelet/spline_basis.h"

namespace vol::wavelet {
namespace {

using Real = long double;
using Values = std::vector<Real>;

constexpr Real kSqrt2 = std::numbers::sqrt2_v<Real>;

/// From f at multiples of 2^-j, j = 0 .. of [first, last], to f(x) = sqrt 2 sum_n taps[n] f(2x - n) at
/// multiples of 2^-(j+1): entry i of the result belongs to first + i 2^-(j+1).
Values refined(const FilterBank& bank, const std::vector<double>& taps, const Values& f, int j) {
  const std::int64_t length = bank.taps() - 1;
  const std::int64_t unit = std::int64_t{1} << j;
  Values result(static_cast<std::size_t>(length * 2 * unit + 1));
  // x = first + i / (2 unit); 2x - n = first + (i - m unit) / unit with n = first + m.
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(result.size()); ++i) {
    Real sum = 0;
    for (std::int64_t m = 0; m < bank.taps(); ++m) {
      const std::int64_t at = i - m * unit;
      if (at < 0 || at > length * unit) continue;
      sum += static_cast<Real>(taps[static_cast<std::size_t>(m)]) * f[static_cast<std::size_t>(at)];
    }
    result[static_cast<std::size_t>(i)] = kSqrt2 * sum;
  }
  return result;
}

/// Slopes, times the knot distance, of the cubic spline through f with given end slopes:
/// D[i-1] + 4 D[i] + D[i+1] = 3 (f[i+1] - f[i-1]).
Values spline_slopes(const Values& f, Real begin, Real end) {
  const std::size_t n = f.size();
  Values slope(n), upper(n);
  slope[0] = begin;
  slope[n - 1] = end;
  upper[0] = 0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Real pivot = 4 - upper[i - 1];
    upper[i] = 1 / pivot;
    slope[i] = (3 * (f[i + 1] - f[i - 1]) - slope[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i > 0; --i) slope[i] -= upper[i] * slope[i + 1];
  return slope;
}

PiecewiseCubic through(const Values& f, const Values& slope, double lower, double spacing) {
  PiecewiseCubic result{lower, spacing, {}};
  for (std::size_t i = 0; i + 1 < f.size(); ++i) {
    const Real rise = f[i + 1] - f[i];
    result.pieces.push_back({static_cast<double>(f[i]), static_cast<double>(slope[i]),
                             static_cast<double>(3 * rise - 2 * slope[i] - slope[i + 1]),
                             static_cast<double>(slope[i] + slope[i + 1] - 2 * rise)});
  }
  return result;
}

/// End slopes with which the integer translates of the spline add up to 1. Their sum takes 1 at the knots and
/// is a spline but at the integers; it is 1 throughout if its slopes there vanish from both sides.
Values slopes_that_keep_constants(const Values& f, std::size_t unit) {
  const auto inside = [&](const Values& slope) {
    Real sum = 0;
    for (std::size_t i = unit; i + 1 < f.size(); i += unit) sum += slope[i];
    return sum;
  };
  const Real without = inside(spline_slopes(f, 0, 0));
  const Real with = inside(spline_slopes(f, 1, 1)) - without;  // what unit end slopes add
  const Real end = -without / (1 + with);
  return spline_slopes(f, end, end);
}

double deviation(const PiecewiseCubic& f, const Values& truth) {
  const double spacing = (f.upper() - f.lower) / static_cast<double>(truth.size() - 1);
  Real largest = 0;
  for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
    largest = std::max(largest, std::abs(f.value(f.lower + spacing * static_cast<double>(i)) - truth[i]));
  }
  return static_cast<double>(largest);
}

Prototypes from_refinement(const FilterBank& bank, int depth) {
  Values phi = scaling_function_at_integers(bank);
  Values coarse_phi = phi, before = phi;
  Values spline_phi, spline_psi, psi;
  constexpr int kFiner = 3;
  for (int j = 0; j <= depth + kFiner; ++j) {
    // phi holds multiples of 2^-j; psi at them follows from phi one step coarser.
    if (j == depth) {
      spline_phi = phi;
      spline_psi = refined(bank, bank.g, before, j - 1);
    }
    if (j == depth + kFiner) psi = refined(bank, bank.g, before, j - 1);
    if (j < depth + kFiner) {
      before = phi;
      phi = refined(bank, bank.h, phi, j);
    }
  }
  const auto lower = static_cast<double>(bank.first);
  const double spacing = std::ldexp(1.0, -depth);
  Prototypes result;
  result.phi =
      through(spline_phi, slopes_that_keep_constants(spline_phi, std::size_t{1} << depth), lower, spacing);
  result.psi = through(spline_psi, spline_slopes(spline_psi, 0, 0), lower, spacing);
  result.phi_deviation = deviation(result.phi, phi);
  result.psi_deviation = deviation(result.psi, psi);
  return result;
}

/// sum_k c[k] beta(x / spacing - (first + k)), beta the centred B-spline of degree 1 or 3.
PiecewiseCubic spline(int degree, const Values& c, std::int64_t first, double spacing) {
  const int reach = degree == 1 ? 1 : 2;
  const auto at = [&](std::int64_t k) {
    return k >= 0 && k < static_cast<std::int64_t>(c.size()) ? c[static_cast<std::size_t>(k)] : Real{0};
  };
  PiecewiseCubic result{spacing * static_cast<double>(first - reach), spacing, {}};
  for (std::int64_t i = -reach; i < static_cast<std::int64_t>(c.size()) - 1 + reach; ++i) {
    const Real b = at(i - 1), c0 = at(i), c1 = at(i + 1), e = at(i + 2);
    if (degree == 1) {
      result.pieces.push_back({static_cast<double>(c0), static_cast<double>(c1 - c0), 0, 0});
    } else {
      result.pieces.push_back({static_cast<double>((b + 4 * c0 + c1) / 6), static_cast<double>((c1 - b) / 2),
                               static_cast<double>((b - 2 * c0 + c1) / 2),
                               static_cast<double>((e - 3 * c1 + 3 * c0 - b) / 6)});
    }
  }
  return result;
}

/// Coefficients without the ends that are below 1e-16; the index of the first moves along.
void trim(Values& c, std::int64_t& first) {
  const auto counts = [](Real x) { return std::abs(x) > 1e-16L; };
  const auto begin = std::find_if(c.begin(), c.end(), counts);
  const auto end = std::find_if(c.rbegin(), c.rend(), counts).base();
  first += begin - c.begin();
  c = Values(begin, end);
}

// phi^(w) = beta^(w) / sqrt E(w), E the Fourier series of the B-spline of degree 2d+1 at the integers, so
// that sum_k |phi^(w + 2 pi k)|^2 = 1; the coefficients fall as 0.54^|k| (degree 3), 1024 of them fold
// nothing.
struct SplineSums {
  Values a, b;
  std::int64_t first_a, first_b;
};
SplineSums make_battle_lemarie_sums(int degree) {
  constexpr int kPeriod = 1024, kRadius = 100;
  const auto e = [degree](Real v) {
    return degree == 1 ? (2 + std::cos(v)) / 3
                       : (2416 + 2382 * std::cos(v) + 240 * std::cos(2 * v) + 2 * std::cos(3 * v)) / 5040;
  };
  constexpr Real kTurn = 2 * std::numbers::pi_v<Real>;
  Values a;
  for (int k = -kRadius; k <= kRadius; ++k) {
    Real sum = 0;
    for (int j = 0; j < kPeriod; ++j) {
      const Real w = kTurn * static_cast<Real>(j) / kPeriod;
      const int turn = ((j * k) % kPeriod + kPeriod) % kPeriod;
      sum += std::cos(kTurn * static_cast<Real>(turn) / kPeriod) / std::sqrt(e(w));
    }
    a.push_back(sum / kPeriod);
  }
  // psi(x) = sqrt 2 sum_n g[n] phi(2x - n) = sum_m b[m] beta(2x - m),  b = sqrt 2 g * a.
  const FilterBank bank = make_wavelet(degree == 1 ? "battle-lemarie-1" : "battle-lemarie-3").bank;
  Values b(a.size() + bank.g.size() - 1, 0);
  for (std::size_t n = 0; n < bank.g.size(); ++n) {
    for (std::size_t k = 0; k < a.size(); ++k) b[n + k] += kSqrt2 * static_cast<Real>(bank.g[n]) * a[k];
  }
  std::int64_t first_a = -kRadius, first_b = bank.first - kRadius;
  trim(a, first_a);
  trim(b, first_b);
  return {std::move(a), std::move(b), first_a, first_b};
}

const SplineSums& battle_lemarie_sums(int degree) {
  static const SplineSums linear = make_battle_lemarie_sums(1), cubic = make_battle_lemarie_sums(3);
  return degree == 1 ? linear : cubic;
}

Prototypes battle_lemarie_prototypes(int degree) {
  const SplineSums& sums = battle_lemarie_sums(degree);
  return {spline(degree, sums.a, sums.first_a, 1), spline(degree, sums.b, sums.first_b, 0.5), 0, 0};
}

/// Piece of f and place within it, of an x known to be inside.
struct Place {
  const std::array<double, 4>& a;
  double v;
};
Place place_of(const PiecewiseCubic& f, double x) {
  const double q = (x - f.lower) / f.spacing;
  const double i = std::clamp(std::floor(q), 0.0, static_cast<double>(f.pieces.size() - 1));
  return {f.pieces[static_cast<std::size_t>(i)], q - i};
}

}  // namespace

double PiecewiseCubic::value(double x) const {
  return value(x, 0);
}

double PiecewiseCubic::derivative(double x) const {
  return derivative(x, 0);
}

double PiecewiseCubic::value(double v, double k) const {
  if (!covers(v, k)) return 0;
  const auto [a, u] = place_of(*this, v - k);
  return a[0] + u * (a[1] + u * (a[2] + u * a[3]));
}

double PiecewiseCubic::derivative(double v, double k) const {
  if (!covers(v, k)) return 0;
  const auto [a, u] = place_of(*this, v - k);
  return (a[1] + u * (2 * a[2] + u * 3 * a[3])) / spacing;
}

double PiecewiseCubic::integral() const {
  double sum = 0;
  for (const auto& a : pieces) sum += a[0] + a[1] / 2 + a[2] / 3 + a[3] / 4;
  return spacing * sum;
}

std::vector<long double> scaling_function_at_integers(const FilterBank& bank) {
  // (M - 1) phi = 0 with M[i][j] = sqrt 2 h[2i - j], and sum phi = 1. phi is continuous: 0 at both ends.
  const auto n = static_cast<Eigen::Index>(bank.taps());
  Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> m =
      Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>::Zero(n - 1, n - 2);
  for (Eigen::Index i = 0; i < n - 2; ++i) {
    for (Eigen::Index j = 0; j < n - 2; ++j) {
      const Eigen::Index tap = 2 * (i + 1) - (j + 1);
      if (tap >= 0 && tap < n) m(i, j) = kSqrt2 * static_cast<Real>(bank.h[static_cast<std::size_t>(tap)]);
      if (i == j) m(i, j) -= 1;
    }
  }
  m.row(n - 2).setOnes();
  Eigen::Matrix<Real, Eigen::Dynamic, 1> right = Eigen::Matrix<Real, Eigen::Dynamic, 1>::Zero(n - 1);
  right(n - 2) = 1;
  const Eigen::Matrix<Real, Eigen::Dynamic, 1> phi = m.colPivHouseholderQr().solve(right);
  Values result(static_cast<std::size_t>(n), 0);
  for (Eigen::Index i = 0; i < n - 2; ++i) result[static_cast<std::size_t>(i + 1)] = phi(i);
  return result;
}

SplineBasis battle_lemarie_basis(int degree) {
  const SplineSums& sums = battle_lemarie_sums(degree);
  return {{sums.a.begin(), sums.a.end()},
          {sums.b.begin(), sums.b.end()},
          sums.first_a,
          sums.first_b,
          spline(degree, {1}, 0, 1)};
}

Prototypes make_prototypes(const Wavelet& wavelet, int depth) {
  if (depth < 1 || depth > kMaxDepth) {
    throw Error("depth " + std::to_string(depth) + " of the basis functions: expected 1 to " +
                std::to_string(kMaxDepth));
  }
  if (wavelet.family == Family::haar) {
    return {{0, 1, {{1, 0, 0, 0}}}, {0, 0.5, {{1, 0, 0, 0}, {-1, 0, 0, 0}}}, 0, 0};
  }
  if (wavelet.family == Family::battle_lemarie) return battle_lemarie_prototypes(wavelet.degree);
  return from_refinement(wavelet.bank, depth);
}

PiecewiseCubic periodised(const PiecewiseCubic& f, std::int64_t period) {
  const auto count = static_cast<std::size_t>(std::llround(static_cast<double>(period) / f.spacing));
  if (f.pieces.size() <= count) return f;
  PiecewiseCubic result{f.lower, f.spacing, {}};
  result.pieces.assign(count, {0, 0, 0, 0});
  for (std::size_t i = 0; i < f.pieces.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) result.pieces[i % count][k] += f.pieces[i][k];
  }
  return result;
}

}  // namespace vol::wavelet
