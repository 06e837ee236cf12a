#include "transfer/bezier.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "base/utf8.h"

namespace vol::transfer {
namespace {

constexpr double kLargest =
    1e30;  // of a control point and of a colour: nothing that is made of them overflows

std::string counted(std::size_t n) {
  return std::to_string(n) + (n == 1 ? " control point" : " control points");
}

}  // namespace

ValueAndSlope de_casteljau(std::span<const double> points, double t) {
  std::array<double, kMostControlPoints> b;
  std::copy(points.begin(), points.end(), b.begin());
  const double s = 1 - t;
  std::size_t left = points.size();
  for (; left > 2; --left) {
    for (std::size_t i = 0; i + 1 < left; ++i) b[i] = s * b[i] + t * b[i + 1];
  }
  if (left == 1) return {b[0], 0};
  return {s * b[0] + t * b[1], static_cast<double>(points.size() - 1) * (b[1] - b[0])};
}

void bernstein_basis(double t, std::span<double> out) {
  const double s = 1 - t;
  out[0] = 1;
  for (std::size_t n = 1; n < out.size(); ++n) {
    out[n] = t * out[n - 1];
    for (std::size_t i = n - 1; i > 0; --i) out[i] = s * out[i] + t * out[i - 1];
    out[0] *= s;
  }
}

std::vector<double> elevated(std::vector<double> points, std::size_t n) {
  while (points.size() < n) {
    // Q_i = (i P_i-1 + (m - i) P_i)/m, m the old number of points.
    const auto m = static_cast<double>(points.size());
    points.push_back(points.back());
    for (std::size_t i = points.size() - 2; i > 0; --i) {
      const double w = static_cast<double>(i) / m;
      points[i] = w * points[i - 1] + (1 - w) * points[i];
    }
  }
  return points;
}

BezierCurve::BezierCurve(std::vector<double> ordinates, std::vector<double> abscissae)
    : ordinates_(std::move(ordinates)), abscissae_(std::move(abscissae)) {
  if (ordinates_.empty() || ordinates_.size() > kMostControlPoints) {
    throw Error("1 to " + std::to_string(kMostControlPoints) + " control points are possible, not " +
                std::to_string(ordinates_.size()));
  }
  for (const double p : ordinates_) {
    if (!(std::abs(p) <= kLargest)) throw Error("a control point is not finite or beyond 1e30");
  }
  if (abscissae_.empty()) return;
  if (abscissae_.size() != ordinates_.size()) {
    throw Error(counted(ordinates_.size()) + " with " + std::to_string(abscissae_.size()) + " abscissae");
  }
  const auto not_rising = [](double a, double b) { return !(a < b); };
  if (abscissae_.size() < 2 || abscissae_.front() != 0 || abscissae_.back() != 1 ||
      std::adjacent_find(abscissae_.begin(), abscissae_.end(), not_rising) != abscissae_.end()) {
    throw Error("abscissae of control points must rise from 0 to 1, each above the one before");
  }
}

double BezierCurve::parameter(double v) const {
  v = std::clamp(v, 0.0, 1.0);
  if (!parametric() || v == 0 || v == 1) return v;
  // Newton, kept inside an interval that holds the root: X is strictly monotone.
  double lo = 0, hi = 1, t = v;
  for (int step = 0; step < 100 && hi - lo > 0; ++step) {
    const auto x = de_casteljau(abscissae_, t);
    if (x.value == v) return t;
    (x.value < v ? lo : hi) = t;
    double next = t - (x.value - v) / x.slope;
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    if (std::abs(next - t) <= 2e-16) return next;
    t = next;
  }
  return t;
}

ValueAndSlope BezierCurve::at(double v) const {
  const double t = parameter(v);
  auto y = de_casteljau(ordinates_, t);
  if (parametric()) y.slope /= de_casteljau(abscissae_, t).slope;
  return y;
}

void BezierTransfer::validate() const {
  if (bands.empty()) throw Error("no curves");
  if (bands.size() > kMostCurves) {
    throw Error("at most " + std::to_string(kMostCurves) + " curves are possible, not " +
                std::to_string(bands.size()));
  }
  if (!(hi > lo) || !std::isfinite(hi - lo)) throw Error("a range of values with low < high is expected");
  for (const auto& band : bands) {
    if (!band.colour.allFinite() || band.colour.minCoeff() < 0) {
      throw Error("colour with a component that is negative or not finite");
    }
    if (band.colour.maxCoeff() > kLargest) throw Error("colour with a component beyond 1e30");
    if (!is_utf8(band.name)) throw Error("the name of a curve is not UTF-8");
  }
}

double BezierTransfer::scaled(double value) const {
  return std::clamp((value - lo) / (hi - lo), 0.0, 1.0);
}

double BezierTransfer::weighted(double value, int channel) const {
  const double v = scaled(value);
  double sum = 0;
  for (const auto& band : bands) {
    if (band.colour[channel] != 0) sum += band.colour[channel] * band.curve.value(v);
  }
  return v * sum;
}

bool BezierTransfer::grey() const {
  return std::all_of(bands.begin(), bands.end(), [](const BezierBand& b) {
    return b.colour[0] == b.colour[1] && b.colour[1] == b.colour[2];
  });
}

namespace {

/// What emission and absorption see at v.
struct Sight {
  double v, opacity;
  Vec3 colour;
};

Sight sight(const BezierTransfer& bezier, double v) {
  double sum = 0;
  Vec3 light = Vec3::Zero(), mean = Vec3::Zero();
  for (const auto& band : bezier.bands) {
    const double weight = std::max(0.0, band.curve.value(v));
    sum += weight;
    light += weight * band.colour;
    mean += band.colour / static_cast<double>(bezier.bands.size());
  }
  if (sum > 0) mean = light / sum;
  return {v, std::min(1.0, sum), mean};
}

/// Whether the line from a to b is within tolerance of what is at the quarters; colour counts where it is
/// seen.
bool straight(const BezierTransfer& bezier, const Sight& a, const Sight& b, double tolerance) {
  for (const double w : {0.25, 0.5, 0.75}) {
    const Sight s = sight(bezier, a.v + w * (b.v - a.v));
    if (std::abs(a.opacity + w * (b.opacity - a.opacity) - s.opacity) > tolerance) return false;
    const Vec3 off = a.colour + w * (b.colour - a.colour) - s.colour;
    if (off.cwiseAbs().maxCoeff() * s.opacity > tolerance) return false;
  }
  return true;
}

void append_pieces(const BezierTransfer& bezier, const Sight& a, const Sight& b, int depth, double tolerance,
                   std::vector<Sight>& points) {
  constexpr int kFewest = 3, kMost = 12;  // halvings: 8 to 4096 pieces
  if (depth >= kFewest && (depth == kMost || straight(bezier, a, b, tolerance))) {
    points.push_back(b);
    return;
  }
  const Sight middle = sight(bezier, 0.5 * (a.v + b.v));
  append_pieces(bezier, a, middle, depth + 1, tolerance, points);
  append_pieces(bezier, middle, b, depth + 1, tolerance, points);
}

}  // namespace

TransferFunction as_transfer_function(const BezierTransfer& bezier, double tolerance) {
  bezier.validate();
  std::vector<Sight> points{sight(bezier, 0)};
  append_pieces(bezier, points.front(), sight(bezier, 1), 0, tolerance, points);
  std::vector<ColourPoint> colours;
  std::vector<OpacityPoint> opacities;
  for (const Sight& s : points) {
    const double value = s.v == 1 ? bezier.hi : bezier.lo + s.v * (bezier.hi - bezier.lo);
    colours.push_back({value, s.colour});
    opacities.push_back({value, s.opacity});
  }
  return {std::move(colours), std::move(opacities)};
}

}  // namespace vol::transfer
