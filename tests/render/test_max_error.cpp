#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "packet_oracle.h"
#include "render/max_error.h"

namespace vol::render {
namespace {

struct Errors {
  double largest = 0;        ///< of a channel of a pixel, against the truth
  double over_estimate = 0;  ///< by how much a pixel's error exceeds its own estimate
};

Errors errors_of(const RenderResult& picture, const RenderResult& truth, double truth_tolerance) {
  Errors e;
  for (int y = 0; y < truth.image.height; ++y) {
    for (int x = 0; x < truth.image.width; ++x) {
      double error = 0;
      for (int c = 0; c < 4; ++c) {
        error =
            std::max(error, std::abs(double(picture.image.at(x, y, c)) - double(truth.image.at(x, y, c))));
      }
      e.largest = std::max(e.largest, error);
      e.over_estimate =
          std::max(e.over_estimate, error - truth_tolerance - double(picture.image.at(x, y, 6)));
    }
  }
  return e;
}

RenderOptions small_picture() {
  RenderOptions options = packet_options();
  options.width = 31;
  options.height = 26;
  return options;
}

Errors errors_within(const volume::Volume& v, const Scene& scene, double bound) {
  RenderOptions options = small_picture();
  options.max_error = bound;
  const RenderResult picture = raycast_within_error(PacketVolume(v), scene, options);
  EXPECT_LE(picture.error_estimate, bound);
  options.max_error = 0;
  options.tolerance = 1e-3 * bound;
  const RenderResult truth = raycast_reference(v, scene, options);
  return errors_of(picture, truth, 2e-3 * bound);
}

/// A transfer function of some random points: ramps, jumps, plateaus, some of them up to opacity 1.
transfer::TransferFunction random_transfer(Rng& rng, double full, double most_opaque) {
  std::vector<transfer::ColourPoint> colours;
  std::vector<transfer::OpacityPoint> opacities;
  double value = 0.05 * full;
  opacities.push_back({value, 0});
  while (value < full) {
    value += (0.03 + 0.25 * rng.uniform()) * full;
    const double kind = rng.uniform();
    const double opacity = kind < 0.3 ? 0 : kind < 0.5 ? most_opaque : most_opaque * rng.uniform();
    opacities.push_back({value, opacity});
    if (rng.uniform() < 0.3) opacities.push_back({value, most_opaque * rng.uniform()});  // a jump
    colours.push_back({value, {rng.uniform(), rng.uniform(), rng.uniform()}});
  }
  return {colours, opacities};
}

/// The bound itself: no picture is over it, of 50 views of random scenes a set, nor any pixel over its
/// estimate.
TEST(MaxError, IsKeptByRandomScenesAndViews) {
  Rng rng(20);
  const volume::Volume volumes[] = {packet_volume<std::uint8_t>(255), packet_volume<float>(1),
                                    packet_volume<std::int16_t>(30000, {12, 33, 17})};
  const double fulls[] = {255, 1, 30000};
  for (int view = 0; view < 50; ++view) {
    SCOPED_TRACE(view);
    const int set = view % 3;
    Scene scene;
    scene.view.azimuth = 360 * rng.uniform();
    scene.view.elevation = 180 * rng.uniform() - 90;
    if (view % 4 == 1) scene.view.projection = camera::Projection::perspective;
    scene.transfer = random_transfer(rng, fulls[set], view % 5 == 0 ? 1.0 : 0.9);
    scene.reference_length = 0.2 + rng.uniform();
    if (view % 2 == 1) {
      scene.shading = Shading{.ambient = 0.2, .diffuse = 0.7, .specular = 0.3, .exponent = 20, .light = {}};
      if (view % 4 == 3) scene.shading->light = Vec3(1, 2, -1);
    }
    const double bound = std::pow(10.0, -1 - view / 2 % 4);
    const Errors e = errors_within(volumes[set], scene, bound);
    EXPECT_LE(e.largest, bound) << "of " << bound;
    EXPECT_LE(e.over_estimate, 0) << "of " << bound;
  }
}

/// Opaque sets behind ramps, behind jumps, and a peak that touches opacity 1, which is not an opaque set.
TEST(MaxError, HoldsOpacityOne) {
  const volume::Volume v = packet_volume<std::uint8_t>(255);
  const std::vector<transfer::ColourPoint> colours{{0, {0.1, 0.2, 0.9}}, {255, {1, 0.8, 0.3}}};
  for (const auto& opacities :
       {std::vector<transfer::OpacityPoint>{{30, 0}, {120, 1}},
        std::vector<transfer::OpacityPoint>{{60, 0}, {60, 1}},
        std::vector<transfer::OpacityPoint>{{20, 0}, {90, 1}, {160, 0}},
        std::vector<transfer::OpacityPoint>{{20, 0}, {90, 1}, {95, 1}, {160, 0.01}}}) {
    Scene scene = packet_scene(255);
    scene.transfer = {colours, opacities};
    for (const double bound : {1e-2, 2e-4}) {
      EXPECT_LE(errors_within(v, scene, bound).largest, bound);
    }
    // The same cuts without estimates: order 6 but for the logarithm's last piece, 2^-20 of the ramp.
    RenderOptions options = small_picture();
    options.quadrature = Quadrature::split;
    options.tolerance = 1e-9;
    const Difference d =
        difference(raycast_packet(v, scene, options).image, raycast_reference(v, scene, options).image);
    EXPECT_LE(d.colour, 1e-4);
  }
}

/// f = x z on one cell, seen along a diagonal on which it falls to 0 and rises again within the cell.
template <class T>
volume::Volume saddle(double scale) {
  volume::GridGeometry g;
  g.dims = {2, 2, 2};
  volume::Grid<T> grid{g, Buffer<T>(8, T{0})};
  for (std::int64_t j = 0; j < 2; ++j) grid(1, j, 1) = static_cast<T>(scale);
  return {std::move(grid), {}};
}

Scene along_the_saddle(std::vector<transfer::ColourPoint> colours,
                       std::vector<transfer::OpacityPoint> opacities) {
  Scene scene;
  scene.view.azimuth = -135;
  scene.transfer = {std::move(colours), std::move(opacities)};
  return scene;
}

/// A cut just beside a turn of the cubic, in values of any size.
TEST(MaxError, FindsCutsBesideATurn) {
  for (const double scale : {1.0, 1e30, 1e-30}) {
    for (const double cut : {1e-6, 1e-4, 1e-2}) {
      const Scene scene =
          along_the_saddle({{0, {1, 0.5, 0.2}}}, {{0, 0}, {cut * scale, 0}, {cut * scale, 0.5}});
      EXPECT_LE(errors_within(saddle<float>(scale), scene, 1e-3).largest, 1e-3) << scale << " " << cut;
    }
  }
}

/// An opaque set entered from above, where the colour jumps: its own side of the jump is seen.
TEST(MaxError, EntersOpaqueSetsFromBothSides) {
  const std::vector<transfer::ColourPoint> colours{
      {0, {1, 0, 0}}, {0.5, {1, 0, 0}}, {0.5, {0, 0, 1}}, {1, {0, 0, 1}}};
  for (const bool below : {true, false}) {
    const double low = below ? 1 : 0, high = below ? 0 : 1;
    const Scene scene = along_the_saddle(colours, {{0, low}, {0.5, low}, {0.5, high}, {1, high}});
    EXPECT_LE(errors_within(saddle<float>(1), scene, 1e-2).largest, 1e-2) << below;
  }
}

/// Where the opacity touches 1 at one value alone, cells constant at that value are opaque whatever their
/// length.
TEST(MaxError, PlateausAtAPeakAreOpaque) {
  volume::Volume v = packet_volume<std::uint8_t>(255);
  for (auto& voxel : std::get<volume::Grid<std::uint8_t>>(v.grid).voxels)
    voxel = std::min<std::uint8_t>(voxel, 120);
  Scene scene = packet_scene(255);
  scene.transfer = {{{0, {0.1, 0.2, 0.9}}, {255, {1, 0.8, 0.3}}}, {{60, 0}, {120, 1}, {255, 0}}};
  scene.reference_length = 30;
  EXPECT_LE(errors_within(v, scene, 1e-3).largest, 1e-3);
}

/// Dim light leaves alpha's errors as they are, and a bright background shows them.
TEST(MaxError, CountsAlphaAndTheBackground) {
  const volume::Volume v = packet_volume<float>(1);
  Scene scene = packet_scene(1, 0.4);
  scene.shading = Shading{.ambient = 0.1, .diffuse = 0.1, .specular = 0, .exponent = 1, .light = {}};
  scene.background = {10, 10, 10};
  RenderOptions options = small_picture();
  options.max_error = 0.1;
  const RenderResult picture = raycast_within_error(PacketVolume(v), scene, options);
  options.max_error = 0;
  options.tolerance = 1e-6;
  const RenderResult truth = raycast_reference(v, scene, options);
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      const auto shown = [&](const RenderResult& r) {
        return double(r.image.at(x, y, 0)) + (1 - double(r.image.at(x, y, 3))) * 10;
      };
      EXPECT_LE(std::abs(shown(picture) - shown(truth)), 0.1);
    }
  }
}

/// A medium so dense that light falls by half in a thousandth of a cell: no packet's loop may be caught in
/// it.
TEST(MaxError, EndsInAMediumOfAnyDensity) {
  const volume::Volume v = packet_volume<std::uint8_t>(255, {5, 6, 4});
  for (const double length : {1e-3, 1e-8}) {
    Scene scene = packet_scene(255, 0.9);
    scene.reference_length = length;
    EXPECT_LE(errors_within(v, scene, 1e-2).largest, 1e-2) << length;
  }
}

/// X-rays and maxima are the reference's; their bound is relative to the largest value.
TEST(MaxError, IsRelativeForSumsAndMaxima) {
  const volume::Volume v = packet_volume<std::uint8_t>(255);
  for (const Model model : {Model::xray, Model::mip}) {
    Scene scene = packet_scene(255);
    scene.model = model;
    RenderOptions options = small_picture();
    options.max_error = 1e-2;
    EXPECT_LE(raycast_within_error(PacketVolume(v, false), scene, options).error_estimate, 1e-2);
  }
}

/// Below float's own rounding the reference takes over; a bound that even it cannot keep is told by the
/// estimate.
TEST(MaxError, GoesBeyondSinglePrecision) {
  const volume::Volume v = packet_volume<float>(1);
  const Scene scene = packet_scene(1);
  EXPECT_LE(errors_within(v, scene, 1e-6).largest, 1e-6);
  RenderOptions options = small_picture();
  options.max_error = 1e-300;
  EXPECT_GT(raycast_within_error(PacketVolume(v), scene, options).error_estimate, 1e-300);
}

TEST(MaxError, PictureDoesNotDependOnThreads) {
  const volume::Volume v = packet_volume<std::uint8_t>(255);
  Scene scene = packet_scene(255);
  scene.shading = Shading{};
  RenderOptions options = small_picture();
  options.max_error = 1e-4;  // some rays of which go on to the reference
  set_thread_count(1);
  const RenderResult one = raycast_within_error(PacketVolume(v), scene, options);
  set_thread_count(3);
  const RenderResult two = raycast_within_error(PacketVolume(v), scene, options);
  set_thread_count(0);
  expect_same_bits(one.image, two.image, true);
}

TEST(MaxError, RefusesWhatIsNoBound) {
  const volume::Volume v = packet_volume<float>(1);
  const PacketVolume prepared(v);
  for (const double bound :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    RenderOptions options = small_picture();
    options.max_error = bound;
    EXPECT_THROW((void)raycast_within_error(prepared, packet_scene(1), options), Error);
  }
}

}  // namespace
}  // namespace vol::render
