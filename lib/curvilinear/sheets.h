#pragma once
#include <cstdint>
#include <vector>

#include "camera/camera.h"
#include "curvilinear/cell_order.h"
#include "curvilinear/grid.h"
#include "curvilinear/solid.h"
#include "image/image.h"
#include "transfer/transfer_function.h"

namespace vol::curvilinear {

/// What a sheet's opacity follows. layers, after Bethel 1993: opacities are those of a cell, whatever its
/// size, and each of its n sheets has 1 - exp(-phi(a) / n), phi(a) = -log(1 - a). physical: opacities are for
/// a reference length, and a sheet has 1 - exp(-phi(a) l / reference length) in a pixel whose ray travels the
/// world length l inside it.
enum class Thickness { layers, physical };

struct SheetOptions {
  CellKind cells = CellKind::tricubic;
  double beta = 1;
  Thickness thickness = Thickness::layers;
  CellOrder order = CellOrder::faces;
  /// Pixels from point to point (layers) and from sheet to sheet; physical: tolerances between points, too.
  double throttle = 1;
  bool merge = false;       ///< draw groups of cells as one where they differ by no more than tolerances
  bool along_rays = false;  ///< order the cells of one block, too, along each pixel's ray (gaps.h)
  /// A channel `error`: by how much pixels change where all values are off by their tolerance, one way or the
  /// other. A sensitivity, no bound: values off one way here and the other way there are not tried.
  bool sensitivity = false;
  double thinned_by = 1;  ///< optical depths are divided by it: global_layers(), or 1
};

/// The paper's non-linear opacity function takes the whole grid for gamma log(m) layers of one material, m
/// the smallest of the three cell counts of its blocks: 1 - exp(-phi(a) / (gamma log m)). Where log m is
/// below 1 (m of 1 and 2; of 1 the paper's has no value) it counts as 1, so that gamma 1 never makes a grid
/// more opaque.
[[nodiscard]] double global_layers(const Grid& grid, double gamma);

struct SheetCounts {
  std::int64_t cells = 0;        ///< that are not missing and meet the picture
  std::int64_t circles = 0;      ///< of cells that hide one another in turn
  std::int64_t split = 0;        ///< cells in them that were split
  std::int64_t unresolved = 0;   ///< circles of their parts that are left
  std::int64_t sheets = 0;       ///< drawn; layers: once for each band of 32 rows that a cell meets
  std::int64_t points = 0;       ///< by forward differences; layers: likewise
  std::int64_t samples = 0;      ///< composited into a pixel
  std::int64_t off_samples = 0;  ///< composited besides, for the sensitivity
  std::int64_t redundant = 0;    ///< points that fall on a pixel their sheet has already
  std::int64_t holes = 0;  ///< pixels without a sample between two, on either side or above and below, with
};

struct SheetResult {
  image::Image image;  ///< R, G, B, A, samples; error
  SheetCounts counts;
};

/// Pixels that a cell may be across by physical thickness: its parts along a ray are as many as pictures have
/// room in it.
inline constexpr int kMostPixels = 1 << 20;

/// Draws a grid by sheets of constant parameter after Bethel 1993: cells front to back by their smallest
/// depth; each along that of its axes whose sheets show the largest area, sheets front to back; their points
/// by forward differences, step counts from the extent in the picture.
///
/// layers: points at the middles of the steps, each composited into the pixel it falls into, once a sheet.
///
/// physical: the paper's third remedy. The surfaces between sheets, and the cell's sides, are scan-converted
/// as triangles; what a pixel's ray travels from one to the next is the length l. Points are as many as a
/// bound on second differences asks for: chords miss the cell by a tenth of `throttle` pixels at most, values
/// by `throttle` / 500 of their range, or of the transfer function's where that is less. Cells whose sheets
/// turn away from the eye are halved before. So a homogeneous medium comes out right at silhouettes too
/// (tests/curvilinear/test_homogeneous.cpp). Not promised: the order of sheets where a ray passes through a
/// cell back and forth, nor of parts in the circles that are left, nor of cells of one block that have no
/// face in common: they come by depth. Of several blocks, cells come in the order of the pixels' rays
/// (gaps.h).
///
/// \param values    of the points of every block
/// \param reference_length  world length that opacities are for (physical)
/// Cells that reach far beyond the picture are halved until their parts lie outside or do so no more; sheets
/// of such parts are no more than their shape and values ask for.
///
/// \throws vol::Error where the eye of a perspective view is within or behind a solid, and where a cell in
/// the picture is larger than kMostPixels (physical) or kMostSteps throttles (layers)
[[nodiscard]] SheetResult draw_sheets(const Grid& grid, const std::vector<std::vector<double>>& values,
                                      const camera::Camera& camera,
                                      const transfer::TransferFunction& transfer, double reference_length,
                                      const SheetOptions& options);

}  // namespace vol::curvilinear
