#pragma once
#include "curvilinear/cast_solids.h"
#include "curvilinear/sheets.h"

namespace vol::curvilinear {

struct WithinErrorCounts {
  SheetCounts sheets;        ///< of the last picture that was drawn
  std::int64_t rays = 0;     ///< cast in all
  std::int64_t redrawn = 0;  ///< pixels by rays because of their estimate
  std::int64_t checked = 0;  ///< pixels of sheets, taken at random, that were held against their ray
  std::int64_t missed =
      0;  ///< of these: pixels off by more than the largest error, while their estimate was not
};

struct WithinErrorResult {
  image::Image image;  ///< R, G, B, A, samples, error
  WithinErrorCounts counts;
  double error_estimate = 0;   ///< largest of the channel `error`; above the largest error: it is not kept
  double largest_checked = 0;  ///< difference, of the last check
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
/// its second difference in the picture times the root of the pixels that solids may be off by, which finds
/// silhouettes. Pixels whose estimate is above max_error are drawn by rays, to a quarter of it; a picture
/// that shows fewer pixels than (merged) cells, by rays altogether.
///
/// Estimates are no bounds. So kChecked or more
/// pixels of those that are left, taken at random, are held against their rays; where one is off by more, all
/// estimates are doubled, what is then above is drawn by rays, and the check repeated, at last with rays
/// throughout. A picture that passes has, with 95 % confidence, less than 3 / checked of its sheets' pixels
/// off by more.
///
/// \param options  cells, beta and thinned_by; the rest plays no part
/// \param scene    of model composite, without shading; with a reference length
/// \throws vol::Error as draw_sheets and cast_solids do, and unless max_error is positive and finite
[[nodiscard]] WithinErrorResult draw_within_error(const SolidRays& rays,
                                                  const std::vector<std::vector<double>>& values,
                                                  const render::Scene& scene, int width, int height,
                                                  const SheetOptions& options, double max_error);
inline constexpr std::int64_t kChecked = 512;

}  // namespace vol::curvilinear
