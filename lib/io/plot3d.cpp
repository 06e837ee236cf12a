// PLOT3D grids and solutions, as NASA's program of that name and OVERFLOW write them.
#include "base/error.h"
#include "curvilinear/flow.h"
#include "io/grid_formats.h"
#include "io/header_text.h"
#include "io/plot3d_layout.h"

namespace vol::io {
namespace {

/// The planes of a block: all of the first variable, then all of the second ...
void add_solution(const Plot3dNumbers& numbers, const Plot3dFit& fit, curvilinear::Grid& grid) {
  const std::int64_t real = numbers.real_size(fit.form);
  for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
    curvilinear::Block& block = grid.blocks[b];
    const auto points = static_cast<std::int64_t>(block.points.size());
    for (std::int64_t v = 0; v < 5; ++v) {
      curvilinear::PointArray array{std::string(curvilinear::kConserved[v]), {}};
      array.values.reserve(block.points.size());
      for (std::int64_t n = 0; n < points; ++n) {
        array.values.push_back(numbers.real(fit.data[b] + (v * points + n) * real, fit.form));
      }
      block.arrays.push_back(std::move(array));
    }
  }
  static constexpr const char* kReference[4] = {"plot3d.mach", "plot3d.alpha", "plot3d.re", "plot3d.time"};
  for (int n = 0; n < 4; ++n) {
    grid.attributes[kReference[n]] = shortest(numbers.real(fit.reference[0] + n * real, fit.form));
  }
}

}  // namespace

curvilinear::Grid read_plot3d(InputFile& file, const GridOptions& options) {
  const Plot3dNumbers numbers(display_name(file.path()), file.read_rest(options.memory_limit));
  const Plot3dFit fit = fit_plot3d(numbers, options.plot3d, {});
  curvilinear::Grid grid;
  const std::int64_t real = numbers.real_size(fit.form), integer = numbers.integer_size();
  for (std::size_t b = 0; b < fit.dims.size(); ++b) {
    curvilinear::Block& block = grid.blocks.emplace_back();
    block.dims = fit.dims[b];
    const std::int64_t points = block.dims[0] * block.dims[1] * block.dims[2];
    block.points.reserve(static_cast<std::size_t>(points));
    for (std::int64_t n = 0; n < points; ++n) {
      const auto coordinate = [&](std::int64_t a) {
        return numbers.real(fit.data[b] + (a * points + n) * real, fit.form);
      };
      block.points.emplace_back(coordinate(0), coordinate(1), coordinate(2));
    }
    // IBLANK 0 is no flow; negative numbers name the block that a fringe point is interpolated from.
    for (std::int64_t n = 0; fit.form.iblank && n < points; ++n) {
      const std::int64_t blank = numbers.integer(fit.data[b] + 3 * points * real + n * integer, fit.form);
      block.hidden.push_back(blank == 0 ? 1 : 0);
    }
  }
  grid.attributes["plot3d.layout"] = fit.form.text();
  if (!options.solution.empty()) {
    InputFile solution(options.solution);
    const Plot3dNumbers values(display_name(options.solution), solution.read_rest(options.memory_limit));
    add_solution(values, fit_plot3d(values, options.plot3d, fit.dims), grid);
  }
  return grid;
}

}  // namespace vol::io
