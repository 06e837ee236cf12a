#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/simd.h"
#include "instruction_sets.h"
#include "packet_oracle.h"
#include "render/packet_transfer.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

using volume::Reconstruction;

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

TEST_P(PacketRule, TakesAsManyStepsAsItsCountersHold) {
  // The way through the box from corner to corner is the longest: 32767 steps are counted by 15 bits.
  const auto v = packet_volume<std::uint8_t>(255);
  const Mat3 edges = volume::field_bounds(v.geometry()).edges;
  double longest = 0;
  for (const double y : {-1.0, 1.0}) {
    for (const double z : {-1.0, 1.0}) {
      longest = std::max(longest, Vec3(edges.col(0) + y * edges.col(1) + z * edges.col(2)).norm());
    }
  }
  const Scene scene = packet_soft_scene(255);
  RenderOptions options = packet_options(GetParam());
  const PacketVolume packets(v);
  options.step = longest / 32760;
  EXPECT_TRUE(PacketScene(packets, scene, options).in_packets());
  expect_oracle(v, scene, options);
  options.step = longest / 32770;
  EXPECT_FALSE(PacketScene(packets, scene, options).in_packets());
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

// Rays of one octant, of several (perspective, from within), and along axes: distances are asked for by
// octant.
TEST_P(PacketRule, SkippingChangesNoBitWhereverRaysGo) {
  volume::Volume v = packet_volume<std::uint8_t>(255, {61, 47, 70});
  auto& geometry = std::get<volume::Grid<std::uint8_t>>(v.grid).geometry;
  geometry.direction = Mat3::Identity();
  RenderOptions options = packet_options(GetParam());
  options.width = 31;
  options.height = 27;
  Scene scene = packet_scene(255);
  std::int64_t skipped = 0;
  for (const double azimuth : {0.0, 40.0, 90.0, 130.0, 200.0, 310.0}) {
    for (const double elevation : {-90.0, -25.0, 0.0, 50.0}) {
      for (const bool perspective : {false, true}) {
        scene.view.azimuth = azimuth;
        scene.view.elevation = elevation;
        scene.view.projection =
            perspective ? camera::Projection::perspective : camera::Projection::orthographic;
        scene.view.fov = 100;
        if (perspective) scene.view.distance = 6;
        options.skip_empty = false;
        const RenderResult all = raycast_packet(v, scene, options);
        options.skip_empty = true;
        const RenderResult skipping = raycast_packet(v, scene, options);
        SCOPED_TRACE(testing::Message()
                     << azimuth << ", " << elevation << (perspective ? ", from within" : ""));
        expect_same_bits(all.image, skipping.image, false);
        EXPECT_EQ(skipping.counts.samples + skipping.counts.skipped, all.counts.samples);
        skipped += skipping.counts.skipped;
      }
    }
  }
  EXPECT_GT(skipped, 0);
}

// Colours of few pieces are looked up in registers, of as many as an instruction set's hold; others in
// tables.
TEST_P(PacketRule, AgreesForColoursOfAnyNumberOfPieces) {
  const auto v = packet_volume<std::uint8_t>(255);
  RenderOptions options = packet_options(GetParam());
  options.width = 29;
  options.height = 23;
  Rng rng(8);
  for (const int points : {3, 4, 5, 6, 9, 10, 14}) {
    Scene scene = packet_scene(255);
    std::vector<transfer::ColourPoint> colours;
    const auto colour = [&] { return Vec3(rng.uniform(), rng.uniform(), rng.uniform()); };
    for (int k = 0; k < points; ++k) {
      const double value = 20 + (k + 0.7 * rng.uniform()) * 215 / points;
      colours.push_back({value, colour()});
      if (k == points / 2) colours.push_back({value, colour()});  // a jump
    }
    scene.transfer = transfer::TransferFunction(colours, scene.transfer.opacities());
    SCOPED_TRACE(points);
    on_every_instruction_set([&] { expect_oracle(v, scene, options); });
  }
}

// The same for extinctions, up to more pieces than any instruction set holds, with ramps that take several.
// Beside the jump of opacity no sample is near enough to be rounded across it (packet.h): by the seed.
TEST_P(PacketRule, AgreesForExtinctionsOfAnyNumberOfPieces) {
  const auto v = packet_volume<std::uint8_t>(255);
  RenderOptions options = packet_options(GetParam());
  options.width = 29;
  options.height = 23;
  Rng rng(9);
  for (const int points : {1, 2, 3, 5, 8, 9, 14, 20}) {
    Scene scene = packet_scene(255);
    scene.transfer = transfer::TransferFunction(scene.transfer.colours(), packet_ramps(points, rng));
    SCOPED_TRACE(points);
    on_every_instruction_set([&] { expect_oracle(v, scene, options); });
  }
}

// These scenes have few pieces for a register, for two, and too many.
TEST(Packet, RampsAreOfEveryNumberOfPieces) {
  Rng rng(9);
  std::vector<int> found;
  for (const int points : {1, 2, 3, 5, 8, 9, 14, 20}) {
    const Optics optics(transfer::TransferFunction({{0, {1, 1, 1}}}, packet_ramps(points, rng)), 1);
    PacketTransfer table;
    ASSERT_TRUE(tabulate(optics, {0, 255}, true, 1, vol::render::PacketRule::preintegrated, table));
    found.push_back(table.ramps);
    if (table.ramps > 0) {
      EXPECT_GE(table.ramps, points);
    }
  }
  const auto some = [&](int from, int to) {
    return std::any_of(found.begin(), found.end(), [=](int n) { return n >= from && n <= to; });
  };
  EXPECT_TRUE(some(1, 4) && some(5, 8) && some(9, 16) && some(0, 0)) << testing::PrintToString(found);
}

TEST_P(PacketRule, TheLargestValueTakesTheColourAboveAJump) {
  volume::Volume v = packet_volume<std::uint8_t>(255);
  for (auto& value : std::get<volume::Grid<std::uint8_t>>(v.grid).voxels) {
    value = std::min<std::uint8_t>(value, 120);
  }
  Scene scene = packet_scene(255);
  scene.transfer = transfer::TransferFunction(
      {{0, {0.1, 0.2, 0.9}}, {120, {0.9, 0.3, 0.1}}, {120, {0, 1, 1}}}, scene.transfer.opacities());
  on_every_instruction_set([&] { expect_oracle(v, scene, packet_options(GetParam())); });
}

// A plateau just below the foot of a steep ramp, by the rounding of a float: transparent, and no line of the
// tables may say that it emits.
TEST_P(PacketRule, AgreesOnAPlateauBesideTheFootOfARamp) {
  volume::Volume v = packet_volume<float>(1);
  for (float& x : std::get<volume::Grid<float>>(v.grid).voxels) {
    if (x > 0.2F && x < 0.72F) x = 0.7F;
  }
  Scene scene = packet_scene(1);
  scene.transfer =
      transfer::TransferFunction(scene.transfer.colours(), {{0, 0}, {0.7, 0}, {0.8, 0.99}, {1, 0.99}});
  const RenderOptions options = packet_options(GetParam());
  on_every_instruction_set([&] { expect_oracle(v, scene, options); });
}

// Pieces of a colour that are as narrow as a float is coarse there.
TEST(Packet, AgreesForColoursAsSteepAsFloatsAreCoarse) {
  volume::Volume v = packet_volume<float>(1, {23, 18, 29}, 1e6);
  for (float& x : std::get<volume::Grid<float>>(v.grid).voxels) x = std::round(x * 16) / 16;
  Scene scene = packet_scene(1, 0.5, 1e6);
  const double most = 1e6 + 1;
  scene.transfer = transfer::TransferFunction(
      {{1e6, {0, 1, 0}}, {1e6 + 0.4, {0, 1, 0}}, {1e6 + 0.5, {1, 0, 0}}, {most, {1, 0, 1}}},
      scene.transfer.opacities());
  for (const Quadrature rule : {Quadrature::rectangle, Quadrature::trapezoid}) {
    RenderOptions options = packet_options(rule);
    options.reconstruction = volume::Reconstruction::nearest;
    expect_oracle(v, scene, options);
  }
}

TEST(Packet, APictureInTheMemoryOfAnotherIsTheSame) {
  const auto v = packet_volume<std::uint8_t>(255);
  const Scene scene = packet_scene(255);
  const RenderOptions options = packet_options();
  const PacketVolume prepared(v);
  const PacketScene ready(prepared, scene, options);
  const RenderResult fresh = ready.cast(scene.view);
  for (const int width : {7, options.width, 200}) {
    image::Image spare(width, options.height, {"R", "G", "B", "A", "samples", "depth"});
    std::fill(spare.pixels.begin(), spare.pixels.end(), 17.0F);
    expect_same_bits(fresh.image, ready.cast(scene.view, std::move(spare)).image, true);
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
  expect_threads_change_nothing(packet_volume<std::uint8_t>(255), packet_scene(255),
                                packet_options(GetParam()));
}

// Rays of many lengths through a constant medium, in which light is halved a fixed way behind the entry: for
// some rays in the last segment, when other lanes of their packet have nodes left.
TEST_P(PacketRule, FindsTheDepthInTheLastSegmentToo) {
  volume::Volume v = packet_volume<std::uint8_t>(255);
  auto& grid = std::get<volume::Grid<std::uint8_t>>(v.grid);
  std::fill(grid.voxels.begin(), grid.voxels.end(), std::uint8_t{200});
  Scene scene = packet_soft_scene(255);
  scene.view.projection = camera::Projection::perspective;
  for (const double opacity : {0.02, 0.05, 0.1}) {
    scene.transfer =
        transfer::TransferFunction({{0, {0, 0, 0}}, {255, {1, 1, 1}}}, {{0, opacity}, {255, opacity}});
    RenderOptions options = packet_options(GetParam());
    options.step = 0.7;
    expect_oracle(v, scene, options);
  }
}

TEST_P(PacketRule, InstructionSetsAgreeWithinTheBound) {
  const auto v = packet_volume<std::uint8_t>(255);
  const RenderOptions options = packet_options(GetParam());
  Scene scene = packet_scene(255);
  scene.shading = Shading{};
  const RenderResult best = raycast_packet(v, scene, options);
  const std::string best_set = packet_instruction_set();
  const int sets = on_every_instruction_set([&] {
    const RenderResult other = raycast_packet(v, scene, options);
    const Difference d = difference(best.image, other.image);
    EXPECT_LE(d.colour, 1.1 * packet_tolerance(100));
    EXPECT_EQ(d.samples, 0);
    EXPECT_EQ(best.counts.skipped, other.counts.skipped);
  });
  EXPECT_EQ(best_set, packet_instruction_set());
  if (sets < 2) GTEST_SKIP() << "packets were compiled for one instruction set";
}

// What PRECIS_SIMD=portable asks for: one lane, whatever the machine has.
TEST(Packet, ThePortableCodeCanBeAskedFor) {
  const std::string best = packet_instruction_set();
  const struct Restored {
    ~Restored() { limit_simd("AVX-512"); }
  } restored;
  limit_simd("portable");
  EXPECT_STREQ(simd_name(), "portable");
  EXPECT_EQ(packet_lanes(), 1);
  EXPECT_THROW(limit_simd("sse"), Error);
  limit_simd("AVX-512");
  EXPECT_EQ(packet_instruction_set(), best);
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

}  // namespace
}  // namespace vol::render
