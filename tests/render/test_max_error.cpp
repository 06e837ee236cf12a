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
