#pragma once
#include <vector>

#include "base/vec.h"

namespace vol::transfer {

struct ColourPoint {
  double value;
  Vec3 rgb;  ///< linear light
};

struct OpacityPoint {
  double value;
  double opacity;  ///< in [0, 1], for one reference length
};

/// Maps a value of the scalar field to colour and opacity, after interpolation. Colour and opacity are linear
/// in the value between points and hold their end values outside. Two points at one value are a jump: at the
/// value itself the second holds.
class TransferFunction {
 public:
  TransferFunction() = default;
  /// Points in order of value. \throws vol::Error when a list is empty, unordered, not finite, or an opacity
  /// lies outside [0, 1], or a colour is negative.
  TransferFunction(std::vector<ColourPoint> colours, std::vector<OpacityPoint> opacities);

  [[nodiscard]] Vec3 colour(double value) const;
  [[nodiscard]] double opacity(double value) const;
  /// Largest and smallest opacity for values in [lo, hi]: exact, by the points inside.
  [[nodiscard]] double max_opacity(double lo, double hi) const;
  [[nodiscard]] double min_opacity(double lo, double hi) const;
  /// All values at which colour or opacity has a kink, ascending, without repeats.
  [[nodiscard]] const std::vector<double>& breakpoints() const { return breakpoints_; }
  [[nodiscard]] const std::vector<ColourPoint>& colours() const { return colours_; }
  [[nodiscard]] const std::vector<OpacityPoint>& opacities() const { return opacities_; }

 private:
  std::vector<ColourPoint> colours_;
  std::vector<OpacityPoint> opacities_;
  std::vector<double> breakpoints_;
};

/// Colour and opacity proportional to the value from lo to hi: black to white, opacity 0 to 0.1.
[[nodiscard]] TransferFunction grey_ramp(double lo, double hi);

}  // namespace vol::transfer
