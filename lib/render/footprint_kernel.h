#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vol::render {

/// How a footprint is read between its samples.
enum class Taps { linear, cubic };

/// A footprint at all pixels around a term, for every place that the term may take between pixels:
/// plane (q, p), q = 0 .. rows_phases-1, p = 0 .. column_phases-1, holds at [row][column] the footprint at
/// the pixel offset (first_column + column - p / column_phases, first_row + row - q / row_phases).
struct FootprintPhases {
  Taps taps = Taps::cubic;
  int column_phases = 1, row_phases = 1;
  int first_column = 0, first_row = 0, columns = 0, rows = 0;
  std::int64_t stride = 0;    ///< of rows; what is between is 0
  std::vector<float> values;  ///< [q][p][row][column], with kFootprintPadding more at the end
  struct Run {
    int begin, end;
  };
  std::vector<Run> runs;  ///< of each row: columns where any place sees something
  /// Where all columns of a row can be written, it is read in whole chunks from a column on, which may take
  /// in more columns than its run but never another row's.
  struct Chunks {
    int begin, count;
  };
  int chunk = 16;              ///< 8 or 16 columns
  std::vector<Chunks> chunks;  ///< of each row

  [[nodiscard]] std::int64_t bytes() const {
    return static_cast<std::int64_t>(values.size() * sizeof(float));
  }
};
inline constexpr int kFootprintPadding = 16;

/// A term in the picture: its centre lies at column + u / column_phases, u in [0, column_phases), and so on.
struct Splat {
  double amplitude = 0;
  int column = 0, row = 0;
  float u = 0, v = 0;
};

/// Pixel numbers of places far outside a picture stay within what int can hold.
[[nodiscard]] inline int floor_pixel(double p) {
  return static_cast<int>(std::floor(std::clamp(p, -1e9, 1e9)));
}
[[nodiscard]] inline int ceil_pixel(double p) {
  return static_cast<int>(std::ceil(std::clamp(p, -1e9, 1e9)));
}

/// Some rows of a picture; rows are `stride` apart, padded by kFootprintPadding.
template <class T>
struct PictureRows {
  T* values = nullptr;
  std::int64_t stride = 0;
  int width = 0, first = 0, count = 0;
  /// If given, for each row the columns that may be written.
  const FootprintPhases::Run* window = nullptr;
};

/// picture += amplitude * footprint for every splat. Sums of taps are float, those of splats T.
void add_splats(const FootprintPhases& phases, const Splat* splats, std::size_t count,
                const PictureRows<float>& picture);
void add_splats(const FootprintPhases& phases, const Splat* splats, std::size_t count,
                const PictureRows<double>& picture);

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
