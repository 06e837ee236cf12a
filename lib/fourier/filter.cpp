#include "fourier/filter.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace vol::fourier {
namespace {

constexpr double kPi = std::numbers::pi;

double sinc(double x) {
  return x == 0 ? 1.0 : std::sin(kPi * x) / (kPi * x);
}

double hat(double t) {
  return std::max(0.0, 1 - std::abs(t));
}

/// Keys 1981 with a = -1/2.
double catmull_rom(double t) {
  const double a = std::abs(t);
  if (a >= 2) return 0;
  return a < 1 ? (1.5 * a - 2.5) * a * a + 1 : ((-0.5 * a + 2.5) * a - 4) * a + 2;
}

struct Rule {
  std::vector<double> nodes, weights;
};

/// Gauss-Legendre on [-1, 1], nodes by Newton's method on the Legendre polynomial.
Rule gauss_legendre(int n) {
  Rule rule;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 1;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p = 1, previous = 0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2.0 * k - 1) * x * p - (k - 1.0) * previous) / k;
        previous = p;
        p = next;
      }
      slope = n * (x * p - previous) / (x * x - 1);
      const double step = p / slope;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    rule.nodes.push_back(x);
    rule.weights.push_back(2 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

int number_after(std::string_view name, std::size_t prefix) {
  int value = 0;
  const char* end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data() + prefix, end, value);
  if (parsed.ec != std::errc{} || parsed.ptr != end || value < 2 || value > 16) {
    throw Error("filter " + std::string(name) + ": 2 to 16 taps are possible, such as " +
                std::string(name.substr(0, prefix)) + "6");
  }
  return value;
}

}  // namespace

std::string filter_names() {
  return "nearest, trilinear, catmull-rom, catmull-rom-fast, sinc:N, es:N";
}

Filter::Filter(std::string_view name, double padding) : name_(name) {
  if (!(padding >= 1)) throw Error("filter " + name_ + ": padding is at least 1");
  if (name == "nearest") {
    kind_ = Kind::nearest;
    taps_ = 1;
  } else if (name == "trilinear") {
    kind_ = Kind::trilinear;
    taps_ = 2;
  } else if (name == "catmull-rom") {
    kind_ = Kind::catmull_rom;
    taps_ = 4;
  } else if (name == "catmull-rom-fast") {
    kind_ = Kind::catmull_rom_fast;
    taps_ = 5;
  } else if (name.starts_with("sinc:")) {
    kind_ = Kind::sinc;
    taps_ = number_after(name, 5);
    name_ = "sinc:" + std::to_string(taps_);
  } else if (name.starts_with("es:")) {
    kind_ = Kind::es;
    taps_ = number_after(name, 3);
    name_ = "es:" + std::to_string(taps_);  // es:06 too
    beta_ = 0.976 * kPi * taps_ * (1 - 1 / (2 * padding));
  } else {
    throw Error("filter " + name_ + " is unknown; there are " + filter_names());
  }
}

bool Filter::interpolates() const {
  return kind_ != Kind::es && kind_ != Kind::catmull_rom_fast;
}

double Filter::weight(double t) const {
  const double half = 0.5 * taps_;
  if (std::abs(t) > half) return 0;
  switch (kind_) {
    case Kind::nearest:
      return 1;
    case Kind::trilinear:
      return hat(t);
    case Kind::catmull_rom:
      return catmull_rom(t);
    case Kind::catmull_rom_fast:  // Catmull-Rom at u = 1/2: (-1, 9, 9, -1)/16
      return (9 * (hat(t - 0.5) + hat(t + 0.5)) - hat(t - 1.5) - hat(t + 1.5)) / 16;
    case Kind::sinc:
      return sinc(t) * (0.54348 + 0.45652 * std::cos(2 * kPi * t / taps_));
    case Kind::es:
      break;
  }
  const double u = t / half;
  return std::exp(beta_ * (std::sqrt(std::max(0.0, 1 - u * u)) - 1));
}

double Filter::transform(double x) const {
  // Pieces of half a step, on which each kernel is smooth. The semicircle's root is smooth in the angle of
  // t = (taps/2) sin(angle), in which the pieces are cut instead.
  static const Rule rule = gauss_legendre(24);
  const double half = 0.5 * taps_;
  const bool round = kind_ == Kind::es;
  const double end = round ? kPi / 2 : half;
  double sum = 0;
  for (int piece = 0; piece < taps_; ++piece) {
    const double from = end * piece / taps_, width = end / taps_;
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      const double s = from + 0.5 * width * (1 + rule.nodes[i]);
      const double t = round ? half * std::sin(s) : s;
      const double stretch = round ? half * std::cos(s) : 1;
      sum += 0.5 * width * rule.weights[i] * stretch * weight(t) * std::cos(2 * kPi * x * t);
    }
  }
  return 2 * sum;
}

Filter::Polynomials Filter::polynomials() const {
  Polynomials result;
  switch (kind_) {
    case Kind::nearest:
      result.degree = 0;
      break;
    case Kind::trilinear:
    case Kind::catmull_rom_fast:
      result.degree = 1;
      break;
    case Kind::catmull_rom:
      result.degree = 3;
      break;
    case Kind::sinc:
      result.degree = 9;
      break;
    case Kind::es:
      // The root at the kernel's ends bounds what any degree reaches there by about exp(-beta); this one is
      // where that is reached (test of polynomials()).
      result.degree = std::min(14, taps_ + 4);
      break;
  }
  const int n = result.degree + 1;
  result.coefficients.assign(static_cast<std::size_t>(n * taps_), 0.0);
  for (int j = 0; j < taps_; ++j) {
    // Newton's divided differences at the Chebyshev nodes, then expanded into powers of s.
    std::vector<double> s(static_cast<std::size_t>(n)), c(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) {
      s[i] = std::cos(kPi * (i + 0.5) / n);
      c[i] = weight(0.5 * (s[i] + 1) + 0.5 * taps_ - 1 - j);
    }
    for (int order = 1; order < n; ++order) {
      for (int i = n - 1; i >= order; --i) c[i] = (c[i] - c[i - 1]) / (s[i] - s[i - order]);
    }
    std::vector<double> power(static_cast<std::size_t>(n), 0.0);
    for (int i = n - 1; i >= 0; --i) {
      for (int d = n - 1; d > 0; --d) power[d] = power[d - 1] - s[i] * power[d];
      power[0] = -s[i] * power[0] + c[i];
    }
    for (int d = 0; d < n; ++d) result.coefficients[d * taps_ + j] = power[d];
  }
  return result;
}

}  // namespace vol::fourier
