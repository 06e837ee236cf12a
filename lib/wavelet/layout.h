#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "wavelet/decomposition.h"
#include "wavelet/filters.h"

namespace vol::wavelet {

inline constexpr int kMaxLevels = 30;

/// The box that `levels` levels transform: every axis of more than one sample, rounded up to a multiple of
/// 2^levels. Throws vol::Error, naming the largest number of levels that fits, when levels is outside
/// 0..kMaxLevels or when the extension would multiply the number of voxels by more than 8 (small volumes may
/// grow to 2^24 voxels).
[[nodiscard]] Dims extended_dims(const Dims& dims, int levels);

/// Consecutive indices lower .. lower + count - 1.
struct IndexRange {
  std::int64_t lower = 0;
  std::int64_t count = 0;
  friend bool operator==(const IndexRange&, const IndexRange&) = default;
};

/// Where the coefficients of each level lie: ranges[0] the extended box itself, ranges[m] the coefficients of
/// level m, the same for both bands of an axis.
///
/// periodic: half as many each level, from 0. symmetric: every k whose synthesis window [2k + first, 2k +
/// last] meets the range of the level below, so that it can be rebuilt exactly; each level's approximation is
/// extended by half-sample reflection at its own ends.
[[nodiscard]] std::vector<std::array<IndexRange, 3>> layout(const Wavelet& wavelet, Boundary boundary,
                                                            const Dims& extended, int levels);

/// Number of coefficients of a transform (a double: it may be beyond any memory). Throws like
/// extended_dims().
[[nodiscard]] double coefficient_count(const Wavelet& wavelet, Boundary boundary, const Dims& dims,
                                       int levels);

/// Element of a signal of n samples that position p (counted from its first) stands for.
[[nodiscard]] std::int64_t wrapped_index(Boundary boundary, std::int64_t p, std::int64_t n);

/// Voxel that position p >= 0 of the extended box takes its value from; -1 means the value 0.
[[nodiscard]] std::int64_t extension_source(Extension extension, std::int64_t p, std::int64_t n);

/// Throws vol::Error unless the decomposition is one that analyze() can have made: known wavelet, levels and
/// dims that belong together, exactly the subbands of the layout, each with its dims, lower and number of
/// coefficients. Decompositions come from files.
template <class T>
void validate(const Decomposition<T>& decomposition);

}  // namespace vol::wavelet
