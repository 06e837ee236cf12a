#pragma once
#include <memory>

#include "render/raycast.h"
#include "wavelet/expansion.h"

namespace vol::render {

/// What footprints cost, and what is known of their error.
struct FootprintReport {
  /// Terms drawn by boxes (haar), by a product of two functions (views along an axis), by tables, exactly.
  std::int64_t terms_boxes = 0, terms_products = 0, terms_tables = 0, terms_exact = 0;
  std::int64_t tables = 0;  ///< number of footprints, those cut off by the box's faces included
  std::int64_t table_bytes = 0;
  double range = 0;     ///< of the picture's values, at least: found at some pixels
  double allowed = 0;   ///< the error asked for times that range
  double estimate = 0;  ///< of the largest error of a pixel, by the tables' own errors
  double rounding = 0;  ///< of terms from tables, were they added in float: about the largest error
  double found = 0;     ///< largest error at the pixels that were integrated exactly
};

/// X-ray pictures of a wavelet expansion in parallel projection, by footprints (Gross, Lippert, Dreger & Koch
/// 1995): the line integrals of a basis function over all rays are one function of two variables, the same
/// for all terms of a level and orientation but for their place, and from level to level but for a dilation.
///
/// - haar: the footprints of boxes are closed forms; a term is 2 x 2 x 2 boxes.
/// - Views along an axis: a footprint is a product of two functions of one variable.
/// - Else by tables: sampled at the pixels around a term, for many places of the term between pixels
///   (FootprintPhases), and added row by row. A ray's part before it enters the box, and that behind its
///   exit, sees only terms that reach over the face it passes; how far depends on one coordinate of the term
///   alone. So each such distance is a footprint too, cut off at the face, and is taken off the pixels that
///   enter (leave) there.
/// - What tables cannot do within the error asked for, or not cheaper: exactly, ray by ray (WaveletXray).
///   That goes for factors that jump: those folded to the period, and axes of one sample.
///
/// The error asked for is the largest of a pixel, as a share of the range of the picture's values. The range
/// is taken from below, at up to 40 pixels that are integrated exactly. Tables are made finer until the
/// estimate is within it: with e the rms of a table's deviations from line_integral() at some hundred places
/// spread evenly, and m 1.7 times the largest of them and of half as many where each table so far was
/// roughest (a factor from trials, not from theory), the error of a pixel that terms of amplitude A reach is
/// taken for 5 sqrt(sum A^2 e^2) + 1.5 max A m at most, because the terms' places between pixels, and so
/// their errors, are as good as independent; and for sum |A| m where that is less. Then the picture is
/// compared with the exact pixels, and tables are made finer still where one of them is off by more than
/// allowed. An estimate, no guarantee. Of noise at random views, at 1e-2 to 1e-4, the largest error of a
/// pixel was 0.26 of what is allowed (18 pictures each of daubechies-4, 6 of coiflet-6:
/// tests/bench/footprint_calibration).
///
/// Refers to the expansion, which must live longer; made for one view. Pictures have the same bits for any
/// number of threads.
class WaveletFootprints {
 public:
  /// Makes the tables. Of options, width and height count.
  /// \param error  > 0, share of the picture's range
  /// \throws vol::Error on another error, a perspective view, or a picture that memory does not hold
  WaveletFootprints(const wavelet::Expansion& expansion, const Scene& scene, const RenderOptions& options,
                    double error);
  ~WaveletFootprints();
  WaveletFootprints(const WaveletFootprints&) = delete;
  WaveletFootprints& operator=(const WaveletFootprints&) = delete;

  /// As WaveletXray::draw, but samples are the footprints whose rectangles hold a pixel, at least those met.
  /// \throws vol::Error on a pixel that float cannot hold
  [[nodiscard]] RenderResult draw();

  [[nodiscard]] const FootprintReport& report() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vol::render
