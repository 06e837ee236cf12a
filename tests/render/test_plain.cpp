#include <gtest/gtest.h>

#include "base/error.h"
#include "base/parallel.h"
#include "fields.h"

namespace vol::render {
namespace {

const transfer::TransferFunction kBands{{{0, Vec3(0, 0, 0.5)}, {0.4, Vec3(1, 0.2, 0)}, {1, Vec3(0, 0.8, 1)}},
                                        {{0.55, 0}, {0.65, 0.5}, {0.7, 0}}};

RenderOptions small(Quadrature rule = Quadrature::trapezoid) {
  RenderOptions options;
  options.width = 24;
  options.height = 18;
  options.step = 0.2;
  options.quadrature = rule;
  return options;
}

const Quadrature kRules[] = {Quadrature::rectangle, Quadrature::trapezoid, Quadrature::preintegrated};

TEST(Plain, IndexOfZerosIsTheUniformPictureBitForBit) {
  const volume::Volume volume = generic_volume();
  const Scene scene = scene_of(ramp_transfer());
  for (const int reduction : {1, 4}) {
    const index::IndexVolume zeros(volume.geometry().dims, reduction, 0.2);
    for (const auto rule : kRules) {
      EXPECT_TRUE(same_bits(raycast_plain(volume, scene, small(rule)).image,
                            raycast_plain(volume, scene, small(rule), &zeros).image));
    }
  }
}

TEST(Plain, IndexSkipsNodesByItsCells) {
  // L = 1 everywhere is the uniform picture of twice the step, where the number of segments is even.
  const FunctionField field{[](const Vec3& p) { return 0.3 + 0.1 * p[2]; }, {}, box_of({0, 0, 0}, {4, 4, 4})};
  index::IndexVolume ones(Dims{5, 5, 5}, 1, 0.25);
  for (auto& byte : ones.nibbles()) byte = 0x11;
  Scene scene = scene_of(ramp_transfer(), 0, 0);
  RenderOptions options = small();
  options.step = 0.25;
  RenderCounts counts;
  const Pixel a =
      cast(plain_caster(view_of(field), scene, options, &ones), field.box, scene, 50, 50, &counts);
  EXPECT_EQ(counts.samples, 9);
  options.step = 0.5;
  EXPECT_EQ(difference(a, cast(plain_caster(view_of(field), scene, options), field.box, scene, 50, 50)), 0);
  // One cell of L = 15 in the middle: the ray jumps from it to the end.
  index::IndexVolume jump(Dims{5, 5, 5}, 1, 0.25);
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) jump.set_entry(i, j, 1, 15);  // z in [1, 2); the ray comes from z = 4
  }
  counts = {};
  (void)cast(plain_caster(
                 view_of(field), scene,
                 [&] {
                   auto o = options;
                   o.step = 0.25;
                   return o;
                 }(),
                 &jump),
             field.box, scene, 50.1, 50.1, &counts);
  EXPECT_EQ(counts.samples, 11);  // z = 4, 3.75 .. 2, 1.75, 0
}

TEST(Plain, SkippingChangesNothing) {
  volume::Volume volume = generic_volume(0.2, {17, 21, 13});
  auto& grid = std::get<volume::Grid<double>>(volume.grid);
  for (std::int64_t n = 0; n < grid.geometry.count(); ++n) {
    if (n % 17 < 9 && n / 17 % 21 > 5) grid.voxels[static_cast<std::size_t>(n)] = 0;  // an empty part
  }
  for (const auto kernel : {volume::Reconstruction::nearest, volume::Reconstruction::trilinear,
                            volume::Reconstruction::catmull_rom, volume::Reconstruction::b_spline}) {
    for (const auto rule : kRules) {
      for (const bool shaded : {false, true}) {
        Scene scene = scene_of(kBands);
        if (shaded) scene.shading = Shading{};
        RenderOptions options = small(rule);
        options.reconstruction = kernel;
        options.skip_empty = false;
        const RenderResult all = raycast_plain(volume, scene, options);
        options.skip_empty = true;
        const RenderResult skipped = raycast_plain(volume, scene, options);
        for (int y = 0; y < options.height; ++y) {
          for (int x = 0; x < options.width; ++x) {
            for (const int c : {0, 1, 2, 3, 5}) {
              ASSERT_EQ(all.image.at(x, y, c), skipped.image.at(x, y, c)) << x << " " << y << " " << c;
            }
          }
        }
        EXPECT_LT(skipped.counts.samples, all.counts.samples);
        EXPECT_EQ(skipped.counts.samples + skipped.counts.skipped, all.counts.samples);
        EXPECT_EQ(skipped.counts.gradients, all.counts.gradients);
        EXPECT_EQ(all.counts.skipped, 0);
      }
    }
  }
}

TEST(Plain, TurnedVolumeAndTurnedCameraAreTheSamePicture) {
  // Turn the grid about +y by 40 degrees and the camera with it.
  volume::Volume volume = generic_volume();
  volume.geometry().direction = Mat3::Identity();
  volume::Volume turned = volume;
  const Mat3 turn = Eigen::AngleAxisd(40 * M_PI / 180, Vec3::UnitY()).toRotationMatrix();
  turned.geometry().direction = turn;
  turned.geometry().origin = turn * volume.geometry().origin;
  Scene scene = scene_of(ramp_transfer());
  scene.shading = Shading{};
  for (const bool perspective : {false, true}) {
    if (perspective) scene.view.projection = camera::Projection::perspective;
    Scene other = scene;
    other.view.azimuth += 40;
    const auto bounds = volume::field_bounds(volume.geometry());
    const auto turned_bounds = volume::field_bounds(turned.geometry());
    for (const double x : {30.0, 50.5, 66.0}) {
      // Conditioning: positions of size 30 to 1e-15 and a shading that may turn by 10 a unit.
      EXPECT_LT(difference(cast(plain_caster(volume, scene, small()), bounds, scene, x, 45),
                           cast(plain_caster(turned, other, small()), turned_bounds, other, x, 45)),
                1e-11);
      EXPECT_LT(difference(cast(reference_caster(volume, scene, {}), bounds, scene, x, 45),
                           cast(reference_caster(turned, other, {}), turned_bounds, other, x, 45)),
                2e-9);
    }
  }
}

TEST(Plain, PerspectiveFromInside) {
  const FunctionField field{[](const Vec3&) { return 1.0; }, {}, box_of({0, 0, 0}, {4, 4, 4})};
  Scene scene = scene_of(constant_transfer(0.3), 0, 0);
  scene.view.projection = camera::Projection::perspective;
  scene.view.distance = 1;  // eye at z = 3, looking along -z
  const Pixel p = cast(plain_caster(view_of(field), scene, small()), field.box, scene, 50, 50);
  EXPECT_NEAR(p.alpha, 1 - std::pow(0.7, 3 / scene.reference_length), 1e-13);
  EXPECT_NEAR(p.depth, std::log(2) / -std::log(0.7) * scene.reference_length, 1e-12);
  EXPECT_NEAR(cast(reference_caster(view_of(field), scene, {}), field.box, scene, 50, 50).depth, p.depth,
              1e-9);
}

TEST(Plain, TerminationBoundsTheError) {
  const volume::Volume volume = generic_volume();
  const auto bounds = volume::field_bounds(volume.geometry());
  const Scene scene = scene_of(ramp_transfer(0.9));
  RenderOptions options = small();
  const Pixel full = cast(plain_caster(volume, scene, options), bounds, scene);
  options.termination = 0.1;
  RenderCounts counts;
  const Pixel early = cast(plain_caster(volume, scene, options), bounds, scene, 50.3, 49.4, &counts);
  EXPECT_EQ(counts.terminated, 1);
  EXPECT_GT(difference(full, early), 0);
  EXPECT_LE(difference(full, early), 0.1);  // the transmittance that is left; colours are at most 1
}

TEST(Plain, ThreadsChangeNothing) {
  const volume::Volume volume = generic_volume();
  const Scene scene = scene_of(kBands);
  set_thread_count(1);
  const RenderResult one = raycast_plain(volume, scene, small());
  const RenderResult truth = raycast_reference(volume, scene, small());
  set_thread_count(2);
  const RenderResult two = raycast_plain(volume, scene, small());
  EXPECT_TRUE(same_bits(one.image, two.image));
  EXPECT_EQ(one.counts.samples, two.counts.samples);
  const RenderResult truth2 = raycast_reference(volume, scene, small());
  EXPECT_TRUE(same_bits(truth.image, truth2.image));
  EXPECT_EQ(truth.error_estimate, truth2.error_estimate);
}

TEST(Plain, RaysThatMissAreEmpty) {
  const volume::Volume volume = generic_volume();
  Scene scene = scene_of(ramp_transfer());
  scene.view.width = 1000;
  const RenderResult result = raycast_plain(volume, scene, small());
  EXPECT_EQ(result.image.at(0, 0, 3), 0);
  EXPECT_EQ(result.image.at(0, 0, 4), 0);
  EXPECT_TRUE(std::isinf(result.image.at(0, 0, 5)));
  scene.model = Model::xray;
  EXPECT_EQ(raycast_plain(volume, scene, small()).image.at(0, 0, 3), 0);
}

}  // namespace
}  // namespace vol::render
