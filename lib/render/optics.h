#pragma once
#include <vector>

#include "transfer/transfer_function.h"

namespace vol::render {

/// A stretch of values over which opacity and colour are linear: ends `lo` and `hi`, with the limits from
/// within, so that jumps belong to neither side. The outermost stretches are constant and unbounded.
struct OpticsInterval {
  double lo, hi;
  double opacity_lo, opacity_hi;
  Vec3 colour_lo, colour_hi;

  [[nodiscard]] double position(double value) const;  ///< of a value in [lo, hi], in [0, 1]
  [[nodiscard]] double opacity(double value) const;
  [[nodiscard]] Vec3 colour(double value) const;
  [[nodiscard]] bool transparent() const { return opacity_lo == 0 && opacity_hi == 0; }
  [[nodiscard]] bool opaque() const { return opacity_lo == 1 && opacity_hi == 1; }
};

/// A transfer function cut into its linear intervals, with the world length its opacities are for.
class Optics {
 public:
  /// \throws vol::Error unless reference_length is positive and finite
  Optics(const transfer::TransferFunction& transfer, double reference_length);

  [[nodiscard]] double reference_length() const { return reference_length_; }
  [[nodiscard]] const transfer::TransferFunction& transfer() const { return transfer_; }
  /// n + 1 intervals around the n breakpoints.
  [[nodiscard]] const std::vector<OpticsInterval>& intervals() const { return intervals_; }
  /// Number of the interval with lo <= value < hi.
  [[nodiscard]] std::size_t interval_of(double value) const;
  /// Largest component of any colour.
  [[nodiscard]] double brightest() const { return brightest_; }

 private:
  transfer::TransferFunction transfer_;
  double reference_length_;
  std::vector<OpticsInterval> intervals_;
  double brightest_ = 0;
};

}  // namespace vol::render
