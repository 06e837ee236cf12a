#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "render/footprint_kernel.h"
#include "render/parallel_view.h"
#include "wavelet/expansion.h"
#include "wavelet/footprint.h"

namespace vol::render {

/// A line, by its pixel from a footprint's centre, and its true integral.
struct FootprintLine {
  double column = 0, row = 0, integral = 0;
};

/// Terms of one band that share a footprint: all of them, or, cut off at the face where rays enter (leave),
/// those at one distance from it, of which what is outside counts.
struct FootprintPart {
  const wavelet::Band* band = nullptr;
  std::vector<wavelet::Term> own_terms;  ///< of a cut; else the band's
  int cut = -1;                          ///< 0 entry, 1 exit
  double limit = 0;                      ///< of the third axis' function where it is cut
  std::size_t table = 0;                 ///< number in its group
  double amplitude = 1;  ///< of a coefficient: world length a unit of the footprint; < 0 for a cut
  double peak = 1;       ///< about the largest value of the whole band's footprint, in this one's units

  // Pixels to table: (X, Y) = centre + matrix (pixel - that of the term's centre).
  std::array<double, 2> centre{};
  std::array<std::array<double, 2>, 2> matrix{};
  // Column and row of the centre of the term at k: first + sum_a step[a] k[a].
  std::array<double, 2> first{};
  std::array<std::array<double, 2>, 3> step{};
  /// Pixels around the centre that the function reaches: least and most column, least and most row.
  std::array<double, 4> reach{};

  std::optional<FootprintPhases> phases;  ///< else pixels look into the table
  /// With phases, numbers of terms: those at the same place between pixels together, as they read the same
  /// planes.
  std::vector<std::uint32_t> order;
  /// What tables of any quality are held against: lines at places spread evenly, and where a table so far was
  /// rough.
  std::vector<FootprintLine> even_lines, rough_lines;

  void drop_phases() {
    phases.reset();
    order = {};
  }
  [[nodiscard]] std::span<const wavelet::Term> terms() const {
    return cut < 0 ? std::span<const wavelet::Term>(band->terms) : std::span<const wavelet::Term>(own_terms);
  }
  [[nodiscard]] std::array<double, 2> centre_of(const wavelet::Term& term) const {
    std::array<double, 2> p = first;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < 2; ++i) p[i] += step[a][i] * term.k[a];
    }
    return p;
  }
  /// \param scale  what coefficients are multiplied by
  [[nodiscard]] Splat splat(const wavelet::Term& term, double scale) const {
    const auto p = centre_of(term);
    const int column = floor_pixel(p[0]), row = floor_pixel(p[1]);
    return {static_cast<float>(term.c * scale), column, row,
            static_cast<float>(std::clamp(p[0] - column, 0.0, 1.0) * phases->column_phases),
            static_cast<float>(std::clamp(p[1] - row, 0.0, 1.0) * phases->row_phases)};
  }
};

/// Parts whose footprints come of one sweep over the lines: bands of all levels with the same three
/// functions, or all cuts of a band at one face.
struct FootprintGroup {
  int axis = 2;  ///< that the lines are integrated along
  int cut = -1;
  bool below = true;
  wavelet::FootprintLines lines;
  std::vector<double> limits;
  std::vector<FootprintPart> parts;

  int quality = 0;     ///< steps made finer
  bool exact = false;  ///< tables cannot do it
  std::vector<wavelet::FootprintTable> tables;
  double rms = 0, largest = 0;  ///< deviation of what is drawn from the truth, of footprints of amplitude 1

  [[nodiscard]] std::int64_t bytes() const;
};

/// How fine tables are: distance of samples, and how pixels are taken from them.
struct FootprintQuality {
  double step;
  Taps taps;
};
inline constexpr int kFootprintQualities = 8;
[[nodiscard]] FootprintQuality footprint_quality(int number);

/// Geometry of a part of a band: centre, matrix, reach.
[[nodiscard]] FootprintPart make_part(const ParallelView& view, const wavelet::Band& band, int axis, int cut,
                                      double limit);

/// About the largest value of a group's footprint, cut off nowhere, by samples an eighth apart.
[[nodiscard]] double peak_of(const wavelet::FootprintLines& lines);

/// What tables of a quality would cost, in about nanoseconds of one thread, and take.
struct FootprintPrice {
  double time = 0;
  std::int64_t bytes = 0;
};
[[nodiscard]] FootprintPrice price(const FootprintGroup& group, int quality);

/// Makes tables and phases, and measures their deviation at random places against line_integral().
/// \param negligible  share of a part's peak below which pixels may be left out
void make_tables(const wavelet::Expansion& expansion, const ParallelView& view, int quality,
                 double negligible, FootprintGroup& group);

}  // namespace vol::render
