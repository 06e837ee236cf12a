#include "render/bernstein.h"

#include <algorithm>
#include <cmath>

namespace vol::render {
namespace {

int sign_changes(const Bernstein& p) {
  int changes = 0;
  double last = 0;
  for (int k = 0; k <= p.degree; ++k) {
    if (p.b[k] == 0) continue;
    if (last != 0 && (p.b[k] > 0) != (last > 0)) ++changes;
    last = p.b[k];
  }
  return changes;
}

/// The root of p between ends of opposite sign: secant steps (Illinois), bisection where they do not pay.
double bracketed_root(const Bernstein& p) {
  double lo = 0, hi = 1;
  double p_lo = p.b[0], p_hi = p.b[p.degree];
  int side = 0;
  for (int step = 0; step < 100 && hi - lo > 1e-16; ++step) {
    double u = step % 4 == 3 ? 0.5 * (lo + hi) : (lo * p_hi - hi * p_lo) / (p_hi - p_lo);
    if (!(u > lo && u < hi)) u = 0.5 * (lo + hi);
    if (!(u > lo && u < hi)) break;
    const double value = p(u);
    if (value == 0) return u;
    if ((value > 0) == (p_lo > 0)) {
      lo = u;
      p_lo = value;
      if (side == -1) p_hi *= 0.5;
      side = -1;
    } else {
      hi = u;
      p_hi = value;
      if (side == 1) p_lo *= 0.5;
      side = 1;
    }
  }
  return 0.5 * (lo + hi);
}

/// Roots of p on [from, from + width] of the original parameter, by the variation of signs.
void isolate(const Bernstein& p, double from, double width, std::vector<double>& roots) {
  const int changes = sign_changes(p);
  if (changes == 0) return;
  if (changes == 1 && p.b[0] != 0 && p.b[p.degree] != 0) {
    roots.push_back(from + width * bracketed_root(p));
    return;
  }
  if (width < 1e-13) {  // a cluster that rounding hides: one cut there does for the integral
    roots.push_back(from + 0.5 * width);
    return;
  }
  Bernstein left, right;
  p.halve(left, right);
  isolate(left, from, 0.5 * width, roots);
  if (left.b[left.degree] == 0) roots.push_back(from + 0.5 * width);
  isolate(right, from + 0.5 * width, 0.5 * width, roots);
}

}  // namespace

double Bernstein::operator()(double u) const {
  // Horner in u/(1-u), scaled so that nothing overflows: the form of Farin, Curves and Surfaces, section 5.
  const double v = 1 - u;
  double power = 1;     // u^k
  double binomial = 1;  // C(n, k)
  double sum = b[0] * v;
  for (int k = 1; k < degree; ++k) {
    power *= u;
    binomial = binomial * (degree - k + 1) / k;
    sum = (sum + power * binomial * b[k]) * v;
  }
  return degree == 0 ? b[0] : sum + power * u * b[degree];
}

double Bernstein::min() const {
  return *std::min_element(b.begin(), b.begin() + degree + 1);
}
double Bernstein::max() const {
  return *std::max_element(b.begin(), b.begin() + degree + 1);
}

double Bernstein::integral() const {
  double sum = 0;
  for (int k = 0; k <= degree; ++k) sum += b[k] / (degree + 1);
  return sum;
}

Bernstein Bernstein::derivative() const {
  Bernstein d;
  d.degree = std::max(0, degree - 1);
  for (int k = 0; k < degree; ++k) d.b[k] = degree * (b[k + 1] - b[k]);
  return d;
}

void Bernstein::halve(Bernstein& left, Bernstein& right) const {
  split(0.5, left, right);
}

void Bernstein::split(double u, Bernstein& left, Bernstein& right) const {
  left.degree = right.degree = degree;
  std::array<double, kMaxDegree + 1> work = b;
  for (int level = 0; level <= degree; ++level) {
    left.b[level] = work[0];
    right.b[degree - level] = work[degree - level];
    for (int k = 0; k < degree - level; ++k) work[k] = (1 - u) * work[k] + u * work[k + 1];
  }
}

Bernstein bernstein_of_powers(std::array<double, Bernstein::kMaxDegree + 1> powers) {
  constexpr int n = Bernstein::kMaxDegree;
  // Powers of u first, by Horner's scheme.
  for (std::size_t low = 0; low < n; ++low) {
    for (std::size_t k = n; k-- > low;) powers[k] -= 0.5 * powers[k + 1];
  }
  // u^k = sum_j>=k C(j,k)/C(n,k) B_j: repeated sums of what is divided by C(n,k).
  Bernstein p;
  p.degree = n;
  double binomial = 1;
  for (int k = 0; k <= n; ++k) {
    p.b[static_cast<std::size_t>(k)] = powers[static_cast<std::size_t>(k)] / binomial;
    binomial = binomial * (n - k) / (k + 1);
  }
  for (std::size_t low = 0; low < n; ++low) {
    for (std::size_t k = n; k > low; --k) p.b[k] += p.b[k - 1];
  }
  return p;
}

void append_crossings(const Bernstein& p, double value, std::vector<double>& roots) {
  if (!(p.min() < value && p.max() > value)) return;
  Bernstein shifted = p;
  for (int k = 0; k <= p.degree; ++k) shifted.b[k] -= value;
  isolate(shifted, 0, 1, roots);
}

namespace {

void search(const Bernstein& p, double from, double width, double tolerance, bool& found, double& maximum,
            double& where) {
  const auto offer = [&](double value, double u) {
    if (value > maximum) {
      maximum = value;
      where = u;
      found = true;
    }
  };
  offer(p.b[0], from);
  offer(p.b[p.degree], from + width);
  if (!(p.max() > maximum + tolerance) || width < 1e-14) return;
  Bernstein left, right;
  p.halve(left, right);
  const bool left_first = left.max() >= right.max();
  if (!left_first) search(right, from + 0.5 * width, 0.5 * width, tolerance, found, maximum, where);
  search(left, from, 0.5 * width, tolerance, found, maximum, where);
  if (left_first) search(right, from + 0.5 * width, 0.5 * width, tolerance, found, maximum, where);
}

}  // namespace

bool find_maximum(const Bernstein& p, double at_least, double tolerance, double& maximum, double& where) {
  bool found = false;
  maximum = at_least;
  search(p, 0, 1, tolerance, found, maximum, where);
  return found;
}

}  // namespace vol::render
