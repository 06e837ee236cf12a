#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "curvilinear/halves.h"
#include "curvilinear/phantom.h"
#include "curvilinear/sheet_mesh.h"
#include "curvilinear/sheet_parts.h"
#include "curvilinear/sheets.h"
#include "random_block.h"

namespace vol::curvilinear {
namespace {

using Values = std::vector<std::vector<double>>;

transfer::TransferFunction constant(double opacity) {
  return {{{0, Vec3(0.25, 0.5, 1)}}, {{0, opacity}}};
}

Grid box(const Dims& cells, const Vec3& size) {
  Grid grid;
  Block& block = grid.blocks.emplace_back();
  block.dims = {cells[0] + 1, cells[1] + 1, cells[2] + 1};
  for (std::int64_t k = 0; k <= cells[2]; ++k) {
    for (std::int64_t j = 0; j <= cells[1]; ++j) {
      for (std::int64_t i = 0; i <= cells[0]; ++i) {
        block.points.emplace_back(size[0] * static_cast<double>(i) / static_cast<double>(cells[0]),
                                  size[1] * static_cast<double>(j) / static_cast<double>(cells[1]),
                                  size[2] * static_cast<double>(k) / static_cast<double>(cells[2]));
      }
    }
  }
  return grid;
}

Values zeros(const Grid& grid) {
  Values values;
  for (const auto& block : grid.blocks) values.emplace_back(block.points.size(), 0.0);
  return values;
}

camera::Camera camera_for(const Grid& grid, double azimuth, double elevation, int width, int height,
                          camera::Projection projection = camera::Projection::orthographic) {
  camera::View view;
  view.azimuth = azimuth;
  view.elevation = elevation;
  view.projection = projection;
  const Box3 b = grid.bounds();
  return {view, b.centre(), b.size().maxCoeff(), width, height};
}

TEST(OpacityOfDepth, IsOneMinusExp) {
  for (float x = 1e-8F; x < 100; x *= 1.37F) {
    const double right = -std::expm1(-static_cast<double>(x));
    EXPECT_NEAR(opacity_of_depth(x) / right, 1, 3e-7) << x;  // some roundings of float
  }
  EXPECT_EQ(opacity_of_depth(0), 0);
  EXPECT_EQ(opacity_of_depth(std::numeric_limits<float>::infinity()), 1);
}

TEST(TransferTable, HoldsEndsExactlyAndStepsWithinHalfAStep) {
  const transfer::TransferFunction f({{-1, {0, 0, 0}}, {3, {1, 0.5, 0}}}, {{-1, 0}, {3, 1}});
  const TransferTable table(f, 1);
  const auto entry = [](const TransferTable& of, double value) {
    return of(static_cast<float>(of.share(value)));
  };
  EXPECT_EQ(entry(table, -1).depth, 0);
  EXPECT_EQ(entry(table, -7).depth, 0);
  EXPECT_EQ(entry(table, 3).depth, std::numeric_limits<float>::infinity());
  EXPECT_EQ(entry(table, 9).r, 1);
  // 2^14 steps: half a step of a value that runs from 0 to 1 is 2^-15.
  for (float v = -0.999F; v < 3; v += 0.0137F) EXPECT_NEAR(entry(table, v).r, (v + 1) / 4, 3.1e-5);
  EXPECT_NEAR(entry(TransferTable(f, 4), 1).depth, -std::log1p(-0.5) / 4, 1e-4);
}

// (5) to (8) of the paper: whatever the number of sheets, a cell has its own opacity.
TEST(Layers, ACellOfNSheetsHasItsOpacity) {
  const Grid grid = box({1, 1, 1}, Vec3(1, 1, 1));
  for (const double opacity : {0.2, 0.9, 1.0}) {
    for (const double throttle : {0.3, 1.0}) {
      SheetOptions options;
      options.throttle = throttle;
      const auto picture =
          draw_sheets(grid, zeros(grid), camera_for(grid, 0, 0, 48, 48), constant(opacity), 1, options);
      EXPECT_EQ(picture.counts.holes, 0);
      // 48 pixels are 1.6 edges: the cell is 30 wide, from column 9 on.
      for (const int x : {9, 20, 38}) {
        EXPECT_NEAR(picture.image.at(x, 24, 3), opacity, 1e-5) << throttle;
        EXPECT_NEAR(picture.image.at(x, 24, 1), 0.5 * opacity, 1e-5);
      }
      EXPECT_EQ(picture.image.at(8, 24, 3), 0);
      EXPECT_EQ(picture.image.at(39, 24, 3), 0);
    }
  }
}

TEST(Layers, AThrottleAboveOneLeavesHoles) {
  const Grid grid = box({1, 1, 1}, Vec3(1, 1, 1));
  SheetOptions options;
  options.throttle = 2.5;
  const auto coarse =
      draw_sheets(grid, zeros(grid), camera_for(grid, 0, 0, 48, 48), constant(0.5), 1, options);
  EXPECT_GT(coarse.counts.holes, 0);
  EXPECT_EQ(coarse.counts.redundant, 0);
  options.throttle = 0.5;
  EXPECT_GT(draw_sheets(grid, zeros(grid), camera_for(grid, 0, 0, 48, 48), constant(0.5), 1, options)
                .counts.redundant,
            0);
}

TEST(GlobalLayers, IsGammaLogMAndNeverBelowGamma) {
  EXPECT_DOUBLE_EQ(global_layers(box({30, 20, 20}, Vec3(1, 1, 1)), 1), std::log(20.0));
  EXPECT_DOUBLE_EQ(global_layers(box({30, 20, 20}, Vec3(1, 1, 1)), 0.5), 0.5 * std::log(20.0));
  EXPECT_EQ(global_layers(box({3, 1, 1}, Vec3(1, 1, 1)), 0.5), 0.5);
}

/// World length of a ray inside a phantom's parallelepiped: slabs of its own axes.
double chord(const Grid& grid, const camera::Ray& ray) {
  const Block& b = grid.blocks[0];
  const Vec3 corner = b.points[0];
  Mat3 edges;
  edges << b.points[b.offset(b.dims[0] - 1, 0, 0)] - corner, b.points[b.offset(0, b.dims[1] - 1, 0)] - corner,
      b.points[b.offset(0, 0, b.dims[2] - 1)] - corner;
  const Mat3 inverse = edges.inverse();
  const Vec3 from = inverse * (ray.origin - corner), along = inverse * ray.direction;
  double enter = -1e9, leave = 1e9;
  for (int a = 0; a < 3; ++a) {
    const double t0 = -from[a] / along[a], t1 = (1 - from[a]) / along[a];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return std::max(0.0, leave - enter);
}

struct Figures {
  double rms = 0, largest = 0, mean = 0;
};
/// Relative error of optical depth over the pixels whose chord exceeds a tenth of the longest; `mean` of
/// depth over all pixels, relative too.
Figures against_chords(const Grid& grid, const camera::Camera& camera, const image::Image& image,
                       double length) {
  std::vector<std::array<double, 2>> pairs;
  double longest = 0, sum = 0, right = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double l = chord(grid, camera.ray(x + 0.5, y + 0.5));
      const double depth = -std::log1p(-static_cast<double>(image.at(x, y, 3))) * length;
      longest = std::max(longest, l);
      sum += depth;
      right += l;
      pairs.push_back({l, depth});
    }
  }
  Figures f;
  int n = 0;
  for (const auto& [l, depth] : pairs) {
    if (l < 0.1 * longest) continue;
    const double e = depth / l - 1;
    f.rms += e * e;
    f.largest = std::max(f.largest, std::abs(e));
    ++n;
  }
  f.rms = std::sqrt(f.rms / n);
  f.mean = sum / right - 1;
  return f;
}

// An affine map is its own tessellation, so that sheets have the chord's length whatever the throttle, at
// silhouettes too: up to the float of depths within cells, 6e-8 of some tens of pixels against chords of 5
// and more, and of opacities. In perspective, depth is linear over pieces of a fiftieth of the eye's
// distance, where it misses by 1 / 8 of the square of that, 5e-5, of a distance that is some 50 times the
// shortest chord.
TEST(Physical, OpacityIsThatOfTheChordOfASkewBox) {
  const Grid grid = make_phantom("sheared-box", {4, 3, 5}, "ramp", 1);
  constexpr double kOpacity = 0.3;
  const double length = 1 / -std::log1p(-kOpacity);
  for (const auto projection : {camera::Projection::orthographic, camera::Projection::perspective}) {
    const auto camera = camera_for(grid, 33, 21, 200, 160, projection);
    const bool perspective = projection == camera::Projection::perspective;
    SCOPED_TRACE(perspective ? "perspective" : "orthographic");
    for (const double throttle : {0.5, 1.0, 8.0, 100.0}) {
      SheetOptions options;
      options.thickness = Thickness::physical;
      options.throttle = throttle;
      const auto picture = draw_sheets(grid, zeros(grid), camera, constant(kOpacity), 1, options);
      const Figures f = against_chords(grid, camera, picture.image, length);
      EXPECT_LT(f.rms, perspective ? 2.5e-3 : 1e-5) << throttle;
      EXPECT_LT(f.largest, perspective ? 2e-2 : 1e-4) << throttle;
    }
  }
}

// A solid too large for one go comes in several, whose first surface is the last of the one before.
TEST(SheetMaker, InSeveralGoesTheSamePicture) {
  const Grid grid = make_phantom("half-torus", {4, 2, 2}, "ramp", 1);
  const Screen screen(camera_for(grid, 20, 40, 90, 80));
  const Block seen = screen.view(grid.blocks[0]);
  const Solid solid =
      oriented(Solids(seen, grid.blocks[0].arrays[0].values, CellKind::tricubic, 1)({1, 0, 0}), screen).solid;
  const TransferTable table(constant(0.5), 1);
  const auto drawn = [&](std::size_t budget, std::size_t& goes) {
    SheetMaker maker(solid, screen, {1, 0.01, 0.1});
    Band band(90, 0, 80);
    goes = 0;
    for (; !maker.done(); ++goes) {
      SheetMeshes meshes;
      maker.make(budget, meshes);
      const SheetMeshes* one[] = {&meshes};
      scan_sheets(one, table, band);
    }
    return band;
  };
  std::size_t once = 0, often = 0;
  const Band whole = drawn(1 << 20, once), pieces = drawn(1, often);
  EXPECT_EQ(once, 1U);
  EXPECT_GT(often, 10U);
  EXPECT_GT(whole.counts.samples, 1000);
  EXPECT_EQ(whole.counts.samples, pieces.counts.samples);
  for (std::size_t n = 0; n < whole.pixels.size(); ++n) {
    EXPECT_EQ(whole.pixels[n].transmittance, pieces.pixels[n].transmittance);
  }
}

TEST(LargestDifferences, AreThoseOfTheControlPoints) {
  const Block block = random_block({4, 4, 4}, 21);
  const Solid solid = Solids(block, block.arrays[0].values, CellKind::tricubic, 1)({1, 1, 1});
  const LargestDifferences found(solid, solid.b[0]);
  const auto b = [&](std::array<std::size_t, 3> at) { return solid.b[at[0] + 4 * (at[1] + 4 * at[2])]; };
  Point4 first[3], second[3], mixed = Point4::Zero();
  for (int a = 0; a < 3; ++a) first[a] = second[a] = Point4::Zero();
  for (std::size_t n = 0; n < 64; ++n) {
    const std::array<std::size_t, 3> at{n % 4, n / 4 % 4, n / 16};
    for (std::size_t a = 0; a < 3; ++a) {
      auto one = at, two = at;
      one[a] += 1;
      two[a] += 2;
      if (one[a] < 4) first[a] = first[a].cwiseMax((b(one) - b(at)).cwiseAbs());
      if (two[a] < 4) second[a] = second[a].cwiseMax((b(two) - 2 * b(one) + b(at)).cwiseAbs());
    }
    if (at[0] < 3 && at[1] < 3) {
      const Point4 d = b({at[0] + 1, at[1] + 1, at[2]}) - b({at[0] + 1, at[1], at[2]}) -
                       b({at[0], at[1] + 1, at[2]}) + b(at);
      mixed = mixed.cwiseMax(d.cwiseAbs());
    }
  }
  constexpr double kFloat = 2e-6;  // some roundings of local coordinates below 4
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_LT((found.first[a].cast<double>().matrix() - first[a]).cwiseAbs().maxCoeff(), kFloat);
    EXPECT_LT((found.second[a].cast<double>().matrix() - second[a]).cwiseAbs().maxCoeff(), kFloat);
  }
  EXPECT_LT((found.mixed.cast<double>().matrix() - mixed).cwiseAbs().maxCoeff(), kFloat);
}

TEST(Halves, AreTheSolidAndShareTheirFace) {
  const Block block = random_block({4, 4, 4}, 5);
  const Solid solid = Solids(block, block.arrays[0].values, CellKind::tricubic, 1)({1, 1, 1});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto parts = halves(solid, axis);
    for (const double u : {0.0, 0.3, 1.0}) {
      for (std::size_t half = 0; half < 2; ++half) {
        Vec3 at(0.2, 0.7, 0.4), whole = at;
        at[static_cast<int>(axis)] = u;
        whole[static_cast<int>(axis)] = 0.5 * (static_cast<double>(half) + u);
        EXPECT_LT((parts[half](at) - solid(whole)).norm(), 1e-13);  // coordinates below 20
      }
    }
    const std::size_t stride = axis == 0 ? 1 : axis == 1 ? 4 : 16;
    for (std::size_t n = 0; n < 64; ++n) {
      if (n / stride % 4 != 0) continue;
      EXPECT_EQ(parts[0].b[n + 3 * stride], parts[1].b[n]);
    }
  }
}

TEST(Halves, PartsAreTheSolidBetweenCorners) {
  const Block block = random_block({4, 4, 4}, 6);
  const Solid solid = Solids(block, block.arrays[0].values, CellKind::tricubic, 1)({1, 1, 1});
  const Vec3 low(0.25, 0, 0.5), high(0.5, 1, 0.625);
  const Solid of = part(solid, low, high);
  for (const Vec3& u : {Vec3(0, 0, 0), Vec3(0.3, 0.9, 0.2), Vec3(1, 1, 1)}) {
    EXPECT_LT((of(u) - solid(low + u.cwiseProduct(high - low))).norm(), 1e-13);  // coordinates below 20
  }
  const Solid beside = part(solid, Vec3(0.5, 0, 0.5), Vec3(1, 1, 0.625));
  for (std::size_t n = 0; n < 64; n += 4) EXPECT_EQ(of.b[n + 3], beside.b[n]);
}

TEST(Sheets, WhatIsInFrontHidesWhatIsBehind) {
  const Grid grid = box({1, 1, 4}, Vec3(1, 1, 1));
  Values values = zeros(grid);
  for (std::size_t n = 0; n < values[0].size(); ++n) values[0][n] = grid.blocks[0].points[n].z();
  const transfer::TransferFunction f({{0, {0, 0, 1}}, {0.5, {0, 0, 1}}, {0.5, {1, 0, 0}}, {1, {1, 0, 0}}},
                                     {{0, 1}});
  for (const auto thickness : {Thickness::layers, Thickness::physical}) {
    SheetOptions options;
    options.thickness = thickness;
    const auto from_above = draw_sheets(grid, values, camera_for(grid, 0, 0, 32, 32), f, 1, options).image;
    EXPECT_EQ(from_above.at(16, 16, 0), 1);
    EXPECT_EQ(from_above.at(16, 16, 2), 0);
    const auto from_below = draw_sheets(grid, values, camera_for(grid, 180, 0, 32, 32), f, 1, options).image;
    EXPECT_EQ(from_below.at(16, 16, 0), 0);
    EXPECT_EQ(from_below.at(16, 16, 2), 1);
  }
}

// Opacity rises to 1 at a face, which the ray meets head on: no more than the integral of -log(1 - a), which
// is 1 times the length.
TEST(Physical, AFaceThatIsJustOpaqueHidesNothing) {
  const Grid grid = box({3, 1, 1}, Vec3(1, 1, 1));
  Values values = zeros(grid);
  for (std::size_t n = 0; n < values[0].size(); ++n) values[0][n] = grid.blocks[0].points[n].x();
  const transfer::TransferFunction ramp({{0, Vec3::Ones()}}, {{0, 0}, {1, 1}});
  SheetOptions options;
  options.thickness = Thickness::physical;
  for (const auto cells : {CellKind::tricubic, CellKind::trilinear}) {
    options.cells = cells;
    for (const double azimuth : {90.0, 270.0}) {
      const auto picture = draw_sheets(grid, values, camera_for(grid, azimuth, 0, 64, 64), ramp, 1, options);
      // Simpson's rule in the one sheet of 40 that ends in the logarithm's pole; opaque would be 1.
      EXPECT_NEAR(picture.image.at(32, 32, 3), 1 - std::exp(-1.0), 0.02) << azimuth;
    }
  }
}

// Values as of a transfer function: a signal of 1 on 1e8 is the same picture as one on 0, which double holds
// to 1e-8.
TEST(Sheets, ASmallSignalOnALargeOffset) {
  const Grid grid = make_phantom("twisted-box", {4, 5, 6}, "marschner-lobb", 1);
  const auto camera = camera_for(grid, 40, 10, 60, 50);
  for (const auto thickness : {Thickness::layers, Thickness::physical}) {
    SheetOptions options;
    options.thickness = thickness;
    const auto picture = [&](double offset) {
      Values values{grid.blocks[0].arrays[0].values};
      for (double& f : values[0]) f += offset;
      const transfer::TransferFunction f({{offset, {0, 0, 1}}, {offset + 1, {1, 0, 0}}},
                                         {{offset, 0}, {offset + 1, 0.7}});
      return draw_sheets(grid, values, camera, f, 0.5, options).image;
    };
    const image::Image plain = picture(0), lifted = picture(1e8);
    // A table has 2^14 steps; a value at the edge of one may fall into the next: 6e-5 of a sample's colour.
    for (std::size_t n = 0; n < plain.pixels.size(); ++n) {
      if (n % 5 < 4) {
        EXPECT_NEAR(plain.pixels[n], lifted.pixels[n], 1e-4);
      }
    }
  }
}

// The picture is a thousandth of the grid: parts outside it are left out, and what is in it has the chord's
// length.
TEST(Sheets, OfCellsFarLargerThanThePicture) {
  const Grid grid = make_phantom("sheared-box", {3, 3, 3}, "ramp", 1);
  camera::View view;
  view.azimuth = 33;
  view.elevation = 21;
  view.width = 2e-3;
  constexpr double kOpacity = 0.3;
  const camera::Camera camera(view, grid.bounds().centre(), 2, 40, 30);
  SheetOptions options;
  options.thickness = Thickness::physical;
  const auto picture = draw_sheets(grid, zeros(grid), camera, constant(kOpacity), 1, options);
  EXPECT_LT(picture.counts.points, 100000);
  const Figures f = against_chords(grid, camera, picture.image, 1 / -std::log1p(-kOpacity));
  EXPECT_LT(f.largest, 1e-4);  // float, of hundreds of parts
  options.thickness = Thickness::layers;
  EXPECT_THROW((void)draw_sheets(grid, zeros(grid), camera, constant(kOpacity), 1, options), Error);
  options.thickness = Thickness::physical;
  view.width = 1e-7;
  const camera::Camera nearer(view, grid.bounds().centre(), 2, 40, 30);
  EXPECT_THROW((void)draw_sheets(grid, zeros(grid), nearer, constant(kOpacity), 1, options), Error);
}

TEST(Sheets, ThreadsDoNotShow) {
  const Grid grid = make_phantom("twisted-box", {4, 5, 6}, "marschner-lobb", 1);
  const transfer::TransferFunction f({{0, {0, 0, 1}}, {1, {1, 0, 0}}}, {{0, 0}, {1, 0.7}});
  for (const auto thickness : {Thickness::layers, Thickness::physical}) {
    SheetOptions options;
    options.thickness = thickness;
    const auto camera = camera_for(grid, 40, 10, 90, 70);
    set_thread_count(1);
    const auto one = draw_sheets(grid, {grid.blocks[0].arrays[0].values}, camera, f, 0.5, options);
    set_thread_count(0);
    const auto many = draw_sheets(grid, {grid.blocks[0].arrays[0].values}, camera, f, 0.5, options);
    EXPECT_TRUE(std::equal(one.image.pixels.begin(), one.image.pixels.end(), many.image.pixels.begin()));
    EXPECT_EQ(one.counts.points, many.counts.points);
  }
}

TEST(Sheets, HiddenCellsAreLeftOutAndAnEyeInsideIsRefused) {
  Grid grid = box({2, 1, 1}, Vec3(2, 1, 1));
  grid.blocks[0].hidden.assign(12, 0);
  grid.blocks[0].hidden[0] = 1;
  const auto picture = draw_sheets(grid, zeros(grid), camera_for(grid, 0, 0, 32, 32), constant(0.5), 1, {});
  EXPECT_EQ(picture.counts.cells, 1);
  EXPECT_EQ(picture.image.at(10, 16, 3), 0);
  EXPECT_GT(picture.image.at(22, 16, 3), 0.4F);
  camera::View inside;
  inside.projection = camera::Projection::perspective;
  inside.distance = 0.1;
  const camera::Camera camera(inside, grid.bounds().centre(), 2, 32, 32);
  EXPECT_THROW((void)draw_sheets(grid, zeros(grid), camera, constant(0.5), 1, {}), Error);
}

// What is refused is what steps are made of: here the way along the ray, while the cell's box in the picture
// is a pixel.
TEST(Sheets, LayersAreRefusedWhereTheirStepsWouldNotDo) {
  const Grid grid = box({1, 1, 1}, Vec3(1, 1, 50));
  const Values values{std::vector<double>(8, 0)};
  const camera::Camera camera({}, grid.bounds().centre(), grid.bounds().size().maxCoeff(), 64, 64);
  const transfer::TransferFunction medium({{0, Vec3::Ones()}}, {{0, 0.5}});
  SheetOptions options;
  options.throttle = 0.005;
  EXPECT_THROW((void)draw_sheets(grid, values, camera, medium, 1, options), Error);
  options.throttle = 0.1;
  EXPECT_NO_THROW((void)draw_sheets(grid, values, camera, medium, 1, options));
  EXPECT_THROW((void)draw_sheets(grid, {}, camera, medium, 1, options), Error);
}

// A jump is the transfer function's only break: values near it may be on its other side.
TEST(TransferTable, OffValuesOfASingleBreak) {
  const transfer::TransferFunction jump({{0.5, Vec3::Ones()}}, {{0.5, 0}, {0.5, 0.9}});
  ASSERT_EQ(jump.breakpoints().size(), 1U);
  const TransferTable plain(jump, 1), least(jump, 1, -0.1), most(jump, 1, 0.1);
  EXPECT_EQ(plain(-0.01F).depth, 0);
  EXPECT_GT(most(-0.01F).depth, 2);
  EXPECT_GT(plain(0.01F).depth, 2);
  EXPECT_EQ(least(0.01F).depth, 0);
}

// The reciprocal of the shortest stretches is no number; shares are.
TEST(TransferTable, SharesOfTheShortestStretch) {
  const double high = 64 * std::numeric_limits<double>::denorm_min();
  const TransferTable table(transfer::TransferFunction({{0, Vec3::Ones()}}, {{0, 0}, {high, 1}}), 1);
  EXPECT_EQ(table.share(0), 0);
  EXPECT_DOUBLE_EQ(table.share(high / 4), 0.25);
  EXPECT_DOUBLE_EQ(table.share(high), 1);
  EXPECT_EQ(table.share(1), 1e30);
}

}  // namespace
}  // namespace vol::curvilinear
