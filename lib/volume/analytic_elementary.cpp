// marschner-lobb, ramp, constant, noise.
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "base/rng.h"
#include "volume/analytic_form.h"

namespace vol::volume {
namespace {

constexpr double kPi = std::numbers::pi;

/// Marschner & Lobb 1994, section 5:
///   rho(x, y, z) = (1 - sin(pi z / 2) + alpha (1 + rho_r(sqrt(x^2 + y^2)))) / (2 (1 + alpha)),
///   rho_r(r) = cos(2 pi fM cos(pi r / 2)),  fM = 6, alpha = 0.25.
class MarschnerLobb : public AnalyticForm {
 public:
  double value(const Vec3& p) const override {
    const double r = std::hypot(p.x(), p.y());
    const double rho_r = std::cos(2 * kPi * kFrequency * std::cos(kPi * r / 2));
    return (1 - std::sin(kPi * p.z() / 2) + kAlpha * (1 + rho_r)) / (2 * (1 + kAlpha));
  }
  Vec3 gradient(const Vec3& p) const override {
    const double r = std::hypot(p.x(), p.y());
    // d rho_r / dr = pi^2 fM sin(pi r / 2) sin(2 pi fM cos(pi r / 2)); over r it tends to a finite limit, but
    // the direction (x, y) vanishes there.
    const double slope = kPi * kPi * kFrequency * std::sin(kPi * r / 2) *
                         std::sin(2 * kPi * kFrequency * std::cos(kPi * r / 2));
    const double radial = r > 0 ? kAlpha * slope / r : 0;
    return Vec3(radial * p.x(), radial * p.y(), -kPi / 2 * std::cos(kPi * p.z() / 2)) / (2 * (1 + kAlpha));
  }

 private:
  static constexpr double kFrequency = 6;
  static constexpr double kAlpha = 0.25;
};

/// (1 + g.p) / 2 with unequal slopes whose sum is 1: 0 at (-1,-1,-1), 1 at (1,1,1).
class Ramp : public AnalyticForm {
 public:
  double value(const Vec3& p) const override { return 0.5 + kSlope.dot(p); }
  Vec3 gradient(const Vec3&) const override { return kSlope; }

 private:
  const Vec3 kSlope{0.25, 0.15, 0.1};
};

class Constant : public AnalyticForm {
 public:
  double value(const Vec3&) const override { return 0.5; }
  Vec3 gradient(const Vec3&) const override { return Vec3::Zero(); }
};

/// 1/2 + a sum of cos(2 pi k.p + phase), wave vectors k uniform in the ball of 4 cycles per canonical unit,
/// which is 8 cycles an edge; a makes the standard deviation 1/8.
class Noise : public AnalyticForm {
 public:
  explicit Noise(std::uint64_t seed) {
    Rng rng(seed);
    while (waves_.size() < kWaves) {
      const Vec3 k(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      if (k.squaredNorm() > 1) continue;
      waves_.push_back({2 * kPi * kTopFrequency * k, rng.uniform(0, 2 * kPi)});
    }
  }
  double value(const Vec3& p) const override {
    double sum = 0;
    for (const auto& wave : waves_) sum += std::cos(wave.k.dot(p) + wave.phase);
    return 0.5 + kAmplitude * sum;
  }
  /// Along x every wave is a point on the circle that each step turns by k_x dx: products in place of
  /// cosines. It is set anew every kRun samples, so that rounding stays below kRun ulp.
  void row(std::span<const double> x, double y, double z, std::span<double> values) const override {
    if (x.size() < 2) return AnalyticForm::row(x, y, z, values);
    const double dx = (x.back() - x.front()) / static_cast<double>(x.size() - 1);
    std::array<double, kWaves> turn_re, turn_im, re, im;
    for (std::size_t w = 0; w < kWaves; ++w) {
      turn_re[w] = std::cos(waves_[w].k.x() * dx);
      turn_im[w] = std::sin(waves_[w].k.x() * dx);
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (i % kRun == 0) {
        for (std::size_t w = 0; w < kWaves; ++w) {
          const double angle = waves_[w].k.dot(Vec3(x[i], y, z)) + waves_[w].phase;
          re[w] = std::cos(angle);
          im[w] = std::sin(angle);
        }
      }
      std::array<double, kLanes> sums{};
      for (std::size_t w = 0; w < kWaves; w += kLanes) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] += re[w + lane];
      }
      values[i] = 0.5 + kAmplitude * std::accumulate(sums.begin(), sums.end(), 0.0);
      for (std::size_t w = 0; w < kWaves; ++w) {
        const double turned = re[w] * turn_re[w] - im[w] * turn_im[w];
        im[w] = re[w] * turn_im[w] + im[w] * turn_re[w];
        re[w] = turned;
      }
    }
  }
  Vec3 gradient(const Vec3& p) const override {
    Vec3 sum = Vec3::Zero();
    for (const auto& wave : waves_) sum -= std::sin(wave.k.dot(p) + wave.phase) * wave.k;
    return kAmplitude * sum;
  }

 private:
  static constexpr std::size_t kWaves = 64, kLanes = 8;
  static constexpr std::size_t kRun = 32;
  static constexpr double kTopFrequency = 4;  // cycles per canonical unit
  const double kAmplitude = std::sqrt(2.0 / kWaves) / 8;
  struct Wave {
    Vec3 k;  // radians per canonical unit
    double phase;
  };
  std::vector<Wave> waves_;
};

}  // namespace

FormPointer make_elementary_form(std::string_view name, const AnalyticOptions& options) {
  if (name == "marschner-lobb") return std::make_shared<MarschnerLobb>();
  if (name == "ramp") return std::make_shared<Ramp>();
  if (name == "constant") return std::make_shared<Constant>();
  if (name == "noise") return std::make_shared<Noise>(options.seed);
  return nullptr;
}

}  // namespace vol::volume
