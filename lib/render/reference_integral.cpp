#include "render/reference_integral.h"

#include <algorithm>
#include <cmath>

namespace vol::render {
namespace {

/// Of the brightest colour: below it, halving follows the rounding of the pieces' polynomials without end.
constexpr double kLeastTolerance = 1e-14;

}  // namespace

ReferenceIntegral::ReferenceIntegral(const Optics& optics, double tolerance, double ray_length,
                                     double brightest, Light light, bool headlight, const Beam& before)
    : optics_(optics),
      tolerance_(std::max(tolerance, kLeastTolerance * std::max(1.0, brightest))),
      ray_length_(ray_length),
      brightest_(std::max(1.0, brightest)),  // alpha is a channel too
      light_(std::move(light)),
      headlight_(headlight),
      pixel_(before.pixel),
      transmittance_(before.transmittance),
      done_(before.transmittance == 0) {}

bool ReferenceIntegral::add(const RayPiece& piece) {
  const double lo = piece.p.min();
  const double hi = piece.p.max();
  if (optics_.transfer().max_opacity(lo, hi) == 0) return true;
  cuts_.assign(1, 0.0);
  const auto& points = optics_.transfer().breakpoints();
  for (auto it = std::upper_bound(points.begin(), points.end(), lo); it != points.end() && *it < hi; ++it) {
    append_crossings(piece.p, *it, cuts_);
  }
  if (headlight_) append_crossings(piece.p.derivative(), 0, cuts_);
  cuts_.push_back(1);
  std::sort(cuts_.begin(), cuts_.end());
  const double share = std::max((piece.t1 - piece.t0) / ray_length_, 1e-3);
  for (std::size_t i = 0; i + 1 < cuts_.size() && !done_; ++i) {
    const double u0 = cuts_[i];
    const double u1 = cuts_[i + 1];
    if (!(u1 > u0)) continue;
    const OpticsInterval& interval = optics_.intervals()[optics_.interval_of(piece.p(0.5 * (u0 + u1)))];
    if (interval.transparent()) continue;
    if (interval.opaque() || (lo == hi && interval.opacity(lo) == 1)) {
      enter_opaque(piece, interval, u0);
    } else {
      integrate(piece, interval, u0, u1, tolerance_ * share * (u1 - u0), 0);
    }
  }
  return !done_;
}

double ReferenceIntegral::extinction(const RayPiece& piece, const OpticsInterval& optics, double u) const {
  // Gauss points never reach the end where a = 1, but rounding may: cap at the last opacity below 1.
  const double a = std::min(optics.opacity(piece.p(u)), 1 - 0x1p-53);
  return -std::log1p(-a) / optics_.reference_length();
}

ReferenceIntegral::Panel ReferenceIntegral::evaluate(const RayPiece& piece, const OpticsInterval& optics,
                                                     double u0, double u1) {
  constexpr int kN = GaussCollocation::kNodes;
  const GaussCollocation& gauss = gauss_collocation();
  const double length = (piece.t1 - piece.t0) * (u1 - u0);
  double sigma[kN];
  Vec3 colour[kN];
  for (int j = 0; j < kN; ++j) {
    const double u = u0 + gauss.x[j] * (u1 - u0);
    sigma[j] = extinction(piece, optics, u);
    colour[j] = optics.colour(piece.p(u));
    if (light_) colour[j] = light_(piece.t0 + u * (piece.t1 - piece.t0))(colour[j]);
  }
  evaluations_ += kN;

  Panel panel;
  double sigma_high = 0, sigma_high2 = 0, absorbed = 0;
  Vec3 high = Vec3::Zero(), high2 = Vec3::Zero();
  for (int j = 0; j < kN; ++j) {
    double tau = 0;
    for (int m = 0; m < kN; ++m) tau += gauss.up_to[j][m] * sigma[m];
    const double density = sigma[j] * std::exp(-length * tau);
    const Vec3 emitted = density * colour[j];
    panel.depth += gauss.w[j] * sigma[j];
    absorbed += gauss.w[j] * density;
    panel.emission += gauss.w[j] * emitted;
    sigma_high += gauss.coefficient_last[j] * sigma[j];
    sigma_high2 += gauss.coefficient_before[j] * sigma[j];
    high += gauss.coefficient_last[j] * emitted;
    high2 += gauss.coefficient_before[j] * emitted;
  }
  panel.depth *= length;
  panel.emission *= length;
  const double missed = std::abs(length * absorbed + std::expm1(-panel.depth));
  panel.error_depth = length * (std::abs(sigma_high) + std::abs(sigma_high2));
  panel.error_emission = length * (high.cwiseAbs() + high2.cwiseAbs()).maxCoeff() + missed * brightest_;
  return panel;
}

void ReferenceIntegral::integrate(const RayPiece& piece, const OpticsInterval& optics, double u0, double u1,
                                  double tolerance, int depth) {
  const Panel panel = evaluate(piece, optics, u0, u1);
  const double behind = std::exp(-panel.depth) * brightest_;  // what an error of the depth can change
  const double error = transmittance_ * (panel.error_emission + std::min(1.0, panel.error_depth) * behind);
  // Below a few ulp of what the ray gathers, estimates are rounding; 48 halvings exhaust the digits of u.
  const double rounding = 4e-16 * transmittance_ * brightest_ * std::min(1.0, panel.depth);
  if (!(error > std::max(tolerance, rounding)) || depth >= 48) {  // NaN too: it is told by the estimate
    accept(piece, optics, u0, u1, panel, error);
    return;
  }
  const double middle = 0.5 * (u0 + u1);
  integrate(piece, optics, u0, middle, 0.7 * tolerance, depth + 1);
  if (!done_) integrate(piece, optics, middle, u1, 0.7 * tolerance, depth + 1);
}

void ReferenceIntegral::accept(const RayPiece& piece, const OpticsInterval& optics, double u0, double u1,
                               const Panel& panel, double error) {
  const double behind = transmittance_ * std::exp(-panel.depth);
  if (transmittance_ > 0.5 && behind <= 0.5) {
    // T = 1/2 lies in this panel: bisect on the depth up to u, by the same rule on [u0, u].
    const GaussCollocation& gauss = gauss_collocation();
    const double wanted = std::log(2 * transmittance_);
    double lo = u0, hi = u1;
    for (int step = 0; step < 50; ++step) {
      const double u = 0.5 * (lo + hi);
      double tau = 0;
      for (int j = 0; j < GaussCollocation::kNodes; ++j) {
        tau += gauss.w[j] * extinction(piece, optics, u0 + gauss.x[j] * (u - u0));
      }
      (tau * (u - u0) * (piece.t1 - piece.t0) < wanted ? lo : hi) = u;
    }
    pixel_.depth = piece.t0 + hi * (piece.t1 - piece.t0);
  }
  pixel_.colour += transmittance_ * panel.emission;
  pixel_.alpha += transmittance_ * -std::expm1(-panel.depth);
  pixel_.error += error;
  transmittance_ = behind;
  const double rest = transmittance_ * brightest_;
  if (rest <= 1e-3 * tolerance_) {
    pixel_.error += rest;
    done_ = true;
  }
}

void ReferenceIntegral::enter_opaque(const RayPiece& piece, const OpticsInterval& optics, double u) {
  const double t = piece.t0 + u * (piece.t1 - piece.t0);
  Vec3 colour = optics.colour(piece.p(u));
  if (light_) colour = light_(t)(colour);
  ++evaluations_;
  if (transmittance_ > 0.5) pixel_.depth = t;
  pixel_.colour += transmittance_ * colour;
  pixel_.alpha += transmittance_;
  transmittance_ = 0;
  done_ = true;
}

}  // namespace vol::render
