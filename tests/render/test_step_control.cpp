// Steps of adaptive length (step_control.h): packets against the plain caster, and what the tolerance says.
#include "render/step_control.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "fields.h"
#include "instruction_sets.h"
#include "noise_volume.h"
#include "packet_oracle.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

RenderOptions adaptive_options(double tolerance = 0.01, double step = 1.1) {
  RenderOptions options = packet_options();
  options.step = step;
  options.step_tolerance = tolerance;
  return options;
}

/// Share of the pixels that differ by more than `most`, or in their samples.
double share_apart(const image::Image& a, const image::Image& b, double most) {
  int apart = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      double d = a.at(x, y, kSamples) == b.at(x, y, kSamples) ? 0 : INFINITY;
      for (int c = 0; c < 4; ++c) d = std::max(d, std::abs(double(a.at(x, y, c)) - b.at(x, y, c)));
      apart += d > most;
    }
  }
  return apart / double(a.width * a.height);
}

/// A pair whose estimate is within rounding of the tolerance may be passed by one alone: its pixel is off by
/// a few tolerances then. Estimates spread over a decade and more, and rounding moves them by 1e-5 of
/// themselves: of some 50 pairs a ray, one in 1e3 rays or fewer; a handful of 1665 pixels are allowed. All
/// others are as near as packets are. Samples follow these pixels, by some tens of some thousands.
void expect_the_same(const RenderResult& plain, const RenderResult& packet, double tolerance,
                     double largest = 1) {
  ASSERT_GT(plain.counts.samples, 1000) << "an empty picture tests nothing";
  ASSERT_STREQ(packet.caster, "packets");
  EXPECT_LE(share_apart(plain.image, packet.image, packet_tolerance(500) * largest), 0.004);
  EXPECT_LE(difference(plain.image, packet.image).colour,
            std::max(5 * tolerance, packet_tolerance(500) * largest));
  EXPECT_EQ(plain.counts.rays, packet.counts.rays);
  const auto samples = static_cast<double>(plain.counts.samples);
  EXPECT_NEAR(samples, static_cast<double>(packet.counts.samples), 1e-3 * samples);
  EXPECT_NEAR(static_cast<double>(plain.counts.gradients), static_cast<double>(packet.counts.gradients),
              1e-3 * samples);
  EXPECT_NEAR(static_cast<double>(plain.counts.terminated), static_cast<double>(packet.counts.terminated), 2);
}

void expect_oracle_of_steps(const volume::Volume& v, const Scene& scene, RenderOptions options,
                            double largest = 1) {
  for (const bool skip : {false, true}) {
    SCOPED_TRACE(skip);
    options.skip_empty = skip;
    expect_the_same(raycast_plain(v, scene, options), raycast_packet(v, scene, options),
                    options.step_tolerance, largest);
  }
}

/// The grid's samples by their indices.
template <class T, class Field>
void fill(volume::Grid<T>& grid, const Field& field) {
  const Dims& dims = grid.geometry.dims;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) grid(i, j, k) = field(double(i), double(j), double(k));
    }
  }
}

/// Of R, G and B, over the picture.
double squared_error(const image::Image& image, const image::Image& truth) {
  double sum = 0;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      for (int c = 0; c < 3; ++c) sum += std::pow(double(truth.at(x, y, c)) - image.at(x, y, c), 2);
    }
  }
  return sum;
}

TEST(StepControl, PacketsAgreeWithTheOracleOnEveryVoxelType) {
  const RenderOptions options = adaptive_options();
  expect_oracle_of_steps(packet_volume<std::uint8_t>(255), packet_scene(255), options);
  expect_oracle_of_steps(packet_volume<std::uint16_t>(60000), packet_scene(60000), options);
  expect_oracle_of_steps(packet_volume<std::int16_t>(30000, {23, 18, 29}, -25000),
                         packet_scene(30000, 0.5, -25000), options);
  expect_oracle_of_steps(packet_volume<float>(1), packet_scene(1), options);
}

TEST(StepControl, PacketsAgreeForSoftAndDenseTransferFunctionsAndEarlyTermination) {
  const auto v = packet_volume<std::uint8_t>(255);
  for (const double tolerance : {0.1, 0.01, 0.001}) {
    RenderOptions options = adaptive_options(tolerance);
    expect_oracle_of_steps(v, packet_soft_scene(255), options);
    Scene shaded = packet_soft_scene(255);
    shaded.shading = Shading{};
    expect_oracle_of_steps(v, shaded, options);
    options.termination = 0.05;
    expect_oracle_of_steps(v, packet_scene(255, 0.97), options);
  }
}

TEST(StepControl, PacketsAgreeForShadingPerspectiveAndFlatVolumes) {
  Scene scene = packet_scene(60000);
  scene.shading = Shading{};
  scene.shading->light = Vec3(1, 2, -1);
  scene.view.projection = camera::Projection::perspective;
  expect_oracle_of_steps(packet_volume<std::uint16_t>(60000), scene, adaptive_options(), 1.1);
  scene = packet_soft_scene(1);
  scene.view.width = 8;
  expect_oracle_of_steps(packet_volume<float>(1, {23, 1, 29}, 0.3), scene, adaptive_options());
}

// Opacity 1 makes differences infinite: steps are the shortest there, and nothing is behind.
TEST(StepControl, PacketsAgreeWhereOpacityIsOne) {
  Scene scene = packet_scene(255, 1.0);
  expect_oracle_of_steps(packet_volume<std::uint8_t>(255), scene, adaptive_options());
  scene.shading = Shading{};
  expect_oracle_of_steps(packet_volume<std::uint8_t>(255), scene, adaptive_options());
}

// The medium is the same all along the faces, so that what is different at a ray's end does not count, and
// nowhere transparent: where three nodes are, no tolerance asks for shorter steps.
TEST(StepControl, NoToleranceAndAnyAreUniformSteps) {
  const auto v = packet_volume<std::uint8_t>(200, {23, 18, 29}, 50);
  const Scene scene = packet_soft_scene(255);
  for (const bool any : {false, true}) {
    SCOPED_TRACE(any);
    RenderOptions options = adaptive_options(any ? 1e6 : 1e-30, 0.2);
    const RenderResult adaptive = raycast_packet(v, scene, options);
    options.step_tolerance = 0;
    if (!any) options.step /= 1 << kHalvings;
    const RenderResult uniform = raycast_packet(v, scene, options);
    EXPECT_LE(difference(adaptive.image, uniform.image).colour, packet_tolerance(1000));
  }
}

const FunctionField kSmooth{[](const Vec3& p) {
                              return 0.5 + 0.3 * std::sin(1.3 * p[0] + 0.4) * std::cos(0.9 * p[1]) +
                                     0.1 * std::sin(p[2]);
                            },
                            [](const Vec3&) { return Vec3(0, 0, 1); }, generic_box()};

// Step doubling: an estimate is three times the error of its pair, and h goes with the cube root of the
// tolerance: at a 64th of it there are four times as many steps, with a 16th of the error. Steps are powers
// of two, hence the margins.
TEST(StepControl, ErrorIsBelowTheSumOfTheTolerancesAndOfOrderTwoInTheSamples) {
  const Scene scene = scene_of(ramp_transfer(0.7));
  const Pixel truth = cast(reference_caster(view_of(kSmooth), scene, {}), kSmooth.box, scene);
  const auto at = [&](double tolerance) {
    RenderOptions options;
    options.step = chord_length(kSmooth.box, scene) / 8.3;
    options.step_tolerance = tolerance;
    RenderCounts counts;
    const Pixel pixel =
        cast(plain_caster(view_of(kSmooth), scene, options), kSmooth.box, scene, 50.3, 49.4, &counts);
    const double error = difference(pixel, truth);
    EXPECT_LE(error, tolerance * static_cast<double>(counts.samples) / 2);
    return std::pair(error, static_cast<double>(counts.samples));
  };
  const auto [coarse, few] = at(3e-4);
  const auto [fine, many] = at(3e-4 / 64);
  EXPECT_GT(many / few, 2.5);
  EXPECT_LT(many / few, 6);
  const double order = std::log(coarse / fine) / std::log(many / few);
  EXPECT_NEAR(order, 2, 0.6);
}

// A ball with a thin bright shell: what contributes is a small part of every ray.
TEST(StepControl, TakesFewerSamplesThanUniformStepsAtLessError) {
  volume::Volume v = packet_volume<std::uint8_t>(255, {61, 61, 61});
  auto& grid = std::get<volume::Grid<std::uint8_t>>(v.grid);
  fill(grid, [](double i, double j, double k) {
    const double r = Vec3(i - 30, j - 30, k - 30).norm() / 30;
    return static_cast<std::uint8_t>(255 * std::max(0.0, 1 - r));
  });
  Scene scene = packet_scene(255);
  scene.transfer = transfer::TransferFunction({{0, {1, 0.5, 0.2}}, {255, {0.2, 0.5, 1}}},
                                              {{0, 0}, {60, 0.01}, {80, 0.6}, {100, 0.01}, {255, 0.02}});
  RenderOptions options = packet_options();
  options.step = 0.01;
  const image::Image truth = raycast_packet(v, scene, options).image;
  const RenderResult adaptive = raycast_packet(v, scene, adaptive_options(0.0005, 0.6));
  options.step = 0.15;
  const RenderResult uniform = raycast_packet(v, scene, options);
  EXPECT_LT(squared_error(adaptive.image, truth), squared_error(uniform.image, truth));
  EXPECT_LT(double(adaptive.counts.samples), 0.6 * double(uniform.counts.samples));
}

// 4^n g <= 1, and the next is not.
TEST(StepControl, ShadingAllowsTheMostDoublingsBelowTheTolerance) {
  Rng rng(5);
  for (int i = 0; i < 1000; ++i) {
    const double g = i < 8 ? std::pow(4, -i) : std::exp(rng.uniform(-12, 2));
    const int n = doublings_in_shading(g, 4);
    ASSERT_TRUE(n >= 0 && n <= 4);
    ASSERT_TRUE(n == 0 || std::pow(4, n) * g <= 1) << g;
    ASSERT_TRUE(n == 4 || std::pow(4, n + 1) * g > 1) << g;
  }
  EXPECT_EQ(doublings_in_shading(0, 3), 3);
  EXPECT_EQ(doublings_in_shading(1e308, 3), 0);
  EXPECT_EQ(doublings_in_shading(INFINITY, 3), 0);
}

// The same opacity and colour everywhere, and one gradient: trapezoids are exact and never differ, and with
// shading steps are a function of the depth alone, by Beer and Lambert.
TEST(StepControl, ShadedStepsLengthenAsTransmittanceFalls) {
  volume::Volume v = noise({21, 17, 25}, 3, 0, 1, false);
  fill(std::get<volume::Grid<double>>(v.grid), [](double, double, double k) { return 0.25 + k / 64; });
  Scene scene = scene_of(constant_transfer(0.11), 0, 0);
  const double chord = chord_length(volume::field_bounds(v.geometry()), scene);
  const double extinction = -std::log1p(-0.11) / scene.reference_length;
  const auto samples_of_a_ray = [&](double tolerance, double step, double weight) {
    const double shortest = step / 16;
    const auto last = static_cast<int>(std::ceil(chord / shortest)) - 1;
    const auto longest_at = [&](int node) {
      const double seen = std::exp(-extinction * node * shortest);
      int hop = 16;
      while (hop > 1 &&
             seen * extinction * hop * shortest * (hop * shortest / 0.7) * weight / 2 > tolerance) {
        hop /= 2;
      }
      return hop;
    };
    int samples = 2, node = 0;  // the first and the last
    for (int hop = longest_at(0); node + 2 <= last; hop = std::min(2 * hop, longest_at(node))) {
      while (node + 2 * hop > last) hop /= 2;
      samples += 2;
      node += 2 * hop;
    }
    return samples;
  };
  for (const double tolerance : {0.3, 0.017, 0.0021, 0.00013}) {
    for (const bool shaded : {false, true}) {
      SCOPED_TRACE(tolerance);
      scene.shading.reset();
      if (shaded) scene.shading = Shading{.diffuse = 0.5, .specular = 0.3, .light = std::nullopt};
      const RenderOptions options = adaptive_options(tolerance, 3.1);
      const RenderResult packet = raycast_packet(v, scene, options);
      ASSERT_STREQ(packet.caster, "packets");
      const RenderResult plain = raycast_plain(v, scene, options);
      const int expected = samples_of_a_ray(tolerance, 3.1, shaded ? 0.8 : 0);
      ASSERT_GT(packet.counts.rays, 100);
      EXPECT_EQ(packet.counts.samples, packet.counts.rays * expected);
      EXPECT_EQ(plain.counts.samples, plain.counts.rays * expected);
    }
  }
}

// A smooth field rounded to 71 values, whose normals turn at cells' faces: three samples rarely tell.
TEST(StepControl, ShadedTakesFewerSamplesThanUniformStepsAtLessError) {
  volume::Grid<std::uint8_t> grid{{.dims = {53, 47, 60}}, Buffer<std::uint8_t>(53 * 47 * 60)};
  fill(grid, [](double i, double j, double k) {
    return static_cast<std::uint8_t>(
        std::lround(120 + 20 * std::sin((i + k) / 11 + 1) + 15 * std::cos(j / 9)));
  });
  const volume::Volume v{std::move(grid), {}};
  Scene scene = scene_of(transfer::TransferFunction({{0, {1, 1, 1}}}, {{0, 0.05}, {255, 0.1}}));
  scene.shading = Shading{};
  RenderOptions options = packet_options();
  options.step = 0.05;
  const image::Image truth = raycast_packet(v, scene, options).image;
  const RenderResult adaptive = raycast_packet(v, scene, adaptive_options(0.01, 4));
  options.step = 0.5;
  const RenderResult uniform = raycast_packet(v, scene, options);
  EXPECT_LT(squared_error(adaptive.image, truth), squared_error(uniform.image, truth));
  EXPECT_LT(double(adaptive.counts.samples), 0.75 * double(uniform.counts.samples));
}

// Nearest samples have no gradient: shading changes no light there, and no steps (but where an estimate is
// within rounding of the tolerance: expect_the_same).
TEST(StepControl, ShadingOfNearestSamplesChangesNoSteps) {
  const auto v = packet_volume<std::uint8_t>(255);
  RenderOptions options = adaptive_options(0.003, 3);
  options.reconstruction = volume::Reconstruction::nearest;
  Scene scene = packet_soft_scene(255);
  scene.shading = Shading{.diffuse = 0, .specular = 0, .light = std::nullopt};
  const RenderResult ambient = raycast_packet(v, scene, options);
  scene.shading = Shading{};
  for (const RenderResult& result : {raycast_packet(v, scene, options), raycast_plain(v, scene, options)}) {
    EXPECT_NEAR(double(result.counts.samples), double(ambient.counts.samples),
                1e-3 * double(ambient.counts.samples));
  }
}

// A slice has no cells across it, however thin it is.
TEST(StepControl, SmallestCellIsThatOfAxesOfSeveralSamples) {
  volume::GridGeometry geometry;
  geometry.spacing = {2, 0.01, 3};
  geometry.dims = {4, 1, 5};
  EXPECT_EQ(smallest_cell(geometry, volume::Reconstruction::trilinear), 2);
  EXPECT_EQ(smallest_cell(geometry, volume::Reconstruction::nearest), 0);
  geometry.dims = {1, 1, 1};
  EXPECT_EQ(smallest_cell(geometry, volume::Reconstruction::trilinear), 0);
}

// No tolerance is lost when it becomes a float: what is below its range or above is its limit.
TEST(StepControl, PacketsAgreeAtTolerancesBeyondFloat) {
  const auto v = packet_volume<std::uint8_t>(255);
  for (const double tolerance : {1e-300, 1e300}) {
    SCOPED_TRACE(tolerance);
    Scene scene = packet_scene(255);
    expect_oracle_of_steps(v, scene, adaptive_options(tolerance), 1);
    scene.shading = Shading{};
    expect_oracle_of_steps(v, scene, adaptive_options(tolerance), 1);
  }
}

// A chord shorter than the step, and than the shortest.
TEST(StepControl, PacketsAgreeForStepsLongerThanChords) {
  for (const double step : {30.0, 1000.0}) {
    SCOPED_TRACE(step);
    const auto v = packet_volume<std::uint8_t>(200, {23, 18, 29}, 50);
    RenderOptions options = adaptive_options(0.01, step);
    options.width = options.height = 90;
    const RenderResult plain = raycast_plain(v, packet_soft_scene(255), options);
    const RenderResult packet = raycast_packet(v, packet_soft_scene(255), options);
    EXPECT_STREQ(packet.caster, "packets");
    EXPECT_LE(difference(plain.image, packet.image).colour, packet_tolerance(100));
    EXPECT_EQ(plain.counts.samples, packet.counts.samples);
  }
}

// A long ray's steps are halved less often, rather than left to the plain caster.
TEST(StepControl, LongRaysHaveFewerHalvings) {
  const auto v = packet_volume<std::uint8_t>(255, {23, 18, 900});
  const double diagonal = longest_diagonal(volume::field_bounds(v.geometry()));
  EXPECT_EQ(most_halvings(volume::field_bounds(v.geometry()), diagonal / 1000), 4);
  RenderOptions options = adaptive_options(0.01, diagonal / 9000);
  EXPECT_EQ(most_halvings(volume::field_bounds(v.geometry()), options.step), 1);
  EXPECT_EQ(most_halvings(volume::field_bounds(v.geometry()), diagonal / 40000), 0);
  options.width = options.height = 12;
  Scene scene = packet_scene(255);
  scene.view.width = 150;
  for (const bool skip : {false, true}) {
    options.skip_empty = skip;
    expect_the_same(raycast_plain(v, scene, options), raycast_packet(v, scene, options), 0.01, 10);
  }
}

TEST(StepControl, ThreadsChangeNothing) {
  expect_threads_change_nothing(packet_volume<std::uint8_t>(255), packet_scene(255), adaptive_options());
}

// What a ray samples does not depend on the others of its packet: rays of a refined picture, which are put
// together otherwise, are those of the whole one.
TEST(StepControl, RaysOfARefinedPictureAreThoseOfTheWholeOne) {
  const auto v = packet_volume<std::uint8_t>(255);
  Scene scene = packet_scene(255);
  for (const bool shaded : {false, true}) {
    if (shaded) scene.shading = Shading{};
    RenderOptions options = adaptive_options();
    options.width = 93;
    options.height = 75;
    const image::Image whole = raycast_packet(v, scene, options).image;
    options.image_step = 8;
    options.image_tolerance = 0.05;
    const RenderResult refined = raycast_packet(v, scene, options);
    int cast = 0;
    for (int y = 0; y < options.height; ++y) {
      for (int x = 0; x < options.width; ++x) {
        if (refined.image.at(x, y, kSamples) == 0) continue;
        ++cast;
        for (int c = 0; c < 6; ++c) ASSERT_EQ(refined.image.at(x, y, c), whole.at(x, y, c)) << x << " " << y;
      }
    }
    EXPECT_GT(cast, 500);
    EXPECT_LT(refined.counts.rays, 0.8 * options.width * options.height);
  }
}

TEST(StepControl, InstructionSetsAgree) {
  const auto v = packet_volume<std::uint8_t>(255);
  const RenderOptions options = adaptive_options();
  Scene scene = packet_scene(255);
  scene.shading = Shading{};
  const RenderResult best = raycast_packet(v, scene, options);
  const int sets = on_every_instruction_set(
      [&] { expect_the_same(best, raycast_packet(v, scene, options), options.step_tolerance); });
  const Scene grey = packet_soft_scene(255);  // one channel
  const RenderResult best_grey = raycast_packet(v, grey, options);
  on_every_instruction_set(
      [&] { expect_the_same(best_grey, raycast_packet(v, grey, options), options.step_tolerance); });
  if (sets < 2) GTEST_SKIP() << "packets were compiled for one instruction set";
}

TEST(StepControl, RefusesWhatHasNoStepsToChoose) {
  const auto v = packet_volume<std::uint8_t>(255);
  Scene scene = packet_scene(255);
  for (const Quadrature rule :
       {Quadrature::rectangle, Quadrature::preintegrated, Quadrature::split, Quadrature::reference}) {
    RenderOptions options = adaptive_options();
    options.quadrature = rule;
    EXPECT_THROW((void)raycast_packet(v, scene, options), Error);
  }
  const index::IndexVolume index(v.geometry().dims, 1, 1.1);
  EXPECT_THROW((void)raycast_packet(v, scene, adaptive_options(), &index), Error);
  EXPECT_THROW((void)raycast_plain(v, scene, adaptive_options(), &index), Error);
  for (const double wrong : {-1.0, std::nan(""), double(INFINITY)}) {
    EXPECT_THROW((void)raycast_packet(v, scene, adaptive_options(wrong)), Error);
  }
  scene.model = Model::xray;
  EXPECT_THROW((void)raycast_packet(v, scene, adaptive_options()), Error);
  EXPECT_THROW((void)raycast_plain(v, scene, adaptive_options()), Error);
}

}  // namespace
}  // namespace vol::render
