#include "isosurface/saddles.h"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

namespace vol::isosurface {
namespace {

/// Sign of a number that may not be known.
constexpr int kUnknown = 2;

/// A double and a bound of its distance from the exact result.
struct Approximate {
  double value = 0;
  double error = 0;

  // Half an ulp, and room for the rounding of the bound itself.
  static constexpr double kRounding = 0x1p-53 * (1 + 0x1p-40);
  static constexpr double kSlack = 1 + 0x1p-48;
  friend Approximate operator+(const Approximate& a, const Approximate& b) {
    const double v = a.value + b.value;
    return {v, (a.error + b.error + std::abs(v) * kRounding) * kSlack};
  }
  friend Approximate operator-(const Approximate& a, const Approximate& b) {
    const double v = a.value - b.value;
    return {v, (a.error + b.error + std::abs(v) * kRounding) * kSlack};
  }
  friend Approximate operator*(const Approximate& a, const Approximate& b) {
    const double v = a.value * b.value;
    // The last term is for products that underflow.
    return {v, (std::abs(a.value) * b.error + a.error * std::abs(b.value) + a.error * b.error +
                std::abs(v) * kRounding) *
                       kSlack +
                   4 * std::numeric_limits<double>::denorm_min()};
  }
};

int sign(const Approximate& a) {
  // False also for infinities and NaN on overflow.
  if (std::abs(a.value) > a.error && std::abs(a.value) <= std::numeric_limits<double>::max()) {
    return a.value > 0 ? 1 : -1;
  }
  return a.value == 0 && a.error == 0 ? 0 : kUnknown;
}

/// A double alone, whose error is bounded beforehand: what is of degree d in values of at most m in magnitude
/// is off by less than kBound[d] m^d. The longest expressions below have terms of 8 m (degree 1: k), 64 m^2,
/// 400 m^3 (C) and 24 m^4 together, each rounded at most 40 times, 4.4e-15 of it; the bounds leave a factor
/// of 5.
struct Plain {
  double value = 0;
  friend Plain operator+(Plain a, Plain b) { return {a.value + b.value}; }
  friend Plain operator-(Plain a, Plain b) { return {a.value - b.value}; }
  friend Plain operator*(Plain a, Plain b) { return {a.value * b.value}; }
};

__extension__ using Int128 = __int128;
int sign(const Int128& a) {
  return a > 0 ? 1 : a < 0 ? -1 : 0;
}

using BigInteger = boost::multiprecision::cpp_int;
int sign(const BigInteger& a) {
  return a.sign();
}

/// Signs of expressions of a degree in the corner values.
template <class N>
struct Signs {
  explicit Signs(const std::array<N, 8>&) {}
  int operator()(const N& a, int) const { return sign(a); }
};
template <>
struct Signs<Plain> {
  double bound[5];
  explicit Signs(const std::array<Plain, 8>& v) {
    constexpr double kBound[5] = {0, 2e-13, 2e-12, 1e-11, 1e-12};
    double m = 0;
    for (const Plain& x : v) m = std::max(m, std::abs(x.value));
    double power = 1;
    for (int d = 1; d <= 4; ++d) bound[d] = kBound[d] * (power *= m);
  }
  // Products that underflow or overflow are for the others: bounds of 1e-250 and below, infinities, NaN.
  int operator()(const Plain& a, int degree) const {
    if (!(std::abs(a.value) > bound[degree] && bound[4] > 1e-250 &&
          std::abs(a.value) <= std::numeric_limits<double>::max())) {
      return kUnknown;
    }
    return a.value > 0 ? 1 : -1;
  }
};

template <class N>
struct Coefficients {
  N a1, a2, a3, a12, a13, a23, k;

  explicit Coefficients(const std::array<N, 8>& v)
      : a1(v[1] - v[0]),
        a2(v[2] - v[0]),
        a3(v[4] - v[0]),
        a12(v[3] - v[2] - a1),
        a13(v[5] - v[4] - a1),
        a23(v[6] - v[4] - a2),
        k(v[7] - v[6] - v[5] + v[4] - a12) {}
};

/// Corner values with axis `axis` in the place of x and, where `reflected`, 1 - x in the place of x.
template <class N>
std::array<N, 8> turned(const std::array<N, 8>& v, int axis, bool reflected) {
  std::array<N, 8> w;
  for (int c = 0; c < 8; ++c) {
    const int from = ((c & 1) ^ int(reflected)) << axis | ((c >> 1) & 1) << ((axis + 1) % 3) |
                     (c >> 2) << ((axis + 2) % 3);
    w[static_cast<std::size_t>(c)] = v[static_cast<std::size_t>(from)];
  }
  return w;
}

/// Is x > 0 at p (sigma = 1) or q (sigma = -1)? With m = a23 A1 and Q = k a2 a3 + a23 (a1 a23 - a2 a13 - a3
/// a12)
///   x = (-sigma sqrt D - m) / (k A1) = -Q / (m - sigma sqrt D),
/// for m^2 - D = k A1 Q: one of the two forms has no cancellation, and its sign needs no root.
/// \returns 1, -1 (x <= 0), kUnknown
template <class N>
int side_of_zero(const std::array<N, 8>& v, const Signs<N>& sign_of, int sigma) {
  const Coefficients<N> c(v);
  const N A1 = c.k * c.a1 - c.a12 * c.a13;
  const int s_a1 = sign_of(A1, 2);
  const int s_a23 = sign_of(c.a23, 1);
  if (s_a1 == kUnknown || s_a23 == kUnknown) return kUnknown;
  if (s_a1 * s_a23 * sigma < 0) {
    const int s = sign_of(c.k * (c.a2 * c.a3) + c.a23 * (c.a1 * c.a23 - c.a2 * c.a13 - c.a3 * c.a12), 3);
    return s == kUnknown ? kUnknown : s * sigma > 0 ? 1 : -1;
  }
  const int s_k = sign_of(c.k, 1);
  return s_k == kUnknown ? kUnknown : -sigma * s_k * s_a1 > 0 ? 1 : -1;
}

template <class N>
N hyperdeterminant(const std::array<N, 8>& v) {
  const N p = v[0] * v[7];
  const N q = v[4] * v[3];
  const N r = v[2] * v[5];
  const N s = v[1] * v[6];
  const N mixed = p * (q + r + s) + q * (r + s) + r * s;
  const N product = v[0] * v[3] * v[5] * v[6] + v[1] * v[2] * v[4] * v[7];
  const N two_product = product + product;
  const N difference = two_product - mixed;
  return p * p + q * q + r * r + s * s + difference + difference;
}

/// \returns false where the numbers are not exact enough
template <class N>
bool find_tube(const std::array<N, 8>& v, Tube& tube) {
  tube = {};
  const Signs<N> sign_of(v);
  const Coefficients<N> c(v);
  const N bilinear = c.a12 * c.a13;  // of the factors of D
  const int s1 = sign_of(c.k * c.a1 - bilinear, 2);
  const int s2 = sign_of(c.k * c.a2 - c.a12 * c.a23, 2);
  const int s3 = sign_of(c.k * c.a3 - c.a13 * c.a23, 2);
  if (s1 == kUnknown || s2 == kUnknown || s3 == kUnknown) return false;
  if (-s1 * s2 * s3 <= 0) return true;
  const N linear = c.a1 * c.a23 + c.a2 * c.a13 + c.a3 * c.a12;
  const N cubic = bilinear * c.a23;
  const int s_c = sign_of(c.k * (c.k * v[0] - linear) + cubic + cubic, 3);
  const int s_h = sign_of(hyperdeterminant(v), 4);
  if (s_h < 0 || s_c == 0) return true;
  if (s_c == kUnknown || s_h == kUnknown) return false;
  const int sigma = s_c;
  if (sigma < 0 && s_h == 0) return true;  // f(q) = 0 is inside: nothing outside is joined
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool reflected : {false, true}) {
      const int side = side_of_zero(turned(v, axis, reflected), sign_of, sigma);
      if (side == kUnknown) return false;
      if (side < 0) return true;
    }
  }
  // The tube's axis: f_xy, f_xz have at p (q) the signs of -sigma A3, -sigma A2; along the diagonal
  // (1, sign f_xy, sign f_xz) f rises from p, along (1, -sign f_xy, -sign f_xz) it falls from q.
  const int corner = (-s3 > 0 ? 0 : 2) | (-s2 > 0 ? 0 : 4);
  tube.kind = sigma > 0 ? TubeKind::inside : TubeKind::outside;
  tube.diagonal = static_cast<std::uint8_t>(corner < 4 ? corner : 7 - corner);
  return true;
}

/// Corner values less the isovalue, times a power of two that makes them integers below 2^26: then what is of
/// degree 4 in them stays below 2^112. False where there is none of the few tried.
template <std::size_t kCount>
bool as_small_integers(const std::array<double, kCount>& value, double isovalue,
                       std::array<Int128, kCount>& to) {
  for (const double scale : {1.0, 16.0, 256.0}) {
    const double level = isovalue * scale;
    bool fits = std::abs(level) < 0x1p25 && level == std::floor(level);
    for (std::size_t c = 0; c < kCount && fits; ++c) {
      const double v = value[c] * scale;
      fits = std::abs(v) < 0x1p25 && v == std::floor(v);
      if (fits) to[c] = static_cast<std::int64_t>(v) - static_cast<std::int64_t>(level);
    }
    if (fits) return true;
  }
  return false;
}

/// The same as integers of any size, which every finite double allows.
template <std::size_t kCount>
std::array<BigInteger, kCount> as_integers(const std::array<double, kCount>& value, double isovalue) {
  int lowest = std::numeric_limits<int>::max();
  const auto exponent_of = [&](double x) {
    int e = 0;
    if (x != 0 && (std::frexp(x, &e), e - 53 < lowest)) lowest = e - 53;
  };
  for (const double v : value) exponent_of(v);
  exponent_of(isovalue);
  const auto integer = [&](double x) {
    int e = 0;
    const double mantissa = std::frexp(x, &e);
    if (x == 0) return BigInteger(0);
    return BigInteger(BigInteger(static_cast<std::int64_t>(std::ldexp(mantissa, 53))) << (e - 53 - lowest));
  };
  std::array<BigInteger, kCount> result;
  const BigInteger level = integer(isovalue);
  for (std::size_t c = 0; c < kCount; ++c) result[c] = integer(value[c]) - level;
  return result;
}

/// The difference, and how far it is from the exact one.
Approximate relative(double value, double isovalue) {
  const double d = value - isovalue;
  // Knuth's two-sum: the rounding error itself, 0 for most data.
  const double b = d - value;
  const double lost = (value - (d - b)) - (isovalue + b);
  return {d, std::abs(lost)};
}

template <class N>
int face_sign(const N& a, const N& b, const N& c, const N& d) {
  return sign(a * c - b * d);
}

}  // namespace

bool face_joins_inside(double a, double b, double c, double d, double isovalue) {
  // Both products are positive, each off by less than 2^-51 of itself; more than that apart, they are told.
  const double inside = (a - isovalue) * (c - isovalue);
  const double outside = (b - isovalue) * (d - isovalue);
  const double sum = inside + outside;
  if (std::abs(inside - outside) > 0x1p-50 * sum && sum > 1e-290 &&
      sum <= std::numeric_limits<double>::max()) {
    return inside > outside;
  }
  const auto r = [&](double v) { return relative(v, isovalue); };
  const int s = face_sign(r(a), r(b), r(c), r(d));
  if (s != kUnknown) return s >= 0;
  const std::array<double, 4> value{a, b, c, d};
  std::array<Int128, 4> small;
  if (as_small_integers(value, isovalue, small))
    return face_sign(small[0], small[1], small[2], small[3]) >= 0;
  const auto big = as_integers(value, isovalue);
  return face_sign(big[0], big[1], big[2], big[3]) >= 0;
}

Tube interior_tube(const CellValues& cell) {
  Tube tube;
  std::array<Plain, 8> plain;
  for (std::size_t c = 0; c < 8; ++c) plain[c] = {cell.value[c] - cell.isovalue};
  if (find_tube(plain, tube)) return tube;
  std::array<Approximate, 8> v;
  for (std::size_t c = 0; c < 8; ++c) v[c] = relative(cell.value[c], cell.isovalue);
  if (find_tube(v, tube)) return tube;
  std::array<Int128, 8> small;
  if (as_small_integers(cell.value, cell.isovalue, small)) {
    (void)find_tube(small, tube);
  } else {
    (void)find_tube(as_integers(cell.value, cell.isovalue), tube);
  }
  return tube;
}

std::array<double, 3> saddle_position(const CellValues& cell, TubeKind kind) {
  // Scaled to 1 so that no product of degree 6 leaves the range of long double.
  long double scale = 0;
  for (const double v : cell.value) {
    scale = std::max(scale, std::abs(static_cast<long double>(v) - static_cast<long double>(cell.isovalue)));
  }
  std::array<long double, 8> v;
  for (std::size_t c = 0; c < 8; ++c) {
    v[c] = (static_cast<long double>(cell.value[c]) - static_cast<long double>(cell.isovalue)) / scale;
  }
  const long double sigma = kind == TubeKind::inside ? 1 : -1;
  std::array<double, 3> position;
  for (int axis = 0; axis < 3; ++axis) {
    const auto w = turned(v, axis, false);
    const Coefficients<long double> c(w);
    const long double A1 = c.k * c.a1 - c.a12 * c.a13;
    const long double A2 = c.k * c.a2 - c.a12 * c.a23;
    const long double A3 = c.k * c.a3 - c.a13 * c.a23;
    const long double root = std::sqrt(std::max<long double>(0, -A1 * A2 * A3));
    const long double m = c.a23 * A1;
    const long double q = c.k * (c.a2 * c.a3) + c.a23 * (c.a1 * c.a23 - c.a2 * c.a13 - c.a3 * c.a12);
    const long double x = m * sigma < 0 ? -q / (m - sigma * root) : (-sigma * root - m) / (c.k * A1);
    position[static_cast<std::size_t>(axis)] = static_cast<double>(x > 0 ? (x < 1 ? x : 1) : 0);
  }
  return position;
}

}  // namespace vol::isosurface
