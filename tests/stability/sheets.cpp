#include "curvilinear/sheets.h"

#include <sstream>

#include "curvilinear/phantom.h"
#include "kernels.h"

// Pictures of curvilinear grids by sheets, whose values are narrowed to float as shares of the transfer
// function's stretch.
namespace vol::stability {
namespace {

using namespace curvilinear;

image::Image picture(const Grid& grid, double scale, double offset, Thickness thickness) {
  std::vector<std::vector<double>> values{grid.blocks[0].arrays[0].values};
  for (double& f : values[0]) f = offset + scale * f;
  const transfer::TransferFunction transfer({{offset, {0, 0, 1}}, {offset + scale, {1, 0, 0}}},
                                            {{offset, 0}, {offset + scale, 0.7}});
  camera::View view;
  view.azimuth = 40;
  view.elevation = 10;
  const Box3 box = grid.bounds();
  const camera::Camera camera(view, box.centre(), box.size().maxCoeff(), 60, 50);
  SheetOptions options;
  options.thickness = thickness;
  return draw_sheets(grid, values, camera, transfer, 0.5, options).image;
}

}  // namespace

/// A picture does not change where values and the transfer function move together: against that of values
/// from 0 to 1.
void sheets(Table& table) {
  const Grid grid = make_phantom("twisted-box", {4, 5, 6}, "marschner-lobb", 1);
  for (const auto thickness : {Thickness::physical, Thickness::layers}) {
    const image::Image plain = picture(grid, 1, 0, thickness);
    const auto row = [&](const std::string& what, double scale, double offset) {
      const image::Image moved = picture(grid, scale, offset, thickness);
      // A value at the edge of a step may fall into the next one.
      const double rounding = std::abs(offset) / scale * 4 * kDouble;
      Worst worst;
      for (std::size_t n = 0; n < plain.pixels.size(); ++n) {
        if (n % 5 == 4) continue;
        worst.add(std::abs(static_cast<double>(moved.pixels[n]) - plain.pixels[n]), 0x1p-14 + 4 * rounding);
      }
      table.row(what, thickness == Thickness::physical ? "sheets, physical" : "sheets, layers", "float",
                worst, "a step of the table, 2^-14; values to 4 u of the offset");
    };
    row("a signal of 1 on 1e8", 1, 1e8);
    row("a signal of 1 on -1e12", 1, -1e12);
    row("values to 1e-30", 1e-30, 0);
    row("values to 1e30", 1e30, 0);
  }
}

}  // namespace vol::stability
