#pragma once
#include <vector>

#include "render/footprint_kernel.h"
#include "render/parallel_view.h"
#include "wavelet/expansion.h"

namespace vol::render {

/// The terms of an expansion in haar functions at one place of one level are a function that is constant on
/// 2 x 2 x 2 boxes; one of them is the footprint's closed form: the length of a ray within it.
struct OctantCells {
  OctantLevel level;
  std::vector<OctantCell> cells;
};

/// Whether all factors of an expansion are those of haar.
[[nodiscard]] bool is_haar(const wavelet::Expansion& expansion);

/// One entry a level. \pre is_haar() holds
[[nodiscard]] std::vector<OctantCells> make_octant_cells(const wavelet::Expansion& expansion);

/// Adds the integrals of all cells to the rows first .. first + count - 1 of a picture, a stride apart.
/// \param rays  all rows of the picture
/// \param met   if given, +1 where a cell begins in a row, -1 behind its end
void add_cells(const OctantCells& cells, const ParallelView& view, const std::vector<PixelRow>& rays,
               int first, int count, std::int64_t stride, double* values, std::int32_t* met);

}  // namespace vol::render
