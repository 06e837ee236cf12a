#include "transfer/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "transfer/piecewise_linear.h"

namespace vol::transfer {

TransferFunction::TransferFunction(std::vector<ColourPoint> colours, std::vector<OpacityPoint> opacities)
    : colours_(std::move(colours)), opacities_(std::move(opacities)) {
  require_ordered(colours_, "colour");
  require_ordered(opacities_, "opacity");
  for (const auto& p : colours_) {
    if (!p.rgb.allFinite() || p.rgb.minCoeff() < 0)
      throw Error("colour with a component that is negative or not finite");
  }
  for (const auto& p : opacities_) {
    if (!(p.opacity >= 0 && p.opacity <= 1)) {
      throw Error("opacity " + std::to_string(p.opacity) + " is outside 0 to 1");
    }
  }
  for (const auto& p : colours_) breakpoints_.push_back(p.value);
  for (const auto& p : opacities_) breakpoints_.push_back(p.value);
  std::sort(breakpoints_.begin(), breakpoints_.end());
  breakpoints_.erase(std::unique(breakpoints_.begin(), breakpoints_.end()), breakpoints_.end());
}

Vec3 TransferFunction::colour(double value) const {
  return interpolate(colours_, value, [](const ColourPoint& p) { return p.rgb; });
}

double TransferFunction::opacity(double value) const {
  return interpolate(opacities_, value, [](const OpacityPoint& p) { return p.opacity; });
}

double TransferFunction::max_opacity(double lo, double hi) const {
  double most = std::max(opacity(lo), opacity(hi));
  for (const auto& p : opacities_) {
    if (p.value >= lo && p.value <= hi) most = std::max(most, p.opacity);
  }
  return most;
}

double TransferFunction::min_opacity(double lo, double hi) const {
  double least = std::min(opacity(lo), opacity(hi));
  for (const auto& p : opacities_) {
    if (p.value >= lo && p.value <= hi) least = std::min(least, p.opacity);
  }
  return least;
}

TransferFunction grey_ramp(double lo, double hi) {
  return {{{lo, Vec3::Zero()}, {hi, Vec3::Ones()}}, {{lo, 0}, {hi, 0.1}}};
}

}  // namespace vol::transfer
