#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "render/footprint_part.h"

namespace vol::render {

/// Columns begin .. end - 1 of a row.
struct PixelRun {
  int begin = 0, end = 0;
};

/// Pixels whose rays enter the box (first index 0) or leave it (1) through the faces across an axis, row by
/// row; and their number.
struct FaceWindows {
  std::array<std::array<std::vector<PixelRun>, 3>, 2> rows;
  std::array<std::array<std::int64_t, 3>, 2> pixels{};
};

/// Sum of amplitude times footprint over all terms of those parts that have phases, at every pixel; cut parts
/// count within their face's window. Row after row, width * height values.
///
/// Terms are cut into shares of equal work, each added up on its own, and sums of shares are added in order:
/// the same bits for any number of threads.
/// \param in_float  terms of a share are added in float, else in double
[[nodiscard]] std::vector<double> sum_of_splats(const std::vector<FootprintGroup>& groups,
                                                const FaceWindows& windows, int width, int height,
                                                bool in_float);

}  // namespace vol::render
