#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "instruction_sets.h"
#include "packet_oracle.h"

namespace vol::render {
namespace {

/// Split against the truth: what is left are float rounding and the Gauss rules' own error on the pieces.
double split_error(const volume::Volume& v, const Scene& scene, RenderOptions options) {
  options.quadrature = Quadrature::split;
  const RenderResult split = raycast_packet(v, scene, options);
  options.tolerance = 1e-9;
  const RenderResult truth = raycast_reference(v, scene, options);
  double coverage = 0;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) coverage = std::max(coverage, double(truth.image.at(x, y, 3)));
  }
  EXPECT_GT(coverage, 0.02) << "an empty picture tests nothing";
  const Difference d = difference(truth.image, split.image);
  // Depth is taken as linear within a piece; where extinction rises from 0 it errs by up to a quarter of the
  // piece.
  EXPECT_LE(d.depth, 0.25 * 0.5 * std::hypot(0.5, 0.8, 0.4) + 0.05);
  return d.colour;
}

/// 5e-8 of rounding in each of some 100 pieces.
constexpr double kRounding = 5e-6;
/// Of the truth: rounding, and the colour's slope in a piece.
constexpr double kBound = 2e-5;

TEST(PacketSplit, IsTheTruthUpToSinglePrecision) {
  RenderOptions options = packet_options();
  for (const bool perspective : {false, true}) {
    const auto viewed = [&](Scene scene) {
      if (perspective) scene.view.projection = camera::Projection::perspective;
      return scene;
    };
    EXPECT_LE(split_error(packet_volume<std::uint8_t>(255), viewed(packet_scene(255)), options), kBound);
    EXPECT_LE(split_error(packet_volume<std::uint8_t>(255), viewed(packet_soft_scene(255)), options), kBound);
    EXPECT_LE(split_error(packet_volume<std::int16_t>(30000, {23, 18, 29}, -25000),
                          viewed(packet_scene(30000, 0.5, -25000)), options),
              kBound);
    EXPECT_LE(split_error(packet_volume<float>(1), viewed(packet_scene(1, 0.97)), options), kBound);
  }
  for (const Dims& dims :
       {Dims{1, 18, 29}, Dims{23, 1, 29}, Dims{23, 18, 1}, Dims{2, 2, 2}, Dims{1, 1, 29}}) {
    SCOPED_TRACE(testing::PrintToString(dims));
    Scene scene = packet_soft_scene(1);
    scene.view.width = 8;
    EXPECT_LE(split_error(packet_volume<float>(1, dims, 0.3), scene, options), kBound);
  }
}

/// Few intervals are looked up in registers, as many as an instruction set's hold; others in tables.
TEST(PacketSplit, IsTheTruthForAnyNumberOfIntervals) {
  const auto v = packet_volume<std::uint8_t>(255);
  RenderOptions options = packet_options();
  options.width = 23;
  options.height = 19;
  Rng rng(10);
  for (const int points : {1, 2, 3, 6, 11, 20}) {
    Scene scene = packet_scene(255);
    scene.transfer = transfer::TransferFunction(scene.transfer.colours(), packet_ramps(points, rng));
    SCOPED_TRACE(points);
    // Rounding beside a jump of opacity moves where the ray is cut, by 1e-6 voxel.
    on_every_instruction_set([&] { EXPECT_LE(split_error(v, scene, options), kBound); });
  }
}

/// Values beyond the transfer function's points, colours constant there: nothing may be divided by an
/// extinction of 0.
TEST(PacketSplit, TakesVolumesThatReachBeyondTheTransferFunction) {
  RenderOptions options = packet_options();
  const auto v = packet_volume<float>(1.3, {23, 18, 29}, -0.1);
  EXPECT_LE(split_error(v, packet_soft_scene(1), options), kBound);
  options.quadrature = Quadrature::preintegrated;
  expect_oracle(v, packet_soft_scene(1), options);
}

/// What lies beyond the data may be opaque; rays beside the volume must not matter; float must hold the
/// values.
TEST(PacketSplit, EndsWhereTheTransferFunctionIsOpaqueBeyondTheDataAndBesideTheVolume) {
  const auto v = packet_volume<std::uint8_t>(200);
  Scene scene = packet_soft_scene(255);
  scene.view.width = 40;  // most lanes miss
  for (const auto& points :
       {std::vector<transfer::OpacityPoint>{{0, 0}, {255, 1}}, {{-50, 1}, {20, 0}, {255, 0.3}}}) {
    scene.transfer = transfer::TransferFunction({{0, {0, 0, 0}}, {255, {1, 1, 1}}}, points);
    RenderOptions options = packet_options();
    EXPECT_LE(split_error(v, scene, options), kBound);
    options.quadrature = Quadrature::preintegrated;
    expect_oracle(v, scene, options);
  }
}

TEST(PacketSplit, ThreadsChangeNothing) {
  expect_threads_change_nothing(packet_volume<std::uint8_t>(255), packet_scene(255),
                                packet_options(Quadrature::split));
}

TEST(PacketSplit, InstructionSetsAgree) {
  const auto v = packet_volume<std::uint8_t>(255);
  const RenderOptions options = packet_options(Quadrature::split);
  const Scene scene = packet_scene(255);
  const RenderResult best = raycast_packet(v, scene, options);
  const int sets = on_every_instruction_set([&] {
    EXPECT_LE(difference(best.image, raycast_packet(v, scene, options).image).colour, 2 * kRounding);
  });
  if (sets < 2) GTEST_SKIP() << "packets were compiled for one instruction set";
}

TEST(PacketSplit, LightsByTheGradientAtEveryNode) {
  Scene scene = packet_scene(255);
  scene.shading = Shading{};
  const double error = split_error(packet_volume<std::uint8_t>(255), scene, packet_options());
  // |n.l| has kinks inside a cell that no cut of the transfer function finds.
  EXPECT_LE(error, 2e-3);
}

TEST(PacketSplit, MoreNodesComeCloser) {
  const auto v = packet_volume<std::uint8_t>(255);
  RenderOptions options = packet_options();
  double before = 1;
  for (const int nodes : {1, 2, 3}) {
    options.nodes = nodes;
    const double error = split_error(v, packet_scene(255, 0.6), options);
    EXPECT_LT(error, 0.2 * before) << nodes;
    before = error;
  }
}

TEST(PacketSplit, SkippingChangesNothingThatShows) {
  const auto v = packet_volume<std::uint8_t>(255, {61, 47, 70});
  RenderOptions options = packet_options(Quadrature::split);
  const RenderResult skipping = raycast_packet(v, packet_scene(255), options);
  options.skip_empty = false;
  const RenderResult all = raycast_packet(v, packet_scene(255), options);
  EXPECT_LE(difference(all.image, skipping.image).colour, 2 * kRounding);
  EXPECT_GT(skipping.counts.skipped, 0);
}

}  // namespace
}  // namespace vol::render
