#include <gtest/gtest.h>

#include "curvilinear/cast_solids.h"
#include "generic.h"

namespace vol::agreement {
namespace {

constexpr int kWidth = 17, kHeight = 13;

/// The volume's voxels as the points of a curvilinear grid.
curvilinear::Grid grid_of(const volume::GridGeometry& geometry) {
  curvilinear::Grid grid;
  grid.blocks.emplace_back();
  auto& block = grid.blocks.back();
  block.dims = geometry.dims;
  for (std::int64_t k = 0; k < geometry.dims[2]; ++k) {
    for (std::int64_t j = 0; j < geometry.dims[1]; ++j) {
      for (std::int64_t i = 0; i < geometry.dims[0]; ++i) {
        block.points.push_back(geometry.index_to_world(Vec3(double(i), double(j), double(k))));
      }
    }
  }
  return grid;
}

render::RenderOptions options() {
  render::RenderOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.reconstruction = volume::Reconstruction::catmull_rom;
  options.tolerance = 1e-9;
  return options;
}

// On a regular grid the cells are boxes, and the solids' field, Bezier form of cubics with the derivatives
// (f[i+1] - f[i-1]) / 2, is the Catmull-Rom interpolation of the voxels; at the border both go on as the
// parabola through three samples. So rays through 64 control points a cell and rays through 64 voxels a cell
// meet the same field: pictures agree to the tolerance of both and to the float of a pixel, on noise, in
// every model.
TEST(CellsAndRays, TricubicSolidsOfARegularGridAreCatmullRom) {
  const auto volume = noise(oblique_geometry({6, 4, 5}), 21);
  const auto& voxels = std::get<volume::Grid<double>>(volume.grid);
  const curvilinear::Grid grid = grid_of(voxels.geometry);
  const std::vector<std::vector<double>> values = {{voxels.voxels.begin(), voxels.voxels.end()}};
  const curvilinear::SolidRays solids(grid, values, curvilinear::CellKind::tricubic, 1);
  const transfer::TransferFunction transfer({{0.2, Vec3(0.1, 0.3, 1)}, {0.8, Vec3(1, 0.8, 0.2)}},
                                            {{0.1, 0}, {0.5, 0.6}, {0.9, 0.3}});
  for (const auto model : {render::Model::xray, render::Model::composite, render::Model::mip}) {
    for (const bool perspective : {false, true}) {
      render::Scene scene = oblique_scene(model, 6);
      scene.transfer = transfer;
      if (perspective) {
        scene.view.projection = camera::Projection::perspective;
        scene.view.distance = 9;
      }
      const auto by_cells = curvilinear::cast_solids(solids, scene, options()).image;
      const auto by_rays = render::raycast_reference(volume, scene, options()).image;
      for (const int channel : {0, 1, 2, 3}) {
        const auto found = compare(by_cells, by_rays, channel, kWidth, kHeight);
        EXPECT_LT(found.largest, 2e-7 * std::max(1.0, found.peak))
            << int(model) << ' ' << perspective << ' ' << channel;
        EXPECT_GT(found.peak, 0.2);
      }
    }
  }
}

// And trilinear solids are the trilinear interpolation.
TEST(CellsAndRays, TrilinearSolidsOfARegularGridAreTrilinear) {
  const auto volume = noise(oblique_geometry({3, 5, 4}), 22);
  const auto& voxels = std::get<volume::Grid<double>>(volume.grid);
  const curvilinear::Grid grid = grid_of(voxels.geometry);
  const std::vector<std::vector<double>> values = {{voxels.voxels.begin(), voxels.voxels.end()}};
  const curvilinear::SolidRays solids(grid, values, curvilinear::CellKind::trilinear, 1);
  const render::Scene scene = oblique_scene(render::Model::xray, 6);
  auto trilinear = options();
  trilinear.reconstruction = volume::Reconstruction::trilinear;
  const auto found = compare(curvilinear::cast_solids(solids, scene, trilinear).image,
                             render::raycast_reference(volume, scene, trilinear).image, 0, kWidth, kHeight);
  EXPECT_LT(found.largest, 2e-7 * found.peak);
  EXPECT_GT(found.peak, 0.5);
}

}  // namespace
}  // namespace vol::agreement
