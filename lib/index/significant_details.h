#pragma once
#include <array>
#include <string>
#include <vector>

#include "index/bit_grid.h"
#include "wavelet/decomposition.h"
#include "wavelet/dwt.h"

namespace vol::index {

/// How a detail coefficient is put on the scale of epsilon. An orthonormal 3-D coefficient at level m times
/// 2^(-3m/2) is on the data's own scale (amplitude); orthonormal takes it as it is.
enum class Normalisation { amplitude, orthonormal };

/// When a detail is significant.
/// magnitude (He 1998): |d| > epsilon, whatever the level.
/// segment: 2^m |d| > epsilon. The detail of level m bends the field over the length of a step of level m;
/// the
///   error of a step is that bend times its length, and a sum of steps is cheapest for its error when every
///   step carries the same error, so longer steps must meet smaller details.
enum class Rule { magnitude, segment };

struct SignificanceOptions {
  double epsilon = 0;  ///< on the field's scale; details at or below it do not count
  Normalisation normalisation = Normalisation::amplitude;
  Rule rule = Rule::magnitude;
  double energy_share = 1;  ///< of a basis function, that its relevant support holds; 1: the full support
};

/// Voxels, relative to 2^m k, on which coefficient k of level m bears, per axis: both the scaling function
/// and the wavelet, cut to the smallest interval holding `share` of each one's energy.
struct RelevantSupport {
  std::int64_t first;
  std::int64_t last;
};
[[nodiscard]] RelevantSupport relevant_support(const std::string& wavelet, int level, double share);

/// The significant detail coefficients of one level: one bit each, set if it is significant in any
/// orientation.
struct SignificantLevel {
  BitGrid coefficients;
  std::array<std::int64_t, 3> lower{0, 0, 0};  ///< index in the transform of coefficient (0, 0, 0)
  RelevantSupport support{0, 0};
};

/// Which coefficients of a volume's transform are significant, for each level 1..M: 1/56 byte a voxel. A
/// coefficient is relevant to the voxels under the support of its basis function, or under the smallest
/// interval per axis that holds the stated share of the 3-D function's energy (share^(1/3) per axis).
struct SignificantDetails {
  Dims dims{0, 0, 0};           ///< of the volume
  Dims extended_dims{0, 0, 0};  ///< of the box that was transformed
  wavelet::Boundary boundary = wavelet::Boundary::periodic;
  std::vector<SignificantLevel> levels;

  SignificantDetails() = default;
  /// None is significant yet. \throws vol::Error as the transform does
  SignificantDetails(const Dims& dims, const wavelet::DwtOptions& dwt, double energy_share);
};

/// What a detail must exceed to be significant, for each level 1..M of a field whose largest magnitude is
/// `largest`. Details below 8 ulp of it count as zero: a transform leaves that much where a field is
/// constant.
template <class T>
[[nodiscard]] std::vector<T> significance_thresholds(const SignificanceOptions& options, int levels,
                                                     double largest);

/// Adds to `details` those of a part of the volume: `part` is the transform of the box of voxels from `begin`
/// on, a multiple of 2^M along every axis and 0 along x, so that parts of other rows may be added at the same
/// time.
template <class T>
void add_significant(const wavelet::Decomposition<T>& part, const std::vector<T>& thresholds,
                     const Dims& begin, SignificantDetails& details);

/// The significant details of a volume's transform.
template <class T>
[[nodiscard]] SignificantDetails significant_details(const wavelet::Decomposition<T>& decomposition,
                                                     const SignificanceOptions& options);

}  // namespace vol::index
