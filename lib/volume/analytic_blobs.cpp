// gaussian, gaussians, bust: sums of Gaussians with axes along x, y, z.
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/rng.h"
#include "volume/analytic_form.h"

namespace vol::volume {
namespace {

struct Blob {
  double amplitude;
  Vec3 centre;
  Vec3 sigma;  // standard deviation along x, y, z
};

/// f(p) = sum a exp(-|(p - c) / sigma|^2 / 2), the quotient per axis.
class Blobs : public AnalyticForm {
 public:
  explicit Blobs(std::vector<Blob> blobs) : blobs_(std::move(blobs)) {}

  /// Scaled to a peak of 1, as far as a lattice of 24^3 points and the centres show it.
  [[nodiscard]] Blobs normalised() && {
    constexpr int kLattice = 24;
    double peak = 0;
    for (int n = 0; n < kLattice * kLattice * kLattice; ++n) {
      const Vec3 ijk(n % kLattice, n / kLattice % kLattice, n / kLattice / kLattice);
      peak = std::max(peak, value((2.0 / (kLattice - 1)) * ijk - Vec3::Ones()));
    }
    for (const auto& blob : blobs_) peak = std::max(peak, value(blob.centre));
    for (auto& blob : blobs_) blob.amplitude /= peak;
    return std::move(*this);
  }

  double value(const Vec3& p) const override {
    double sum = 0;
    for (const auto& blob : blobs_) sum += at(blob, p);
    return sum;
  }
  Vec3 gradient(const Vec3& p) const override {
    Vec3 sum = Vec3::Zero();
    for (const auto& blob : blobs_) {
      sum -= at(blob, p) * (p - blob.centre).cwiseQuotient(blob.sigma.cwiseAbs2());
    }
    return sum;
  }

 private:
  static double at(const Blob& blob, const Vec3& p) {
    return blob.amplitude * std::exp(-0.5 * (p - blob.centre).cwiseQuotient(blob.sigma).squaredNorm());
  }
  std::vector<Blob> blobs_;
};

std::vector<Blob> cloud(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Blob> blobs;
  for (int n = 0; n < 20; ++n) {
    const Vec3 centre(rng.uniform(-0.7, 0.7), rng.uniform(-0.7, 0.7), rng.uniform(-0.7, 0.7));
    const double sigma = rng.uniform(0.08, 0.25);
    blobs.push_back({rng.uniform(0.3, 1), centre, Vec3::Constant(sigma)});
  }
  return blobs;
}

/// Up is +y, the face looks to +z.
std::vector<Blob> bust() {
  return {
      {1.0, {0, 0.42, 0.02}, {0.19, 0.24, 0.21}},         // skull
      {0.8, {0, 0.22, 0.12}, {0.13, 0.12, 0.13}},         // jaw
      {0.9, {0, -0.05, -0.03}, {0.11, 0.20, 0.11}},       // neck
      {0.9, {0, -0.55, -0.05}, {0.38, 0.18, 0.17}},       // shoulders
      {0.9, {0, -0.85, 0.02}, {0.30, 0.22, 0.20}},        // chest
      {0.45, {0, 0.36, 0.30}, {0.04, 0.07, 0.05}},        // nose
      {-0.35, {0.085, 0.44, 0.27}, {0.05, 0.035, 0.05}},  // eye sockets
      {-0.35, {-0.085, 0.44, 0.27}, {0.05, 0.035, 0.05}},
      {0.35, {0.24, 0.38, 0}, {0.03, 0.07, 0.05}},  // ears
      {0.35, {-0.24, 0.38, 0}, {0.03, 0.07, 0.05}},
  };
}

}  // namespace

FormPointer make_blob_form(std::string_view name, const AnalyticOptions& options) {
  if (name == "gaussian") {
    return std::make_shared<Blobs>(std::vector<Blob>{{1, Vec3::Zero(), Vec3::Constant(kGaussianSigma)}});
  }
  if (name == "gaussians") return std::make_shared<Blobs>(Blobs(cloud(options.seed)).normalised());
  if (name == "bust") return std::make_shared<Blobs>(Blobs(bust()).normalised());
  return nullptr;
}

}  // namespace vol::volume
