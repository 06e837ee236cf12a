#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "packet_scenes.h"
#include "render/packet.h"
#include "render/visibility.h"

namespace vol::render {
namespace {

using volume::Reconstruction;

constexpr int kSamples = 4, kDepth = 5;

struct Difference {
  double colour = 0, samples = 0, depth = 0;
};

/// Largest differences of R, G, B, A; of samples; of depth where both pictures have one.
Difference difference(const image::Image& a, const image::Image& b) {
  Difference d;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      for (int c = 0; c < 4; ++c)
        d.colour = std::max(d.colour, std::abs(double(a.at(x, y, c)) - b.at(x, y, c)));
      d.samples = std::max(d.samples, std::abs(double(a.at(x, y, kSamples)) - b.at(x, y, kSamples)));
      if (std::isfinite(a.at(x, y, kDepth)) && std::isfinite(b.at(x, y, kDepth))) {
        d.depth = std::max(d.depth, std::abs(double(a.at(x, y, kDepth)) - b.at(x, y, kDepth)));
      }
    }
  }
  return d;
}

/// Same picture, bit for bit; the samples channel only where asked.
void expect_same_bits(const image::Image& a, const image::Image& b, bool samples_too) {
  ASSERT_EQ(a.pixels.size(), b.pixels.size());
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (i % a.channels.size() == kSamples && !samples_too) continue;
    ASSERT_EQ(a.pixels[i], b.pixels[i])
        << "value " << i % a.channels.size() << " of pixel " << i / a.channels.size();
  }
}

/// The packet caster within its bound of the oracle, and the same samples where nothing is skipped.
void expect_oracle(const volume::Volume& v, const Scene& scene, RenderOptions options, double largest = 1,
                   const index::IndexVolume* index = nullptr) {
  options.skip_empty = false;
  const RenderResult plain = raycast_plain(v, scene, options, index);
  const RenderResult packet = raycast_packet(v, scene, options, index);
  double nodes = 0, coverage = 0;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      nodes = std::max(nodes, double(plain.image.at(x, y, kSamples)));
      coverage = std::max(coverage, double(plain.image.at(x, y, 0)));
    }
  }
  ASSERT_GT(coverage, 0.01 * largest) << "an empty picture tests nothing";
  const Difference d = difference(plain.image, packet.image);
  EXPECT_LE(d.colour, packet_tolerance(nodes) * largest);
  EXPECT_EQ(d.samples, 0);
  // Depth: T moves by the tolerance where its slope along the ray may be a hundredth.
  if (scene.model == Model::composite) {
    EXPECT_LE(d.depth, 1e-3);
  }
  EXPECT_EQ(plain.counts.rays, packet.counts.rays);
  EXPECT_EQ(plain.counts.samples, packet.counts.samples);
  // Preintegrated packets light every sample: whether its segment is visible is known too late.
  if (options.quadrature != Quadrature::preintegrated) {
    EXPECT_EQ(plain.counts.gradients, packet.counts.gradients);
  }
  EXPECT_EQ(plain.counts.terminated, packet.counts.terminated);
}

class PacketRule : public testing::TestWithParam<Quadrature> {};
INSTANTIATE_TEST_SUITE_P(Rules, PacketRule,
                         testing::Values(Quadrature::rectangle, Quadrature::trapezoid,
                                         Quadrature::preintegrated));

TEST_P(PacketRule, AgreesWithTheOracleOnEveryVoxelType) {
  const RenderOptions options = packet_options(GetParam());
  expect_oracle(packet_volume<std::uint8_t>(255), packet_scene(255), options);
  expect_oracle(packet_volume<std::uint16_t>(60000), packet_scene(60000), options);
  expect_oracle(packet_volume<std::int16_t>(30000, {23, 18, 29}, -25000), packet_scene(30000, 0.5, -25000),
                options);
  expect_oracle(packet_volume<float>(1), packet_scene(1), options);
  expect_oracle(packet_volume<double>(1e-3), packet_scene(1e-3), options);
  expect_oracle(packet_volume<std::int8_t>(100, {23, 18, 29}, -50), packet_scene(100, 0.5, -50), options);
}

TEST_P(PacketRule, AgreesForSoftDenseAndOpaqueTransferFunctions) {
  const auto v = packet_volume<std::uint8_t>(255);
  const RenderOptions options = packet_options(GetParam());
  expect_oracle(v, packet_soft_scene(255), options);
  for (const double opacity : {0.97, 0.999999, 1.0}) {
    SCOPED_TRACE(opacity);
    expect_oracle(v, packet_scene(255, opacity), options);
  }
}

TEST_P(PacketRule, AgreesForEarlyTermination) {
  RenderOptions options = packet_options(GetParam());
  options.termination = 0.1;
  expect_oracle(packet_volume<std::uint8_t>(255), packet_scene(255, 0.7), options);
}

TEST_P(PacketRule, AgreesForNearestShadingAndPerspective) {
  const auto v = packet_volume<std::uint16_t>(60000);
  RenderOptions options = packet_options(GetParam());
  Scene scene = packet_scene(60000);
  scene.shading = Shading{};
  expect_oracle(v, scene, options, 1.1);
  scene.shading->light = Vec3(1, 2, -1);
  scene.view.projection = camera::Projection::perspective;
  expect_oracle(v, scene, options, 1.1);
  scene.shading.reset();
  options.reconstruction = Reconstruction::nearest;
  expect_oracle(v, scene, options);
}

TEST_P(PacketRule, AgreesForXrayAndMip) {
  const auto v = packet_volume<std::uint8_t>(255);
  Scene scene = packet_scene(255);
  scene.model = Model::xray;
  expect_oracle(v, scene, packet_options(GetParam()), 255 * 20);  // a box some 20 long
  scene.model = Model::mip;
  expect_oracle(v, scene, packet_options(GetParam()), 255);
}

TEST_P(PacketRule, AgreesForFlatVolumesAndExtremeSteps) {
  RenderOptions options = packet_options(GetParam());
  for (const Dims& dims :
       {Dims{1, 18, 29}, Dims{23, 1, 29}, Dims{23, 18, 1}, Dims{2, 2, 2}, Dims{1, 1, 29}}) {
    SCOPED_TRACE(testing::PrintToString(dims));
    Scene scene = packet_soft_scene(1);
    scene.view.width = 8;
    expect_oracle(packet_volume<float>(1, dims, 0.3), scene, options, 0.1);
  }
  for (const double step : {0.004, 3.7, 1e3, 1e30}) {
    SCOPED_TRACE(step);
    options.step = step;
    expect_oracle(packet_volume<std::uint8_t>(200, {23, 18, 29}, 50), packet_soft_scene(255), options);
  }
}

index::IndexVolume random_index(const Dims& dims, int reduction, double step, int levels) {
  index::IndexVolume index(dims, reduction, step);
  Rng rng(7);
  for (std::int64_t k = 0; k < index.dims()[2]; ++k) {
    for (std::int64_t j = 0; j < index.dims()[1]; ++j) {
      for (std::int64_t i = 0; i < index.dims()[0]; ++i) {
        index.set_entry(i, j, k, static_cast<int>(rng.below(static_cast<std::uint64_t>(levels))));
      }
    }
  }
  return index;
}

TEST_P(PacketRule, FollowsAnIndexAsTheOracleDoes) {
  const auto v = packet_volume<std::uint8_t>(255);
  RenderOptions options = packet_options(GetParam());
  options.step = 0.061;
  for (const int reduction : {1, 3, 4}) {
    SCOPED_TRACE(reduction);
    const auto index = random_index(v.geometry().dims, reduction, options.step, 5);
    Scene scene = packet_scene(255);
    expect_oracle(v, scene, options, 1, &index);
    scene.model = Model::xray;
    expect_oracle(v, scene, options, 255 * 20, &index);
  }
}

TEST_P(PacketRule, AnIndexOfZerosIsTheUniformPictureBitForBit) {
  const auto v = packet_volume<std::uint8_t>(255);
  const RenderOptions options = packet_options(GetParam());
  const index::IndexVolume zeros(v.geometry().dims, 1, options.step);
  for (const Scene& scene : {packet_scene(255, 0.4), packet_soft_scene(255)}) {
    for (const Model model : {Model::composite, Model::xray, Model::mip}) {
      Scene s = scene;
      s.model = model;
      expect_same_bits(raycast_packet(v, s, options).image, raycast_packet(v, s, options, &zeros).image,
                       false);
    }
  }
}

TEST_P(PacketRule, SkippingChangesNoBitAndSkips) {
  const auto v = packet_volume<std::uint8_t>(255, {61, 47, 70});
  RenderOptions options = packet_options(GetParam());
  for (const double opacity : {0.5, 1.0}) {
    Scene scene = packet_scene(255, opacity);
    scene.shading = Shading{};
    options.skip_empty = false;
    const RenderResult all = raycast_packet(v, scene, options);
    options.skip_empty = true;
    const RenderResult skipping = raycast_packet(v, scene, options);
    expect_same_bits(all.image, skipping.image, false);
    EXPECT_LT(skipping.counts.samples, all.counts.samples / 2);
    if (GetParam() != Quadrature::preintegrated) {
      EXPECT_EQ(skipping.counts.gradients, all.counts.gradients);
    }
    if (opacity < 1) {
      EXPECT_EQ(skipping.counts.samples + skipping.counts.skipped, all.counts.samples);
    }
  }
}

/// With an index, empty space is left at the first lattice node that may be visible, whatever the entries say
/// there.
TEST_P(PacketRule, LeavesEmptySpaceWithAnIndexAsTheOracleDoes) {
  const auto v = packet_volume<std::uint8_t>(255, {61, 47, 70});
  RenderOptions options = packet_options(GetParam());
  for (const int reduction : {1, 3}) {
    const auto index = random_index(v.geometry().dims, reduction, options.step, 4);
    for (const double opacity : {0.5, 1.0}) {
      const Scene scene = packet_scene(255, opacity);
      const RenderResult plain = raycast_plain(v, scene, options, &index);
      const RenderResult packet = raycast_packet(v, scene, options, &index);
      const Difference d = difference(plain.image, packet.image);
      EXPECT_LE(d.colour, packet_tolerance(300));
      EXPECT_LT(packet.counts.samples, packet.counts.skipped);
      EXPECT_NEAR(double(plain.counts.samples), double(packet.counts.samples),
                  0.02 * double(plain.counts.samples))
          << "but for the node that ends a ray, which the oracle knows to be needless more often";
    }
  }
}

TEST_P(PacketRule, ThreadsChangeNothing) {
  const auto v = packet_volume<std::uint8_t>(255);
  RenderOptions options = packet_options(GetParam());
  options.width = 97;
  options.height = 70;
  set_thread_count(1);
  const RenderResult one = raycast_packet(v, packet_scene(255), options);
  set_thread_count(0);
  const RenderResult many = raycast_packet(v, packet_scene(255), options);
  expect_same_bits(one.image, many.image, true);
  EXPECT_EQ(one.counts.samples, many.counts.samples);
  EXPECT_EQ(one.counts.skipped, many.counts.skipped);
}

TEST_P(PacketRule, InstructionSetsAgreeWithinTheBound) {
  const auto v = packet_volume<std::uint8_t>(255);
  const RenderOptions options = packet_options(GetParam());
  Scene scene = packet_scene(255);
  scene.shading = Shading{};
  const RenderResult best = raycast_packet(v, scene, options);
  const std::string best_set = packet_instruction_set();
  for (const std::int64_t target : {HWY_AVX2, HWY_SSE4, HWY_SCALAR}) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    SCOPED_TRACE(packet_instruction_set());
    const RenderResult other = raycast_packet(v, scene, options);
    const Difference d = difference(best.image, other.image);
    EXPECT_LE(d.colour, 1.1 * packet_tolerance(100));
    EXPECT_EQ(d.samples, 0);
    EXPECT_EQ(best.counts.skipped, other.counts.skipped);
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
  EXPECT_EQ(best_set, packet_instruction_set());
}

TEST(Packet, PassesOnWhatItDoesNotCover) {
  const auto v = packet_volume<std::uint8_t>(255);
  RenderOptions options = packet_options(Quadrature::trapezoid);
  options.reconstruction = Reconstruction::catmull_rom;
  expect_same_bits(raycast_plain(v, packet_scene(255), options).image,
                   raycast_packet(v, packet_scene(255), options).image, true);
}

TEST(Packet, RefusesNaNAndAForeignIndex) {
  auto v = packet_volume<float>(1);
  const index::IndexVolume foreign({3, 4, 5}, 1, 1);
  EXPECT_THROW((void)raycast_packet(v, packet_scene(1), packet_options(), &foreign), Error);
  std::get<volume::Grid<float>>(v.grid)(3, 4, 5) = std::nanf("");
  EXPECT_THROW((void)raycast_packet(v, packet_scene(1), packet_options()), Error);
}

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

TEST(PacketSplit, IsTheTruthUpToSinglePrecision) {
  RenderOptions options = packet_options();
  constexpr double kBound =
      2e-5;  // 5e-8 of rounding in each of some 100 pieces, and the colour's slope in a piece
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

/// Values beyond the transfer function's points, colours constant there: nothing may be divided by an
/// extinction of 0.
TEST(PacketSplit, TakesVolumesThatReachBeyondTheTransferFunction) {
  RenderOptions options = packet_options();
  const auto v = packet_volume<float>(1.3, {23, 18, 29}, -0.1);
  EXPECT_LE(split_error(v, packet_soft_scene(1), options), 2e-5);
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
    EXPECT_LE(split_error(v, scene, options), 2e-5);
    options.quadrature = Quadrature::preintegrated;
    expect_oracle(v, scene, options);
  }
}

TEST(Packet, LeavesToTheOracleWhatFloatDoesNotHold) {
  auto v = packet_volume<double>(1);
  for (auto& value : std::get<volume::Grid<double>>(v.grid).voxels) value += 1e9;
  Scene scene = packet_soft_scene(1);
  scene.transfer =
      transfer::TransferFunction({{1e9, {0, 0, 0}}, {1e9 + 1, {1, 1, 1}}}, {{1e9, 0}, {1e9 + 1, 0.3}});
  const RenderOptions options = packet_options();
  expect_same_bits(raycast_plain(v, scene, options).image, raycast_packet(v, scene, options).image, true);
  for (auto& value : std::get<volume::Grid<double>>(v.grid).voxels) value = (value - 1e9) * 6e38 - 3e38;
  scene.transfer =
      transfer::TransferFunction({{-3e38, {0, 0, 0}}, {3e38, {1, 1, 1}}}, {{-3e38, 0}, {3e38, 0.3}});
  for (const Quadrature q : {Quadrature::trapezoid, Quadrature::preintegrated}) {
    RenderOptions o = options;
    o.quadrature = q;
    expect_same_bits(raycast_plain(v, scene, o).image, raycast_packet(v, scene, o).image, true);
  }
}

TEST(PacketSplit, ThreadsAndInstructionSetsAgree) {
  const auto v = packet_volume<std::uint8_t>(255);
  const RenderOptions options = packet_options(Quadrature::split);
  const Scene scene = packet_scene(255);
  const RenderResult best = raycast_packet(v, scene, options);
  set_thread_count(1);
  expect_same_bits(best.image, raycast_packet(v, scene, options).image, true);
  set_thread_count(0);
  for (const std::int64_t target : {HWY_AVX2, HWY_SSE4, HWY_SCALAR}) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    EXPECT_LE(difference(best.image, raycast_packet(v, scene, options).image).colour, 1e-5)
        << packet_instruction_set();
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
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
  EXPECT_LE(difference(all.image, skipping.image).colour, 1e-5);
  EXPECT_GT(skipping.counts.skipped, 0);
}

TEST(Visibility, DistanceIsChebyshevsToTheNearestVisibleMacrocell) {
  Rng rng(3);
  index::Macrocells cells;
  cells.dims = {13, 9, 17};
  cells.ranges = Buffer<index::Macrocells::Range>(cells.offset(0, 0, 17));
  for (auto& range : cells.ranges)
    range = rng.uniform() < 0.004 ? index::Macrocells::Range{2, 3} : index::Macrocells::Range{0, 1};
  cells.all = {0, 3};
  const Visibility v = visibility(cells, transfer::TransferFunction({{0, {1, 1, 1}}}, {{1.5, 0}, {2.5, 1}}));
  EXPECT_FALSE(v.all_visible);
  const auto each = [&](const auto& visit) {
    for (std::int64_t c = 0; c < 17; ++c)
      for (std::int64_t b = 0; b < 9; ++b)
        for (std::int64_t a = 0; a < 13; ++a) visit(a, b, c);
  };
  each([&](std::int64_t a, std::int64_t b, std::int64_t c) {
    std::int64_t least = 255;
    each([&](std::int64_t i, std::int64_t j, std::int64_t k) {
      if (cells(i, j, k).max > 2)
        least = std::min(least, std::max({std::abs(a - i), std::abs(b - j), std::abs(c - k)}));
    });
    EXPECT_EQ(v.distance[cells.offset(a, b, c)], least);
  });
}

TEST(Visibility, InvisibleValuesAreClosedIntervalsWithoutTheJumps) {
  const double inf = std::numeric_limits<double>::infinity();
  const transfer::TransferFunction transfer(
      {{0, {1, 1, 1}}}, {{1, 0}, {1, 0.5}, {2, 0}, {3, 0}, {4, 1}, {5, 0}, {6, 0.1}, {7, 0}});
  const auto found = invisible_values(transfer);
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0].min, -inf);
  EXPECT_LT(found[0].max, 1);
  EXPECT_EQ(found[1].min, 2);
  EXPECT_EQ(found[1].max, 3);
  EXPECT_EQ(found[2].min, 5);
  EXPECT_EQ(found[2].max, 5);
  EXPECT_EQ(found[3].min, 7);
  EXPECT_EQ(found[3].max, inf);
}

TEST(Macrocells, RangesAreThoseOfTheSamplesAroundTheirCells) {
  const Dims dims{19, 8, 33};
  const auto v = packet_volume<std::int16_t>(3000, dims, -700);
  const auto& grid = std::get<volume::Grid<std::int16_t>>(v.grid);
  const index::Macrocells cells = index::macrocells(v);
  constexpr std::int64_t kEdge = index::Macrocells::kEdge;
  ASSERT_EQ(cells.dims, (Dims{(18 + kEdge - 1) / kEdge, (7 + kEdge - 1) / kEdge, (32 + kEdge - 1) / kEdge}));
  for (std::int64_t n = 0; n < cells.dims[0] * cells.dims[1] * cells.dims[2]; ++n) {
    const std::int64_t a = n % cells.dims[0], b = n / cells.dims[0] % cells.dims[1],
                       c = n / cells.dims[0] / cells.dims[1];
    float lo = 1e9F, hi = -1e9F;
    for (std::int64_t k = kEdge * c; k <= std::min<std::int64_t>(kEdge * c + kEdge, 32); ++k) {
      for (std::int64_t j = kEdge * b; j <= std::min<std::int64_t>(kEdge * b + kEdge, 7); ++j) {
        for (std::int64_t i = kEdge * a; i <= std::min<std::int64_t>(kEdge * a + kEdge, 18); ++i) {
          lo = std::min(lo, float(grid(i, j, k)));
          hi = std::max(hi, float(grid(i, j, k)));
        }
      }
    }
    EXPECT_EQ(cells(a, b, c).min, lo);
    EXPECT_EQ(cells(a, b, c).max, hi);
  }
}

}  // namespace
}  // namespace vol::render
