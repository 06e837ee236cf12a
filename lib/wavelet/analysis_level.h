#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "wavelet/layout.h"

namespace vol::wavelet {

/// Samples that a level reads: x fastest, of any voxel type, converted a row at a time.
template <class T>
struct RowSource {
  const std::byte* data = nullptr;
  Dims dims{1, 1, 1};  ///< of what is stored; extension and boundary are in the plans
  std::size_t element_size = sizeof(T);
  void (*convert)(const std::byte* row, std::int64_t count, T* to) = nullptr;  ///< null: the samples are T
};

/// One axis of one analysis level. Positions count from the first sample that the first window touches:
/// coefficient k of the band uses positions 2k + offset[r], r = 0 .. taps - 1.
template <class T>
struct AnalysisAxis {
  bool transformed = true;
  std::int64_t outputs = 1;          ///< coefficients a band
  std::vector<std::int64_t> offset;  ///< in the order of summation, small taps first
  std::vector<T> h, g;               ///< in the same order
  std::int64_t interior = 0;         ///< position of sample 0; samples follow it one by one
  std::vector<std::int64_t> source;  ///< sample at each position, -1 for the value 0

  [[nodiscard]] std::int64_t taps() const { return static_cast<std::int64_t>(h.size()); }
  [[nodiscard]] int bands() const { return transformed ? 2 : 1; }
};

/// \param in, out  ranges of the level below and of this level's coefficients
/// \param stored   samples that are stored along the axis: fewer than in.count where the box was extended
template <class T>
[[nodiscard]] AnalysisAxis<T> analysis_axis(const Wavelet& wavelet, Boundary boundary, Extension extension,
                                            const IndexRange& in, const IndexRange& out, std::int64_t stored,
                                            bool transformed);

/// One level along all axes: bands[orientation] receives outputs[0] x outputs[1] x outputs[2] coefficients;
/// orientations with a wavelet along an axis that is not transformed stay untouched.
template <class T>
void analyze_level(const RowSource<T>& source, const std::array<AnalysisAxis<T>, 3>& axes,
                   const std::array<T*, 8>& bands);

/// Cut of one axis into tiles of nearly equal size.
[[nodiscard]] inline std::int64_t tile_begin(std::int64_t tile, std::int64_t tiles, std::int64_t count) {
  return tile * count / tiles;
}

/// Taps of an infinite filter whose magnitudes sum to less than this cannot be told from rounding in T.
template <class T>
inline constexpr double kTail = sizeof(T) == 4 ? 1e-9 : 1e-16;

/// Scratch of a task is kept near this size, so that the planes in work stay in the second-level cache.
inline constexpr std::int64_t kScratchBytes = 768 * 1024;

}  // namespace vol::wavelet
