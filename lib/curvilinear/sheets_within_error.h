#pragma once
#include "curvilinear/cast_solids.h"
#include "curvilinear/sheets.h"

namespace vol::curvilinear {

struct WithinErrorCounts {
  SheetCounts sheets;            ///< of the picture that is left; 0 where no pixel is by sheets
  std::int64_t samples = 0;      ///< of all pictures by sheets that were drawn, those to estimate by included
  std::int64_t rays = 0;         ///< cast in all
  std::int64_t ray_samples = 0;  ///< reconstructions of f along them
  std::int64_t redrawn = 0;      ///< pixels by rays because of their estimate
  std::int64_t checked = 0;      ///< pixels of sheets, taken at random, held against their ray; in all checks
  std::int64_t missed = 0;       ///< of these: off by more than max_error, while their estimate was not
};

struct WithinErrorResult {
  image::Image image;  ///< R, G, B, A, samples, error
  WithinErrorCounts counts;
  double error_estimate = 0;  ///< largest of the channel `error`; above max_error: that was not reached
  /// Pixels of the last check, in which none was off by more; 0: none by sheets was left.
  std::int64_t last_checked = 0;
  double largest_checked = 0;  ///< difference in the last check
  double throttle = 0;         ///< of the sheets; 0: there are none
};

/// A picture by sheets of physical thickness whose largest error against rays (cast_solids) is, by every
/// pixel's own estimate, at most max_error, on the colour scale (linear, 0 to 1; alpha too).
///
/// Cells that differ from the solid of their group by less than tolerances are drawn as one (merged_cells.h);
/// tolerances and steps come from the throttle, and that from max_error: halved while more than an eighth of
/// the pixels is estimated to be off by more. A pixel's estimate is the largest of three: twice what it, or a
/// neighbour, changes from twice the throttle with cells by depth, where order matters, too; and by how much
/// it changes where all values are off by their tolerance, which finds rays that graze what is opaque; and
/// its second differences in the picture times the root of the pixels that solids may be off by, which find
/// silhouettes; all that as far around as solids may be off. Pixels whose estimate is above max_error are
/// drawn by rays, to a quarter of it; a picture that shows fewer pixels than (merged) cells, by rays
/// altogether.
///
/// Estimates are no bounds. So kChecked or more pixels by sheets, taken at random from those that have
/// samples, or one that has near by (as far as solids may be off), are held against their rays; where one is
/// off by more than max_error, all estimates are doubled (and are half of max_error at least), what is then
/// above is drawn by rays, and the check repeated, at most kMostChecks times, at last with rays throughout.
/// Only the last check supports a claim, and each of the kMostChecks may pass by chance: with 95 % confidence
/// over the choice of pixels, less than -log(0.05 / kMostChecks) / last_checked = 4.4 / last_checked of the
/// pixels that it was taken from are off from their rays by more than max_error (the rule of three for
/// several looks, after Bonferroni).
///
/// \param options  cells, beta and thinned_by; the rest plays no part
/// \param scene    of model composite, without shading; with a reference length
/// \throws vol::Error as draw_sheets and cast_solids do, unless max_error is positive and finite, and where
/// values are not finite or not one a point of every block
[[nodiscard]] WithinErrorResult draw_within_error(const SolidRays& rays,
                                                  const std::vector<std::vector<double>>& values,
                                                  const render::Scene& scene, int width, int height,
                                                  const SheetOptions& options, double max_error);
inline constexpr std::int64_t kChecked = 512;
inline constexpr int kMostChecks = 4;

}  // namespace vol::curvilinear
