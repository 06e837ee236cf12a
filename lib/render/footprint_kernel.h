#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "base/buffer.h"

namespace vol::render {

/// How a footprint is read between its samples.
enum class Taps { linear, cubic };

/// A footprint at all pixels around a term, for every place that the term may take between pixels: plane
/// (q, p) holds at [row][column] the footprint at the pixel offset (first_column + column - p /
/// column_phases, first_row + row - q / row_phases). There are planes for p = 0 .. column_phases with linear
/// taps, for p = -1 .. column_phases + 1 with cubic ones; q likewise. Of each row only what matters is
/// stored, in chunks of 8 or 16 columns.
struct FootprintPhases {
  Taps taps = Taps::cubic;
  int column_phases = 1, row_phases = 1;
  int first_column = 0, first_row = 0, columns_reached = 0, rows = 0;
  int chunk = 16;                     ///< columns, 8 or 16
  std::vector<std::int32_t> columns;  ///< first one of each chunk
  std::vector<std::int32_t> begin;    ///< of each row its first chunk; one more, the number of chunks
  Buffer<float> values;               ///< [q][p][chunk][column]

  /// Planes beyond those of places between a pixel and the next.
  [[nodiscard]] int before() const { return taps == Taps::cubic ? 1 : 0; }
  [[nodiscard]] int across() const { return column_phases + 1 + 2 * before(); }
  [[nodiscard]] int down() const { return row_phases + 1 + 2 * before(); }
  [[nodiscard]] std::int64_t plane() const { return static_cast<std::int64_t>(columns.size()) * chunk; }
  [[nodiscard]] std::int64_t bytes() const {
    return static_cast<std::int64_t>(values.size() * sizeof(float));
  }
  /// Where the chunks lie in a picture with rows that far apart, from the window's first pixel on. A window
  /// may be many times as high as the picture: what int holds does not do.
  [[nodiscard]] std::vector<std::int64_t> offsets(std::int64_t stride) const;
};

/// Columns that a row of a picture has before its first and behind its last: chunks are added as a whole.
inline constexpr int kFootprintPadding = 16;

/// A term in the picture: its centre lies at column + u / column_phases, u in [0, column_phases), and so on.
struct Splat {
  float amplitude = 0;
  int column = 0, row = 0;
  float u = 0, v = 0;
};

/// Pixel numbers of places far outside a picture stay within what int can hold.
[[nodiscard]] inline int floor_pixel(double p) {
  const double near = std::clamp(p, -1e9, 1e9);
  const int towards_0 = static_cast<int>(near);  // without a call of the library
  return towards_0 - static_cast<int>(near < towards_0);
}
[[nodiscard]] inline int ceil_pixel(double p) {
  return -floor_pixel(-p);
}

/// Some rows of a picture; rows are `stride` apart, padded by kFootprintPadding at both ends.
template <class T>
struct PictureRows {
  T* values = nullptr;  ///< first column of the first row
  std::int64_t stride = 0;
  int width = 0, first = 0, count = 0;
};

/// picture += amplitude * footprint for every splat. Sums of taps are float, those of splats T.
/// \param offsets  of the phases, for the picture's stride
void add_splats(const FootprintPhases& phases, const std::vector<std::int64_t>& offsets,
                std::span<const Splat> splats, const PictureRows<float>& picture);
void add_splats(const FootprintPhases& phases, const std::vector<std::int64_t>& offsets,
                std::span<const Splat> splats, const PictureRows<double>& picture);

/// The same for one splat and one pixel, plainly.
[[nodiscard]] double splat_value(const FootprintPhases& phases, const Splat& splat, int column, int row);

/// A piecewise constant function on 2 x 2 x 2 boxes (1 along an axis whose halves are one).
struct OctantCell {
  std::array<double, 3> k{};      ///< of the term; the cell is scale (k + lower .. k + upper) - shift
  std::array<int, 3> halves{};    ///< 1 or 2
  std::array<double, 8> value{};  ///< bit a: second half of axis a
};

/// What the cells of a level have in common.
struct OctantLevel {
  std::array<double, 3> scale{}, shift{}, lower{}, upper{};
};

/// One row of a picture and its rays (see PixelRow).
struct RayRow {
  const double* middle[3];
  const double* half;
  std::array<double, 3> direction;
};

/// values[x] += integral of the cell along ray x within the box, x in [begin, end). Intervals are half open
/// and crossings are found by the arithmetic of wavelet::line_integral where a direction is within 1e-6 of
/// the axis: on a jump both say the same.
void add_octants(const OctantCell& cell, const OctantLevel& level, const RayRow& row, int begin, int end,
                 double* values);

}  // namespace vol::render
