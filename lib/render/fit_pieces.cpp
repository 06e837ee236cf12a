#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/ray_polynomial.h"

namespace vol::render {
namespace {

constexpr int kDegree = Bernstein::kMaxDegree;
constexpr int kNodes = kDegree + 1;
using Samples = Eigen::Matrix<double, kNodes, 1>;
using Matrix = Eigen::Matrix<double, kNodes, kNodes>;

/// Chebyshev points of [0, 1], which make the fit within a factor 3 of the best of its degree.
double chebyshev(int i) {
  return 0.5 - 0.5 * std::cos(std::numbers::pi * (i + 0.5) / kNodes);
}

/// Samples at the Chebyshev points to Bernstein coefficients.
const Matrix& to_bernstein() {
  static const Matrix inverse = [] {
    Matrix values;
    for (int i = 0; i < kNodes; ++i) {
      for (int k = 0; k < kNodes; ++k) {
        Bernstein basis;
        basis.degree = kDegree;
        basis.b[k] = 1;
        values(i, k) = basis(chebyshev(i));
      }
    }
    return Matrix(values.inverse());
  }();
  return inverse;
}

class Fit {
 public:
  Fit(const FieldView& field, const camera::Ray& ray, const PieceSink& sink)
      : field_(field), ray_(ray), sink_(sink) {}

  bool piece(double t0, double t1, int depth, double parent_residual) {
    // Probes between the Chebyshev points, unevenly, so that no periodic field fools them all.
    static constexpr double kProbes[4] = {0.047, 0.291, 0.567, 0.838};
    Samples samples;
    for (int i = 0; i < kNodes; ++i) samples[i] = value(t0 + chebyshev(i) * (t1 - t0));
    // Relative to the first sample, which also makes a constant field constant to the last bit.
    const double base = samples[0];
    const Samples b = to_bernstein() * (samples - Samples::Constant(base));
    RayPiece fitted{t0, t1, {}};
    fitted.p.degree = kDegree;
    for (int k = 0; k < kNodes; ++k) fitted.p.b[k] = base + b[k];
    double residual = 0;
    for (const double u : kProbes) {
      residual = std::max(residual, std::abs(fitted.p(u) - value(t0 + u * (t1 - t0))));
    }
    // Halving a smooth stretch divides the residual by up to 2^10. Where it hardly shrinks and is small
    // already, it is the field's own rounding, or a kink whose share of the integral is far smaller still.
    const bool noise = residual <= 1e-9 * largest_ && residual > 0.1 * parent_residual;
    // 50 halvings reach the last digits of t: what is left there is a jump.
    const double middle = 0.5 * (t0 + t1);
    if (residual <= 4e-14 * largest_ || noise || depth >= 50 || !(middle > t0 && middle < t1)) {
      return sink_(fitted);
    }
    return piece(t0, middle, depth + 1, residual) && piece(middle, t1, depth + 1, residual);
  }

  double value(double t) {
    ++evaluations;
    const double f = field_.value(ray_.origin + t * ray_.direction);
    largest_ = std::max(largest_, std::abs(f));
    return f;
  }

  std::int64_t evaluations = 0;

 private:
  const FieldView& field_;
  const camera::Ray& ray_;
  const PieceSink& sink_;
  double largest_ = 0;
};

}  // namespace

std::int64_t fit_pieces(const FieldView& field, const camera::Ray& ray, const Chord& chord,
                        const PieceSink& sink) {
  constexpr int kStart = 8;
  Fit fit(field, ray, sink);
  for (int i = 0; i <= 64; ++i) (void)fit.value(chord.entry + chord.length() * i / 64);  // the scale of f
  for (int i = 0; i < kStart; ++i) {
    const double t0 = chord.entry + chord.length() * i / kStart;
    const double t1 = i + 1 == kStart ? chord.exit : chord.entry + chord.length() * (i + 1) / kStart;
    if (!fit.piece(t0, t1, 0, std::numeric_limits<double>::infinity())) break;
  }
  return fit.evaluations;
}

}  // namespace vol::render
