#include "render/extinction_integral.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vol::render {
namespace {

/// Behind this optical depth T is below 1e-21: nothing of alpha or of a colour up to 1e5 changes.
constexpr double kOpaque = 50;
constexpr int kMostPanels = 1000;  // of a stretch

/// Integral of p over [0, u].
double integral_to(const Bernstein& p, double u) {
  Bernstein left, right;
  p.split(u, left, right);
  return u * left.integral();
}

/// u in [u0, u1] where the integral of p, of one sign, over [0, u] is `wanted`.
double where_integral_is(const Bernstein& p, double wanted, double u0, double u1) {
  const bool rises = p.integral() > 0;
  for (int step = 0; step < 54; ++step) {
    const double u = 0.5 * (u0 + u1);
    ((integral_to(p, u) < wanted) == rises ? u0 : u1) = u;
  }
  return 0.5 * (u0 + u1);
}

}  // namespace

ExtinctionIntegral::ExtinctionIntegral(const Options& options, double ray_length, Light light)
    : options_(options), ray_length_(ray_length), light_(std::move(light)) {}

bool ExtinctionIntegral::add(const RayPiece& piece) {
  const double lo = piece.p.min(), hi = piece.p.max();
  largest_ = std::max({largest_, std::abs(lo), std::abs(hi)});
  if (lo == 0 && hi == 0) return true;
  cuts_.assign(1, 0.0);
  append_crossings(piece.p, 0, cuts_);
  if (light_ && options_.headlight) append_crossings(piece.p.derivative(), 0, cuts_);
  cuts_.push_back(1);
  std::sort(cuts_.begin(), cuts_.end());
  double deepest = 0;
  Bernstein rest = piece.p;
  double from = 0;
  for (std::size_t i = 1; i < cuts_.size(); ++i) {
    const double to = cuts_[i];
    if (!(to > from)) continue;
    Bernstein part = rest;
    if (to < 1) {
      const Bernstein whole = rest;
      whole.split((to - from) / (1 - from), part, rest);
    }
    const double length = piece.t1 - piece.t0;
    if (!options_.keep_negative && part.integral() < 0) {
      clamped_depth_ -= length * (to - from) * part.integral();
      deepest = std::max(deepest, -part.min());
    } else {
      stretch(part, piece.t0 + from * length, i + 1 == cuts_.size() ? piece.t1 : piece.t0 + to * length);
    }
    from = to;
  }
  if (deepest > 0) clamped_.push_back(deepest);
  return options_.keep_negative || depth_ < kOpaque;
}

std::int64_t ExtinctionIntegral::clamped_pieces() const {
  return std::count_if(clamped_.begin(), clamped_.end(),
                       [&](double deep) { return deep > 1e-12 * largest_; });
}

/// f does not change sign between t0 and t1.
void ExtinctionIntegral::stretch(const Bernstein& f, double t0, double t1) {
  panels_ = 0;
  Bernstein p = f;  // in optical depth over u
  for (double& b : p.b) b *= t1 - t0;
  const double begin = depth_, end = depth_ + p.integral();
  if (half_ == std::numeric_limits<double>::infinity() && end >= std::numbers::ln2) {
    half_ = t0 + (t1 - t0) * where_integral_is(p, std::numbers::ln2 - begin, 0, 1);
  }
  if (light_) {
    const double share = std::max((t1 - t0) / ray_length_, 1e-3);
    double u = 0, depth = begin;
    while (u < 1) {
      if (depth < -700) {  // light without bound
        colour_ = -std::numeric_limits<double>::infinity();
        break;
      }
      // Where T is as good as 0 nothing is seen: on to where it is not, if it ever is.
      if (depth >= kOpaque && end >= kOpaque) break;
      const double step = std::clamp(end - depth, -2.0, 2.0);
      const double next = depth > kOpaque ? kOpaque : depth + step;
      const double to = next == end ? 1 : std::max(where_integral_is(p, next - begin, u, 1), u + 0x1p-50);
      if (depth <= kOpaque) {
        lit_panel(p, t0, t1, u, std::min(to, 1.0), options_.tolerance * share * (to - u), 0);
      }
      u = to;
      depth = begin + integral_to(p, std::min(u, 1.0));
    }
  }
  depth_ = end;
}

void ExtinctionIntegral::lit_panel(const Bernstein& p, double t0, double t1, double u0, double u1,
                                   double tolerance, int level) {
  const double begin = depth_ + integral_to(p, u0), end = depth_ + integral_to(p, u1);
  const double seen = -std::exp(-begin) * std::expm1(begin - end);  // T0 - T1
  const auto light = [&](double u) { return light_(t0 + u * (t1 - t0))(Vec3::Ones())[0]; };
  // Gauss-Kronrod 3-7: Piessens et al., QUADPACK, 1983.
  static constexpr double kX[4] = {0, 0.434243749346802558002, 0.774596669241483377036,
                                   0.960491268708020283424};
  static constexpr double kKronrod[4] = {0.450916538658474142345, 0.401397414775962222905,
                                         0.268488089868333440729, 0.104656226026467265194};
  static constexpr double kGauss[4] = {8.0 / 9, 0, 5.0 / 9, 0};
  const double middle = 0.5 * (u0 + u1);
  double fine_weights = 0, fine = 0, coarse_weights = 0, coarse = 0;
  for (int node = -3; node <= 3; ++node) {
    const int i = std::abs(node);
    const double u = middle + 0.5 * (u1 - u0) * (node < 0 ? -kX[i] : kX[i]);
    const double density = p(u) * std::exp(begin - depth_ - integral_to(p, u));
    const double lit = light(u);
    fine_weights += kKronrod[i] * density;
    fine += kKronrod[i] * density * lit;
    coarse_weights += kGauss[i] * density;
    coarse += kGauss[i] * density * lit;
  }
  if (fine_weights == 0 || coarse_weights == 0) {  // nothing is there, or all of it in front of the nodes
    if (seen != 0) colour_ += seen * light(u0);
    return;
  }
  const double mean = fine / fine_weights;
  // Where |N.L| has a kink between the nodes, both means may be off alike: hence a factor.
  const double error = 8 * std::abs(seen * (mean - coarse / coarse_weights));
  // Below, rounding; 40 halvings leave 1e-12 of the piece. Kinks and jumps of the light are halved into a
  // corner; a normal that is noise everywhere would take panels without end.
  ++panels_;
  if (!(error > std::max(tolerance, 1e-15 * options_.brightest)) || level == 40 || panels_ > kMostPanels) {
    colour_ += seen * mean;
    error_ += error;
    return;
  }
  lit_panel(p, t0, t1, u0, middle, 0.5 * tolerance, level + 1);
  lit_panel(p, t0, t1, middle, u1, 0.5 * tolerance, level + 1);
}

Pixel ExtinctionIntegral::pixel() const {
  Pixel pixel;
  pixel.alpha = -std::expm1(-depth_);
  pixel.colour = Vec3::Constant(light_ ? colour_ : pixel.alpha);
  pixel.depth = half_;
  pixel.error = error_;
  return pixel;
}

}  // namespace vol::render
