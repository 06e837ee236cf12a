#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "fields.h"

namespace vol::render {
namespace {

volume::Volume uniform_volume(const Dims& dims, double value, const Vec3& spacing = {1, 1, 1}) {
  volume::Volume volume;
  volume::Grid<double> grid;
  grid.geometry.dims = dims;
  grid.geometry.spacing = spacing;
  grid.voxels.assign(static_cast<std::size_t>(grid.geometry.count()), value);
  volume.grid = std::move(grid);
  return volume;
}

TEST(Extremes, EmptyAndOpaque) {
  const volume::Volume volume = uniform_volume({5, 4, 3}, 0.5);
  const auto bounds = volume::field_bounds(volume.geometry());
  for (const auto rule : {Quadrature::rectangle, Quadrature::trapezoid, Quadrature::preintegrated}) {
    RenderOptions options;
    options.quadrature = rule;
    const Scene empty = scene_of(constant_transfer(0)), solid = scene_of(constant_transfer(1));
    const Pixel none = cast(plain_caster(volume, empty, options), bounds, empty);
    EXPECT_EQ(none.alpha, 0);
    EXPECT_TRUE(std::isinf(none.depth));
    const Pixel all = cast(plain_caster(volume, solid, options), bounds, solid);
    EXPECT_EQ(all.alpha, 1);
    EXPECT_EQ(all.colour, Vec3(0.2, 0.5, 0.9));
    EXPECT_FALSE(std::isinf(all.depth));
    EXPECT_EQ(difference(cast(reference_caster(volume, empty, {}), bounds, empty), none), 0);
    const Pixel truth = cast(reference_caster(volume, solid, {}), bounds, solid);
    EXPECT_EQ(difference(truth, all), 0);
    EXPECT_EQ(truth.depth, all.depth);
  }
}

TEST(Extremes, FlatAndThinVolumes) {
  // An axis of one sample is one spacing thick; spacing ratios of 10^4.
  for (const auto& [dims, spacing] : {std::pair<Dims, Vec3>{{1, 1, 6}, {1, 1, 1}},
                                      {{1, 7, 1}, {1e-4, 1, 1}},
                                      {{4, 3, 5}, {1e-2, 1, 100}}}) {
    const volume::Volume volume = uniform_volume(dims, 0.5, spacing);
    const auto bounds = volume::field_bounds(volume.geometry());
    const Scene scene = scene_of(constant_transfer(0.4), 10, 5);
    const double length = chord_length(bounds, scene, 50, 50);
    ASSERT_GT(length, 0);
    const double alpha = -std::expm1(std::log1p(-0.4) * length / scene.reference_length);
    RenderOptions options;
    options.step = length / 7.3;
    EXPECT_NEAR(cast(plain_caster(volume, scene, options), bounds, scene, 50, 50).alpha, alpha, 1e-12);
    EXPECT_NEAR(cast(reference_caster(volume, scene, options), bounds, scene, 50, 50).alpha, alpha, 1e-10);
    options.step = 1e3 * length;  // longer than the volume: one segment
    EXPECT_NEAR(cast(plain_caster(volume, scene, options), bounds, scene, 50, 50).alpha, alpha, 1e-12);
  }
}

TEST(Extremes, HugeTinyAndOffsetValues) {
  // The picture depends on values only through the transfer function: scale both, or shift both.
  const volume::Volume volume = generic_volume();
  const auto bounds = volume::field_bounds(volume.geometry());
  const transfer::TransferFunction base{{{0.1, Vec3(0, 0, 0)}, {0.9, Vec3(1, 0.5, 0.2)}},
                                        {{0.2, 0}, {0.8, 0.4}}};
  const Scene scene = scene_of(base);
  const Pixel plain = cast(plain_caster(volume, scene, {}), bounds, scene);
  const Pixel truth = cast(reference_caster(volume, scene, {}), bounds, scene);
  // 1e30 is no power of two, so that scaled values are rounded, by 1e-16 of them. Values near 1e6 are rounded
  // by 6e-11, which the slope of opacity (2/3) carries into each of below 100 nodes.
  for (const auto& [scale, shift, tolerance] :
       {std::tuple{1e30, 0.0, 1e-12}, {1e-30, 0.0, 1e-12}, {1.0, 1e6, 1e-8}}) {
    volume::Volume other = volume;
    for (auto& v : std::get<volume::Grid<double>>(other.grid).voxels) v = v * scale + shift;
    auto colours = base.colours();
    auto opacities = base.opacities();
    for (auto& p : colours) p.value = p.value * scale + shift;
    for (auto& p : opacities) p.value = p.value * scale + shift;
    const Scene same = scene_of({colours, opacities});
    EXPECT_LT(difference(cast(plain_caster(other, same, {}), bounds, same), plain), tolerance);
    EXPECT_LT(difference(cast(reference_caster(other, same, {}), bounds, same), truth), tolerance + 2e-10);
  }
}

TEST(Extremes, DenseMediumIsNotOverlooked) {
  // All of it happens within 1e-9 of the entry, far inside one cell.
  const volume::Volume volume = uniform_volume({3, 3, 3}, 0.5);
  const auto bounds = volume::field_bounds(volume.geometry());
  Scene scene = scene_of(constant_transfer(0.9));
  scene.reference_length = 1e-9;
  const Pixel p = cast(reference_caster(volume, scene, {}), bounds, scene);
  EXPECT_NEAR(p.alpha, 1, 1e-10);
  EXPECT_NEAR((p.colour - Vec3(0.2, 0.5, 0.9)).norm(), 0, 1e-9);
}

TEST(Extremes, ShortSteps) {
  const volume::Volume volume = uniform_volume({2, 2, 2}, 0.5);
  const auto bounds = volume::field_bounds(volume.geometry());
  const Scene scene = scene_of(constant_transfer(0.4), 0, 0);
  RenderOptions options;
  options.step = 1e-5;
  // 1e5 factors of 1 - 7e-6, each rounded.
  EXPECT_NEAR(cast(plain_caster(volume, scene, options), bounds, scene, 50.5, 50.5).alpha,
              1 - std::pow(0.6, 1 / scene.reference_length), 1e-11);
  options.step = 1e-12;
  EXPECT_THROW((void)cast(plain_caster(volume, scene, options), bounds, scene), Error);
}

TEST(Extremes, RefusedInOneLine) {
  const volume::Volume volume = uniform_volume({3, 3, 3}, 0.5);
  const Scene scene = scene_of(constant_transfer(0.4));
  RenderOptions options;
  options.width = options.height = 4;
  const auto with = [&](auto change) {
    RenderOptions o = options;
    change(o);
    return o;
  };
  EXPECT_THROW((void)raycast_plain(volume, scene, with([](auto& o) { o.step = 0; })), Error);
  EXPECT_THROW((void)raycast_plain(volume, scene, with([](auto& o) { o.step = NAN; })), Error);
  EXPECT_THROW((void)raycast_plain(volume, scene, with([](auto& o) { o.width = 0; })), Error);
  EXPECT_THROW((void)raycast_plain(volume, scene, with([](auto& o) { o.termination = 1; })), Error);
  EXPECT_THROW(
      (void)raycast_plain(volume, scene, with([](auto& o) { o.quadrature = Quadrature::reference; })), Error);
  EXPECT_THROW((void)raycast_reference(volume, scene, with([](auto& o) { o.tolerance = 0; })), Error);
  const index::IndexVolume other({3, 3, 4}, 1, 0.5);
  EXPECT_THROW((void)raycast_plain(volume, scene, options, &other), Error);
  volume::Volume bad = volume;
  std::get<volume::Grid<double>>(bad.grid).voxels[5] = NAN;
  EXPECT_THROW((void)raycast_plain(bad, scene, options), Error);
  EXPECT_THROW((void)raycast_reference(bad, scene, options), Error);
  // A field without a grid has no spacing to take the reference length from.
  const FunctionField field{[](const Vec3&) { return 1.0; }, {}, generic_box()};
  Scene lengthless = scene;
  lengthless.reference_length = 0;
  EXPECT_THROW((void)raycast_plain(field, lengthless, options), Error);
  // The integral of 1e38 over a length of several does not fit float.
  Scene xray = scene;
  xray.model = Model::xray;
  EXPECT_THROW((void)raycast_plain(uniform_volume({30, 30, 30}, 3e38), xray, options), Error);
}

}  // namespace
}  // namespace vol::render
