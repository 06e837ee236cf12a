// protein: the electrostatic potential of a folded chain.
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/rng.h"
#include "volume/analytic_form.h"

namespace vol::volume {
namespace {

struct Charge {
  Vec3 position;
  double q;
};

Vec3 random_direction(Rng& rng) {
  Vec3 v(rng.normal(), rng.normal(), rng.normal());
  return v / v.norm();
}

/// A chain of charges: steps of one length that bend little, keep off the chain so far where they can, and
/// stay in a ball. Folding is kept to what gives a compact, lumpy, irregular body.
std::vector<Charge> folded_chain(std::uint64_t seed) {
  constexpr int kResidues = 120;
  constexpr double kStep = 0.14;
  constexpr double kRadius = 0.72;
  constexpr int kTrials = 12;
  Rng rng(seed);
  std::vector<Charge> chain;
  Vec3 at = Vec3::Zero();
  Vec3 along = random_direction(rng);
  for (int n = 0; n < kResidues; ++n) {
    const double sign = rng.uniform() < 0.5 ? -1 : 1;
    chain.push_back({at, sign * rng.uniform(0.3, 1)});
    Vec3 best = at;
    double best_clearance = -1;
    for (int trial = 0; trial < kTrials;
         ++trial) {  // of several turns, the one that keeps farthest from the chain
      const Vec3 heading = (along + random_direction(rng)).normalized();
      const Vec3 next = at + kStep * heading;
      double clearance = next.norm() < kRadius ? 1 : 0;
      for (const auto& charge : chain) clearance = std::min(clearance, (next - charge.position).norm());
      if (clearance > best_clearance) {
        best_clearance = clearance;
        best = next;
      }
    }
    if (best.norm() >= kRadius) best = at - kStep * at.normalized();  // no way out: back toward the centre
    along = (best - at).normalized();
    at = best;
  }
  return chain;
}

/// f(p) = sum q exp(-kappa s) / s, s = sqrt(|p - c|^2 + a^2): the potential screened over the length 1/kappa
/// (Debye & Hueckel 1923), softened by a so that it is smooth everywhere; scaled to a largest magnitude of 1
/// at a charge.
class Protein : public AnalyticForm {
 public:
  explicit Protein(std::uint64_t seed) : charges_(folded_chain(seed)) {
    double least = 0;
    double most = 0;
    for (const auto& charge : charges_) {
      least = std::min(least, value(charge.position));
      most = std::max(most, value(charge.position));
    }
    for (auto& charge : charges_) charge.q /= most;
    range_ = {least / most, 1};
  }
  double value(const Vec3& p) const override {
    double sum = 0;
    for (const auto& charge : charges_) {
      const double s = std::sqrt((p - charge.position).squaredNorm() + kSoftening * kSoftening);
      sum += charge.q * std::exp(-kKappa * s) / s;
    }
    return sum;
  }
  Vec3 gradient(const Vec3& p) const override {
    Vec3 sum = Vec3::Zero();
    for (const auto& charge : charges_) {
      const Vec3 r = p - charge.position;
      const double s = std::sqrt(r.squaredNorm() + kSoftening * kSoftening);
      // d/ds (exp(-kappa s) / s) = -(kappa + 1/s) exp(-kappa s) / s and ds/dp = r / s.
      sum -= charge.q * (kKappa + 1 / s) * std::exp(-kKappa * s) / (s * s) * r;
    }
    return sum;
  }
  Range range() const override { return range_; }

 private:
  static constexpr double kKappa = 7;  // a screening length of a fourteenth of the box
  static constexpr double kSoftening = 0.1;
  std::vector<Charge> charges_;
  Range range_;
};

}  // namespace

FormPointer make_protein_form(std::string_view name, const AnalyticOptions& options) {
  if (name == "protein") return std::make_shared<Protein>(options.seed);
  return nullptr;
}

}  // namespace vol::volume
