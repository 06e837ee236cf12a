// A homogeneous medium shows what a renderer takes for lengths: its opacity is 1 - exp(-tau L), L the length
// of the ray inside, whatever the cells.
#include <gtest/gtest.h>

#include <cmath>

#include "curvilinear/cast_solids.h"
#include "homogeneous.h"
#include "ray_oracle.h"

namespace vol::curvilinear {
namespace {

camera::View from_above() {
  camera::View view;
  view.azimuth = 33;
  view.elevation = 21;
  return view;
}

struct OracleCase {
  const char* name;
  Dims dims;
  CellKind kind;
};
class RaysAgainstTheOracle : public testing::TestWithParam<OracleCase> {};

// In every pixel, L the length within the grid's own solids by independent root finding in extended
// precision.
TEST_P(RaysAgainstTheOracle, BeersLaw) {
  const OracleCase& c = GetParam();
  constexpr double kOpacity = 0.37;
  constexpr double kFloat = 1e-7;  // of a pixel: float channels of up to 1 are rounded by 6e-8
  const Grid grid = make_phantom(c.name, c.dims, "constant", 1);
  const std::vector<std::vector<double>> values{std::vector<double>(grid.blocks[0].points.size(), 0.5)};
  const SolidRays rays(grid, values, c.kind, 1);
  render::Scene scene;
  scene.view = from_above();
  scene.transfer = transfer::TransferFunction({{0, Vec3::Ones()}}, {{0, kOpacity}});
  scene.reference_length = 1;
  render::RenderOptions options;
  options.width = options.height = 18;
  options.tolerance = 1e-10;
  const auto picture = cast_solids(rays, scene, options).image;
  const camera::Camera camera(scene.view, grid.bounds().centre(), grid.bounds().size().maxCoeff(), 18, 18);
  int compared = 0, seen = 0;
  double largest = 0;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      int open = 0;
      const double length = length_by_cells(grid, c.kind, camera.ray(x + 0.5, y + 0.5), open);
      if (open != 0) continue;
      ++compared;
      seen += length > 0;
      const double expected = -std::expm1(length * std::log1p(-kOpacity));
      for (const int channel : {0, 3}) {
        const double off = std::abs(picture.at(x, y, channel) - expected);
        EXPECT_LT(off, kFloat) << x << ' ' << y;
        largest = std::max(largest, off);
      }
    }
  }
  RecordProperty("largest_error_in_billionths", std::to_string(1e9 * largest));
  EXPECT_GT(compared, 18 * 18 - 10);
  EXPECT_GT(seen, 30);
}

INSTANTIATE_TEST_SUITE_P(Phantoms, RaysAgainstTheOracle,
                         testing::Values(OracleCase{"half-torus", {4, 2, 2}, CellKind::tricubic},
                                         OracleCase{"spherical-shell", {3, 5, 9}, CellKind::tricubic},
                                         OracleCase{"twisted-box", {4, 3, 6}, CellKind::tricubic},
                                         OracleCase{"sheared-box", {3, 4, 2}, CellKind::tricubic},
                                         OracleCase{"c-grid", {9, 3, 4}, CellKind::tricubic},
                                         OracleCase{"c-grid", {9, 3, 4}, CellKind::trilinear},
                                         OracleCase{"delta-wing", {5, 6, 7}, CellKind::tricubic}),
                         [](const auto& of) {
                           std::string name = of.param.name;
                           std::erase(name, '-');
                           return name + (of.param.kind == CellKind::tricubic ? "Tricubic" : "Trilinear");
                         });

class Sheets : public testing::TestWithParam<const char*> {};

// Within 1 % at the default throttle, RMS over the pixels whose chord exceeds a tenth of the longest, in
// every phantom at its own size; and the plain sheets' glow, what is left of opacity by layers under the
// extinction that fits best, is many times that.
TEST_P(Sheets, FollowTheLength) {
  for (const PhantomName& phantom : phantom_names()) {
    if (phantom.name != GetParam()) continue;
    const Homogeneous medium(phantom.name, phantom.dims, from_above(), 256);
    const ChordErrors e = medium.errors(medium.draw(Thickness::physical, 1).image, Thickness::physical);
    const ChordErrors glow = medium.errors(medium.draw(Thickness::layers, 1).image, Thickness::layers);
    RecordProperty("rms", std::to_string(e.rms));
    RecordProperty("largest", std::to_string(e.largest));
    RecordProperty("glow_rms", std::to_string(glow.rms));
    EXPECT_GT(e.pixels, 2000);
    // An affine map is its own tessellation: float, relative to chords, cells' depths and sums of some
    // hundred.
    EXPECT_LT(e.rms, std::string_view(GetParam()) == "sheared-box" ? 1e-5 : 0.01);
    EXPECT_LT(std::abs(e.mean), 1e-3);
    EXPECT_GT(glow.rms, 10 * e.rms);
    EXPECT_GT(glow.rms, 0.02);
  }
}

INSTANTIATE_TEST_SUITE_P(Phantoms, Sheets,
                         testing::Values("half-torus", "spherical-shell", "twisted-box", "sheared-box",
                                         "c-grid", "delta-wing"),
                         [](const auto& of) {
                           std::string name = of.param;
                           std::erase(name, '-');
                           return name;
                         });

// Where the field varies too, sheets come to the integral along the rays as the throttle falls.
TEST(SheetsOfAField, ApproachTheIntegral) {
  const Grid grid = make_phantom("twisted-box", {5, 6, 8}, "marschner-lobb", 1);
  const std::vector<std::vector<double>> values{grid.blocks[0].arrays[0].values};
  render::Scene scene;
  scene.view = from_above();
  scene.transfer = transfer::TransferFunction({{0, Vec3(0, 0, 1)}, {1, Vec3(1, 0.5, 0)}}, {{0, 0}, {1, 0.9}});
  scene.reference_length = 0.5;
  render::RenderOptions options;
  options.width = options.height = 120;
  options.tolerance = 1e-7;
  const SolidRays rays(grid, values, CellKind::tricubic, 1);
  const image::Image right = cast_solids(rays, scene, options).image;
  const camera::Camera camera(scene.view, grid.bounds().centre(), grid.bounds().size().maxCoeff(), 120, 120);
  const auto error = [&](double throttle) {
    SheetOptions sheets;
    sheets.thickness = Thickness::physical;
    sheets.throttle = throttle;
    const auto drawn =
        draw_sheets(grid, values, camera, scene.transfer, scene.reference_length, sheets).image;
    double sum = 0;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 120; ++x) {
        for (int c = 0; c < 4; ++c) sum += std::pow(drawn.at(x, y, c) - right.at(x, y, c), 2);
      }
    }
    return std::sqrt(sum / (120 * 120 * 4));
  };
  const double coarse = error(8), middle = error(2), fine = error(0.5);
  SCOPED_TRACE(std::to_string(coarse) + ' ' + std::to_string(middle) + ' ' + std::to_string(fine));
  // Second order in the sheets, and tolerances in proportion to the throttle: a quarter of it, a quarter at
  // most.
  EXPECT_LT(middle, coarse / 3);
  EXPECT_LT(fine, middle / 3);
  EXPECT_LT(fine, 3e-4);
}

TEST(SheetsOfPerspectiveViews, FollowTheLength) {
  camera::View view = from_above();
  view.projection = camera::Projection::perspective;
  const Homogeneous medium("twisted-box", {9, 9, 17}, view, 256);
  const ChordErrors e = medium.errors(medium.draw(Thickness::physical, 1).image, Thickness::physical);
  EXPECT_GT(e.pixels, 2000);
  EXPECT_LT(e.rms, 0.01);
  EXPECT_LT(std::abs(e.mean), 1e-3);
}

}  // namespace
}  // namespace vol::curvilinear
