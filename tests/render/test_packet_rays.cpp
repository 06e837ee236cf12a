#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "instruction_sets.h"
#include "render/packet_rays.h"
#include "volume/field_sampler.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

double fixed_point(const std::int32_t (&whole)[3][kMaxLanes], const std::int32_t (&part)[3][kMaxLanes],
                   int axis, int lane) {
  return static_cast<double>((std::int64_t{whole[axis][lane]} << 31) + part[axis][lane]);
}

volume::GridGeometry random_grid(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  volume::GridGeometry g;
  for (int a = 0; a < 3; ++a) {
    g.dims[a] = 1 + static_cast<std::int64_t>(random() % 40);
    g.spacing[a] = std::exp(3 * unit(random));
    g.origin[a] = 50 * unit(random);
  }
  // A rotation, or none: views along an axis are a case of their own.
  if (random() % 2) {
    const Vec3 axis = Vec3(unit(random), unit(random), 2 + unit(random)).normalized();
    g.direction = Eigen::AngleAxisd(3 * unit(random), axis).toRotationMatrix();
  }
  return g;
}

camera::View random_view(std::mt19937& random) {
  constexpr double kAngles[] = {0, 90, -90, 30, 17.3, 45};
  camera::View view;
  view.azimuth = kAngles[random() % 6];
  view.elevation = kAngles[random() % 6];
  if (random() % 2) {
    view.projection = camera::Projection::perspective;
    view.fov = 1 + static_cast<double>(random() % 120);
  }
  return view;
}

// Both round in double, in the same order but for sums of three. A point on a ray is then known to a few
// units of 1e-16 of the world's coordinates (up to 50 + 40 e^3 = 900 here, 1e-13 in all), 2e-12 of the
// smallest spacing e^-3 or 0.004 units of 2^-31: what is rounded down comes out one unit apart at most. A
// chord's end is such a point over the direction's slope across its face: 1e-13 over 1e-2 at least, but for
// rays that graze a face within half a degree, of which the fixed draw has none. Directions and remainders
// are compared as floats, 6e-8 and, for differences of numbers up to 1100 steps at 1e-15 each, 1e-6. Numbers
// of segments differ only for a chord within 1e-12 of a whole number of steps, and faces are hit only where a
// pixel's centre lies in one: neither happens in the fixed draw, whose pictures have odd sides.
TEST(PacketRays, AreTheOraclesOneByOne) {
  std::mt19937 random(20);
  int hits = 0;
  for (int round = 0; round < 2000; ++round) {
    const volume::GridGeometry grid = random_grid(random);
    const volume::FieldBounds bounds = volume::field_bounds(grid);
    const RayBox box(bounds);
    const camera::View view = random_view(random);
    const camera::Camera camera(view, bounds.centre(), bounds.longest_edge(), 37, 23);
    const double step = bounds.longest_edge() * std::exp(-static_cast<double>(random() % 7));
    const PacketRayMaker maker(grid, box, camera, step, nullptr);
    on_every_instruction_set([&] {
      std::mt19937 pixels(round);
      std::vector<PixelPosition> some(1 + pixels() % static_cast<unsigned>(packet_lanes()));
      for (PixelPosition& p : some)
        p = {static_cast<std::int32_t>(pixels() % 37), static_cast<std::int32_t>(pixels() % 23)};
      PacketRays fast{}, plain{};
      PacketChords fast_chords{}, plain_chords{};
      maker.make(some, fast, fast_chords);
      maker.make_plain(some, plain, plain_chords);
      for (int lane = 0; lane < packet_lanes(); ++lane) {
        ASSERT_EQ(fast.segments[lane], plain.segments[lane]) << lane;
        EXPECT_NEAR(fast.remainder[lane], plain.remainder[lane], 1e-6 * (1 + plain.remainder[lane]));
        for (int a = 0; a < 3; ++a) {
          EXPECT_NEAR(fast.direction[a][lane], plain.direction[a][lane], 1e-7);
          EXPECT_NEAR(fixed_point(fast.entry_whole, fast.entry_part, a, lane),
                      fixed_point(plain.entry_whole, plain.entry_part, a, lane), 1);
          EXPECT_NEAR(fixed_point(fast.exit_whole, fast.exit_part, a, lane),
                      fixed_point(plain.exit_whole, plain.exit_part, a, lane), 1);
          const double longest = std::abs(fixed_point(plain.step_whole, plain.step_part, a, lane));
          EXPECT_NEAR(fixed_point(fast.step_whole, fast.step_part, a, lane),
                      fixed_point(plain.step_whole, plain.step_part, a, lane), 1 + 1e-15 * longest);
        }
        if (plain.segments[lane] == 0) continue;
        ++hits;
        const double rounding = 1e-11 * (1 + std::abs(plain_chords.exit[lane]));
        EXPECT_NEAR(fast_chords.entry[lane], plain_chords.entry[lane], rounding);
        EXPECT_NEAR(fast_chords.exit[lane], plain_chords.exit[lane], rounding);
      }
    });
  }
  EXPECT_GT(hits, 200);  // of 2000 rays where packets have one lane, a fifth meets the box
}

/// Every lattice node of every ray lies between the first and the last sample, exactly.
TEST(PacketRays, NeverLeaveTheBox) {
  std::mt19937 random(21);
  for (int round = 0; round < 300; ++round) {
    const volume::GridGeometry grid = random_grid(random);
    const volume::FieldBounds bounds = volume::field_bounds(grid);
    const RayBox box(bounds);
    const camera::Camera camera(random_view(random), bounds.centre(), bounds.longest_edge(), 16, 16);
    const PacketRayMaker maker(grid, box, camera, bounds.longest_edge() / 50, nullptr);
    for (std::int32_t y = 0; y < 16; ++y) {
      for (std::int32_t x = 0; x < 16; x += packet_lanes()) {
        std::vector<PixelPosition> row;
        for (std::int32_t i = x; i < std::min(16, x + packet_lanes()); ++i) row.push_back({i, y});
        PacketRays rays{};
        PacketChords chords{};
        maker.make(row, rays, chords);
        for (int lane = 0; lane < static_cast<int>(row.size()); ++lane) {
          if (rays.segments[lane] == 0) continue;
          for (int a = 0; a < 3; ++a) {
            const double top = static_cast<double>(grid.dims[a] - 1) * 2147483648.0;
            const double entry = fixed_point(rays.entry_whole, rays.entry_part, a, lane);
            const double last =
                entry + (rays.segments[lane] - 1) * fixed_point(rays.step_whole, rays.step_part, a, lane);
            for (const double node : {entry, last, fixed_point(rays.exit_whole, rays.exit_part, a, lane)}) {
              EXPECT_GE(node, 0);
              EXPECT_TRUE(node < top || (grid.dims[a] == 1 && node == 0)) << node << " of " << top;
            }
          }
        }
      }
    }
  }
}

/// Axes too long for doubles to hold their sums exactly go one by one, and draw the same.
TEST(PacketRays, AxesOfAnyLength) {
  for (const std::int64_t n : {std::int64_t{1} << 21, (std::int64_t{1} << 21) + 1}) {
    volume::GridGeometry grid;
    grid.dims = {n, 2, 3};
    const volume::FieldBounds bounds = volume::field_bounds(grid);
    const RayBox box(bounds);
    camera::View view;
    view.azimuth = 89.99;
    view.width = 4;
    const camera::Camera camera(view, bounds.centre(), bounds.longest_edge(), 8, 8);
    const PacketRayMaker maker(grid, box, camera, 200, nullptr);
    std::vector<PixelPosition> row;
    for (std::int32_t x = 0; x < std::min(8, packet_lanes()); ++x) row.push_back({x, 4});
    PacketRays fast{}, plain{};
    PacketChords chords{};
    maker.make(row, fast, chords);
    maker.make_plain(row, plain, chords);
    for (int lane = 0; lane < packet_lanes(); ++lane) {
      EXPECT_EQ(fast.segments[lane], plain.segments[lane]);
      // Coordinates of 2e6 voxels are doubles 5e-10 apart, 1 unit of 2^-31, and a sum of three takes four
      // roundings.
      EXPECT_NEAR(fixed_point(fast.exit_whole, fast.exit_part, 0, lane),
                  fixed_point(plain.exit_whole, plain.exit_part, 0, lane), 4);
    }
    EXPECT_GT(plain.segments[0], 0);
  }
}

}  // namespace
}  // namespace vol::render
