#pragma once
#include <vector>

#include "index/bit_grid.h"
#include "wavelet/decomposition.h"

namespace vol::index {

/// How a detail coefficient is put on the scale of epsilon. An orthonormal 3-D coefficient at level m times
/// 2^(-3m/2) is on the data's own scale (amplitude); orthonormal takes it as it is.
enum class Normalisation { amplitude, orthonormal };

/// When a detail is significant.
/// magnitude (He 1998): |d| > epsilon, whatever the level.
/// segment: 2^m |d| > epsilon. The detail of level m bends the field over the length of a step of level m; the
///   error of a step is that bend times its length, and a sum of steps is cheapest for its error when every step
///   carries the same error, so longer steps must meet smaller details.
enum class Rule { magnitude, segment };

struct SignificanceOptions {
  double epsilon = 0;              ///< on the field's scale; details at or below it do not count
  Normalisation normalisation = Normalisation::amplitude;
  Rule rule = Rule::magnitude;
  double energy_share = 1;         ///< of a basis function, that its relevant support holds; 1: the full support
};

/// For each level 1..M the voxels for which some detail coefficient of that level is significant and relevant; a
/// coefficient is relevant to the voxels under the support of its basis function, or under the smallest interval
/// per axis that holds the stated share of the 3-D function's energy (share^(1/3) per axis).
///
/// Details below 8 ulp of max|f| count as zero: a transform leaves that much where a field is constant.
template <class T>
[[nodiscard]] std::vector<BitGrid> significant_details(const wavelet::Decomposition<T>& decomposition,
                                                       const SignificanceOptions& options);

/// Voxels, relative to 2^m k, on which coefficient k of level m bears, per axis: both the scaling function and the
/// wavelet, cut to the smallest interval holding `share` of each one's energy.
struct RelevantSupport {
  std::int64_t first;
  std::int64_t last;
};
[[nodiscard]] RelevantSupport relevant_support(const std::string& wavelet, int level, double share);

}  // namespace vol::index
