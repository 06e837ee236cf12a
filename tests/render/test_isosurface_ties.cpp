#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "isosurface_oracle.h"

// Samples equal to the isovalue, closed borders, and eyes within.
namespace vol::render {
namespace {

volume::Volume constant(float value, bool eight_bits, const Dims& dims) {
  Rng rng(96);
  volume::Volume volume = random_volume(rng, dims);
  auto& grid = std::get<volume::Grid<float>>(volume.grid);
  std::fill(grid.voxels.begin(), grid.voxels.end(), value);
  if (!eight_bits) return volume;
  volume::Grid<std::uint8_t> bytes;
  bytes.geometry = grid.geometry;
  bytes.voxels = Buffer<std::uint8_t>(grid.voxels.size());
  std::fill(bytes.voxels.begin(), bytes.voxels.end(), static_cast<std::uint8_t>(value));
  volume::Volume other;
  other.grid = std::move(bytes);
  return other;
}

// All samples equal the isovalue: all is inside. Closed it is its box, open it has no surface.
TEST(IsosurfaceRays, ConstantsAtTheIsovalueAreInside) {
  for (const auto kernel : {volume::Reconstruction::trilinear, volume::Reconstruction::catmull_rom,
                            volume::Reconstruction::b_spline}) {
    for (const float value : {7.0F, 13.0F, 255.0F, 0.1F, 0.0F}) {
      const volume::Volume volume = constant(value, value >= 1, {11, 9, 10});
      const IsosurfaceRays closed(volume, kernel, double{value}, true);
      const IsosurfaceRays open(volume, kernel, double{value}, false);
      const RayBox box(closed.bounds());
      Rng rng(97);
      IsosurfaceRays::Counts counts;
      for (int n = 0; n < 300; ++n) {
        const camera::Ray ray = random_ray(rng, closed.bounds());
        const auto chord = box.chord(ray, 0);
        ASSERT_TRUE(chord);
        const auto hit = closed.first_hit(ray, *chord, counts);
        ASSERT_TRUE(hit) << value << ", ray " << n;
        EXPECT_EQ(hit->t, chord->entry);
        EXPECT_FALSE(open.first_hit(ray, *chord, counts)) << value << ", ray " << n;
      }
    }
  }
}

// Integers, the isovalue one of them: plateaus, faces and edges at the isovalue everywhere. On grids with
// mirrored axes and axes of one sample, from outside and from within, open and closed. Normals where the
// gradient is not 0 are the oracle's: of the cell that the oracle finds the crossing in, or, where a
// crossing lies on a plane of samples, perhaps the next one's.
TEST(IsosurfaceRays, MeetIntegersAtTheIsovalue) {
  std::int64_t rays = 0, judged = 0, hits = 0, wrong = 0, misplaced = 0, zero = 0, inward = 0, off = 0,
               within = 0;
  for (int n = 0; n < 60; ++n) {
    Rng rng(static_cast<std::uint64_t>(9000 + n));
    Dims dims{7, 5, 6};
    if (n % 4 == 3) dims[static_cast<std::size_t>(rng.below(3))] = 1;
    volume::Volume volume = random_volume(rng, dims);
    auto& grid = std::get<volume::Grid<float>>(volume.grid);
    const int most = n % 3 == 0 ? 1 : 3;
    for (float& v : grid.voxels) v = static_cast<float>(rng.below(static_cast<std::uint64_t>(most + 1)));
    if (n % 2 == 1) grid.geometry.direction.col(static_cast<Eigen::Index>(rng.below(3))) *= -1;
    const double isovalue = 1 + static_cast<double>(rng.below(static_cast<std::uint64_t>(most)));
    const bool close = n % 5 < 2;
    const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, isovalue, close);
    const RayBox box(surface.bounds());
    IsosurfaceRays::Counts counts;
    for (int r = 0; r < 400; ++r) {
      camera::Ray ray = random_ray(rng, surface.bounds());
      const bool eye_within = r % 4 == 0;
      if (eye_within) {
        const Vec3 u(rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95));
        ray.origin = surface.bounds().corner + surface.bounds().edges * u;
      }
      const auto chord = box.chord(ray, 0);
      if (!chord) continue;
      ++rays;
      const Truth truth = exact_first_hit(grid, ray, *chord, isovalue);
      const auto hit = surface.first_hit(ray, *chord, counts);
      if (!truth.judged) continue;
      ++judged;
      within += eye_within;
      std::optional<double> expected = truth.t;
      bool border = false;
      if (close && truth.starts_inside && !eye_within) {
        expected = chord->entry;
        border = true;
      } else if (close && truth.starts_inside && !expected) {
        expected = chord->exit;
        border = true;
      }
      wrong += expected.has_value() != hit.has_value();
      if (!expected || !hit) continue;
      ++hits;
      misplaced += !(std::abs(*expected - hit->t) < 1e-6);
      zero += !(std::abs(hit->normal.norm() - 1) < 1e-12);
      // The first hit of a ray from outside faces it, that of one from inside does not.
      const bool from_inside = truth.starts_inside && !(border && !eye_within);
      inward += (hit->normal.dot(ray.direction) > 1e-9) != from_inside &&
                std::abs(hit->normal.dot(ray.direction)) > 1e-9;
      if (border || truth.gradient.norm() < 1e-3) continue;
      const Vec3 normal = -(grid.geometry.world_to_index_matrix().transpose() * truth.gradient).normalized();
      off += !((hit->normal - normal).norm() < 1e-6);
    }
  }
  std::printf(
      "rays %lld, judged %lld, hits %lld: wrong %lld, misplaced %lld, zero normals %lld, inward %lld, off "
      "%lld\n",
      static_cast<long long>(rays), static_cast<long long>(judged), static_cast<long long>(hits),
      static_cast<long long>(wrong), static_cast<long long>(misplaced), static_cast<long long>(zero),
      static_cast<long long>(inward), static_cast<long long>(off));
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(misplaced, 0);
  EXPECT_EQ(zero, 0);
  EXPECT_EQ(inward, 0);
  EXPECT_EQ(off, 0);
  EXPECT_GT(judged, rays * 9 / 10);
  EXPECT_GT(within, 1000);
  EXPECT_GT(hits, rays / 3);
}

// A block of the maximum in zeros, seen along all six axis directions: the faces lie on planes of samples,
// and their normals are the faces'.
TEST(IsosurfaceRays, MasksAtTheirMaximumHaveNormals) {
  volume::Grid<std::uint8_t> mask;
  mask.geometry.dims = {12, 11, 13};
  mask.geometry.spacing = {0.5, 1, 2};
  mask.voxels = Buffer<std::uint8_t>(static_cast<std::size_t>(mask.geometry.count()));
  std::fill(mask.voxels.begin(), mask.voxels.end(), std::uint8_t{0});
  for (std::int64_t k = 3; k < 9; ++k) {
    for (std::int64_t j = 3; j < 8; ++j) {
      for (std::int64_t i = 3; i < 8; ++i) mask(i, j, k) = 255;
    }
  }
  volume::Volume volume;
  volume.grid = std::move(mask);
  const auto& geometry = volume.geometry();
  for (const auto kernel : {volume::Reconstruction::trilinear, volume::Reconstruction::catmull_rom}) {
    const IsosurfaceRays surface(volume, kernel, 255, false);
    const RayBox box(surface.bounds());
    IsosurfaceRays::Counts counts;
    for (int side = 0; side < 6; ++side) {
      const int axis = side % 3;
      const Vec3 d = (side < 3 ? 1 : -1) * Vec3::Unit(axis);
      for (int n = 0; n < 25; ++n) {
        // On samples and between them, two cells from the block's edges in the case of the cubic.
        Vec3 x = 4 + 0.5 * Eigen::Array3d(n % 5, n / 5 % 5, n % 5);
        x[axis] = side < 3 ? -5 : 20;
        const camera::Ray ray{geometry.index_to_world(x), d};
        const auto chord = box.chord(ray, 0);
        ASSERT_TRUE(chord);
        const auto hit = surface.first_hit(ray, *chord, counts);
        ASSERT_TRUE(hit) << side << " " << n;
        EXPECT_NEAR(hit->normal.norm(), 1, 1e-12) << side << " " << n;
        EXPECT_LT(hit->normal.dot(d), 0) << side << " " << n;
        if (kernel == volume::Reconstruction::trilinear) {
          EXPECT_NEAR(hit->normal.dot(d), -1, 1e-12) << side << " " << n;
        }
      }
    }
  }
}

// The eye within a closed volume that is all inside sees its border from within, where the chord ends.
TEST(IsosurfaceRays, AClosedBorderFromWithin) {
  const volume::Volume volume = constant(7, true, {6, 5, 7});
  const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, 7, true);
  const RayBox box(surface.bounds());
  Rng rng(98);
  IsosurfaceRays::Counts counts;
  for (int n = 0; n < 100; ++n) {
    camera::Ray ray = random_ray(rng, surface.bounds());
    ray.origin = surface.bounds().centre();
    const auto chord = box.chord(ray, 0);
    ASSERT_TRUE(chord);
    const auto hit = surface.first_hit(ray, *chord, counts);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->t, chord->exit);
    EXPECT_GT(hit->normal.dot(ray.direction), 0);
  }
}

}  // namespace
}  // namespace vol::render
