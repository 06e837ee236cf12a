#include "render/extinction_pieces.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace vol::render {
namespace {

constexpr int kDegree = ExtinctionPiece::kDegree;

/// A stretch of values over which opacity runs from `clear` to `dense`, upward or downward in the value.
struct Ramp {
  double lo, hi;  ///< values
  double clear, dense;
  bool falls;  ///< the denser end is at `lo`
};

/// Whether one polynomial does, by the bounds of extinction_pieces(); what begins with opacity 0 is held to a
/// relative error all along.
bool fine(double clear, double dense) {
  const double change = dense - clear;
  const double q6 = std::pow(change / (1 - dense), 6);
  if (clear == 0) return q6 / (6 * 512) <= kExtinctionShare * change;
  return q6 / (6 * 2048) <= extinction_error(clear);
}

/// Opacities at which a ramp is cut, from its clear end; nothing where there would be more than `most`
/// pieces.
std::optional<std::vector<double>> cuts(double clear, double dense, std::size_t most) {
  if (!(dense < 1)) return std::nullopt;
  std::vector<double> at{clear};
  while (at.back() < dense) {
    if (at.size() > most) return std::nullopt;
    double reached = dense;
    if (!fine(at.back(), dense)) {
      double low = at.back(), high = dense;
      for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (low + high);
        (fine(at.back(), middle) ? low : high) = middle;
      }
      reached = low;
      if (!(reached > at.back())) return std::nullopt;
    }
    at.push_back(reached);
  }
  if (at.size() == 1) at.push_back(dense);  // constant
  return at;
}

/// Coefficients, in the share t of the way from `clear` to `dense`, of the polynomial of kTerms terms
/// through the Chebyshev points of log2(1 - opacity), divided by t where `divided`.
template <int kTerms>
void interpolate(double clear, double dense, bool divided, double* coefficient) {
  Eigen::Matrix<double, kTerms, kTerms> powers;
  Eigen::Matrix<double, kTerms, 1> values;
  for (int i = 0; i < kTerms; ++i) {
    const double t = 0.5 - 0.5 * std::cos(std::numbers::pi * (i + 0.5) / kTerms);
    for (int j = 0; j < kTerms; ++j) powers(i, j) = std::pow(t, j);
    values[i] = std::log1p(-(clear + t * (dense - clear))) / std::numbers::ln2 / (divided ? t : 1);
  }
  const Eigen::Matrix<double, kTerms, 1> found = powers.partialPivLu().solve(values);
  for (int j = 0; j < kTerms; ++j) coefficient[j] = found[j];
}

/// The piece of a ramp between two of its opacities; values by `range`.
std::optional<ExtinctionPiece> piece(const Ramp& ramp, double clear, double dense, double range) {
  const auto value = [&](double opacity) {
    const double share = ramp.dense > ramp.clear ? (opacity - ramp.clear) / (ramp.dense - ramp.clear) : 0;
    return ramp.falls ? ramp.hi - share * (ramp.hi - ramp.lo) : ramp.lo + share * (ramp.hi - ramp.lo);
  };
  ExtinctionPiece result{ramp.falls ? value(dense) : value(clear), value(clear), {}};
  if (clear == dense) {
    result.from = ramp.lo;
    result.coefficient[0] = std::log1p(-clear) / std::numbers::ln2;
    return result;
  }
  const double way = (value(dense) - value(clear)) / range;
  if (!(std::abs(way) >= 1e-5)) return std::nullopt;
  if (clear == 0) {
    interpolate<kDegree>(clear, dense, true, result.coefficient + 1);
  } else {
    interpolate<kDegree + 1>(clear, dense, false, result.coefficient);
  }
  for (int j = 1; j <= kDegree; ++j) result.coefficient[j] /= std::pow(way, j);
  return result;
}

/// The ramps of opacity between lo and hi; the largest value, if it is a point, is one of its own.
std::vector<Ramp> ramps(const Optics& optics, double lo, double hi) {
  std::vector<double> starts{lo};
  for (const auto& point : optics.transfer().opacities()) {
    if (point.value > starts.back() && point.value <= hi) starts.push_back(point.value);
  }
  std::vector<Ramp> result;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const double from = starts[k], to = k + 1 < starts.size() ? starts[k + 1] : hi;
    const double first = optics.transfer().opacity(from);
    // From below: at its end the opacity may jump.
    const double last =
        to > from ? optics.intervals()[optics.interval_of(std::nextafter(to, from))].opacity(to) : first;
    result.push_back({from, to, std::min(first, last), std::max(first, last), last < first});
  }
  return result;
}

}  // namespace

ExtinctionPiece ExtinctionPiece::around(double other, double shift) const {
  ExtinctionPiece result = *this;
  result.origin = other;
  // Horner's scheme once for every coefficient (Taylor shift).
  for (int first = 0; first < kDegree; ++first) {
    for (int j = kDegree - 1; j >= first; --j) {
      result.coefficient[j] += shift * result.coefficient[j + 1];
    }
  }
  return result;
}

std::vector<ExtinctionPiece> extinction_pieces(const Optics& optics, double lo, double hi, std::size_t most) {
  std::vector<ExtinctionPiece> result;
  for (const Ramp& ramp : ramps(optics, lo, hi)) {
    const auto at = cuts(ramp.clear, ramp.dense, most);
    if (!at || result.size() + at->size() - 1 > most) return {};
    const std::size_t first = result.size();
    for (std::size_t k = 0; k + 1 < at->size(); ++k) {
      const auto found = piece(ramp, (*at)[k], (*at)[k + 1], hi - lo);
      if (!found) return {};
      result.push_back(*found);
    }
    if (ramp.falls) std::reverse(result.begin() + static_cast<std::ptrdiff_t>(first), result.end());
    result[first].from = ramp.lo;
  }
  return result;
}

}  // namespace vol::render
