#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "isosurface/marching_cubes.h"
#include "isosurface_oracle.h"
#include "render/grid_field.h"
#include "render/isosurface_rays.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

/// The usual way: signs at steps of half a voxel.
std::optional<double> sign_test(const FieldView& field, const camera::Ray& ray, const Chord& chord,
                                double isovalue) {
  const double step = 0.35;  // half the smallest spacing
  bool inside = field.value(ray.origin + chord.entry * ray.direction) >= isovalue;
  for (double t = chord.entry + step;; t += step) {
    const double at = std::min(t, chord.exit);
    if ((field.value(ray.origin + at * ray.direction) >= isovalue) != inside) return at;
    if (at >= chord.exit) return std::nullopt;
  }
}

struct Tally {
  std::int64_t rays = 0, unjudged = 0, hits = 0, missed = 0, invented = 0, misplaced = 0,
               sign_test_missed = 0;
};

// No hit missed, none invented, depth to 1e-6 voxel: the cubic's Bernstein coefficients are off by some 1e-16
// and its slope at a hit that is judged may be as low as 1e-6 (an extremum 1e-12 away), so that t is good to
// 1e-9.
TEST(IsosurfaceRays, MeetWhatTheExactCubicMeets) {
  const char* text = std::getenv("PRECIS_TEST_RAYS");
  const std::int64_t rays = text != nullptr ? std::atoll(text) : 40000;
  constexpr std::int64_t kAVolume = 1000;
  const Tally tally = parallel_reduce<Tally>(
      0, rays / kAVolume, 1,
      [&](std::int64_t begin, std::int64_t end) {
        Tally part;
        for (std::int64_t n = begin; n < end; ++n) {
          Rng rng(static_cast<std::uint64_t>(7000 + n));
          // Every eighth with many macrocells, most of them empty.
          const bool sparse = n % 8 == 0;
          const volume::Volume volume =
              sparse ? random_volume(rng, {21, 18, 19}, 0.002) : random_volume(rng, {5, 4, 6});
          const auto& grid = std::get<volume::Grid<float>>(volume.grid);
          const double isovalue = rng.uniform(0.1, 0.7);
          const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, isovalue, false);
          const GridField field(volume, volume::Reconstruction::trilinear);
          const RayBox box(surface.bounds());
          IsosurfaceRays::Counts counts;
          for (int r = 0; r < kAVolume; ++r) {
            const camera::Ray ray = random_ray(rng, surface.bounds());
            const auto chord = box.chord(ray, 0);
            if (!chord) continue;
            ++part.rays;
            const Truth truth = exact_first_hit(grid, ray, *chord, isovalue);
            const auto hit = surface.first_hit(ray, *chord, counts);
            if (!truth.judged) {
              ++part.unjudged;
              continue;
            }
            part.hits += truth.t.has_value();
            part.missed += truth.t && !hit;
            part.invented += hit && !truth.t;
            part.misplaced += hit && truth.t && !(std::abs(hit->t - *truth.t) < 0.7e-6);
            const auto stepped = sign_test(field.view(), ray, *chord, isovalue);
            part.sign_test_missed += truth.t && !(stepped && *stepped <= *truth.t + 0.35 + 1e-9);
          }
        }
        return part;
      },
      [](Tally& sum, const Tally& part) {
        sum.rays += part.rays;
        sum.unjudged += part.unjudged;
        sum.hits += part.hits;
        sum.missed += part.missed;
        sum.invented += part.invented;
        sum.misplaced += part.misplaced;
        sum.sign_test_missed += part.sign_test_missed;
      });
  std::printf(
      "rays %lld, hits %lld, not judged %lld; missed %lld, invented %lld, misplaced %lld; half-voxel sign "
      "test missed %lld\n",
      static_cast<long long>(tally.rays), static_cast<long long>(tally.hits),
      static_cast<long long>(tally.unjudged), static_cast<long long>(tally.missed),
      static_cast<long long>(tally.invented), static_cast<long long>(tally.misplaced),
      static_cast<long long>(tally.sign_test_missed));
  EXPECT_EQ(tally.missed, 0);
  EXPECT_EQ(tally.invented, 0);
  EXPECT_EQ(tally.misplaced, 0);
  EXPECT_GT(tally.hits, tally.rays / 3);
  EXPECT_LT(tally.unjudged, tally.rays / 1000);
  EXPECT_GT(tally.sign_test_missed, 0);  // or the rays are too easy
}

// The cubics' degree 9: no sign changes on a dense scan before the hit, and the value there is the isovalue.
// The field's slope is below 20 a voxel here, the hit good to 1e-14 of a cell, the spline's sums to 1e-14.
TEST(IsosurfaceRays, CubicsHitBeforeAnyChangeOfSign) {
  for (const auto kernel : {volume::Reconstruction::catmull_rom, volume::Reconstruction::b_spline}) {
    Rng rng(91);
    int hits = 0;
    for (int n = 0; n < 10; ++n) {
      const volume::Volume volume = random_volume(rng, {9, 8, 10});
      const double isovalue = rng.uniform(0.2, 0.8);
      const IsosurfaceRays surface(volume, kernel, isovalue, false);
      const GridField field(volume, kernel);
      const RayBox box(surface.bounds());
      IsosurfaceRays::Counts counts;
      for (int r = 0; r < 60; ++r) {
        const camera::Ray ray = random_ray(rng, surface.bounds());
        const auto chord = box.chord(ray, 0);
        if (!chord) continue;
        const auto hit = surface.first_hit(ray, *chord, counts);
        const double end = hit ? hit->t - 1e-6 : chord->exit;
        const auto value = [&](double t) { return field.view().value(ray.origin + t * ray.direction); };
        const bool inside = value(chord->entry) >= isovalue;
        constexpr int kScan = 3000;
        for (int i = 0; i <= kScan; ++i) {
          const double t = chord->entry + (end - chord->entry) * i / kScan;
          ASSERT_EQ(value(t) >= isovalue, inside) << "ray " << r << " at " << t;
        }
        if (!hit) continue;
        ++hits;
        EXPECT_NEAR(value(hit->t), isovalue, 1e-11);
        // Differences of the field, against the normal: errors of h^2 and 1e-15 / h.
        constexpr double h = 1e-5;
        Vec3 gradient;
        for (int a = 0; a < 3; ++a) {
          const Vec3 step = h * Vec3::Unit(a);
          gradient[a] =
              (field.view().value(hit->position + step) - field.view().value(hit->position - step)) / (2 * h);
        }
        // Second derivatives jump between Catmull-Rom's cells: errors of h.
        if (gradient.norm() > 0.05) {
          EXPECT_LT((hit->normal + gradient.normalized()).norm(), 5e-3);
        }
      }
    }
    EXPECT_GT(hits, 100);
  }
}

/// First hit of a ray with a mesh, every triangle tried (Moeller & Trumbore 1997); the triangle's number.
std::optional<std::pair<double, std::size_t>> mesh_hit(const mesh::TriangleMesh& mesh,
                                                       const camera::Ray& ray) {
  std::optional<std::pair<double, std::size_t>> first;
  const auto at = [&](std::uint32_t v) { return Vec3(Eigen::Map<const Vec3>(mesh.positions[v].data())); };
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    const Vec3 a = at(mesh.triangles[n][0]);
    const Vec3 e1 = at(mesh.triangles[n][1]) - a;
    const Vec3 e2 = at(mesh.triangles[n][2]) - a;
    const Vec3 p = ray.direction.cross(e2);
    const double det = e1.dot(p);
    if (det == 0) continue;
    const Vec3 s = ray.origin - a;
    const double u = s.dot(p) / det;
    const Vec3 q = s.cross(e1);
    const double v = ray.direction.dot(q) / det;
    const double t = e2.dot(q) / det;
    if (u < 0 || v < 0 || u + v > 1 || t < 0) continue;
    if (!first || t < first->first) first = {t, n};
  }
  return first;
}

// A surface by rays and its mesh by rays: as far apart, across the surface, as the mesh's chords are from the
// surface, measured on the triangles themselves; a quarter more, for what the sampling of 15 points a
// triangle misses. Rays that meet one but not the other, or another sheet, graze.
TEST(IsosurfaceRays, AgreeWithTheMeshToItsChordError) {
  volume::Grid<double> grid;
  grid.geometry.dims = {17, 19, 18};
  grid.geometry.spacing = {1, 0.9, 0.95};
  grid.voxels = Buffer<double>(static_cast<std::size_t>(grid.geometry.count()));
  const Vec3 centre(8.1, 8.2, 8.05);
  for (std::int64_t k = 0; k < 18; ++k) {
    for (std::int64_t j = 0; j < 19; ++j) {
      for (std::int64_t i = 0; i < 17; ++i) {
        const Vec3 p = grid.geometry.index_to_world(Vec3(double(i), double(j), double(k))) - centre;
        grid(i, j, k) = 2.1 - std::hypot(std::hypot(p[0], p[1]) - 4.6, p[2]);  // a torus
      }
    }
  }
  volume::Volume volume;
  volume.grid = std::move(grid);
  const auto mesh = isosurface::marching_cubes(volume, 0).mesh;
  const GridField field(volume, volume::Reconstruction::trilinear);
  double chord_error = 0;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i <= 4; ++i) {
      for (int j = 0; i + j <= 4; ++j) {
        const double w[3] = {i / 4.0, j / 4.0, (4 - i - j) / 4.0};
        Vec3 p = Vec3::Zero();
        for (std::size_t c = 0; c < 3; ++c) p += w[c] * Eigen::Map<const Vec3>(mesh.positions[t[c]].data());
        // The distance function's slope is 1, the trilinear field's nearly.
        chord_error =
            std::max(chord_error, std::abs(field.view().value(p)) / field.view().gradient(p).norm());
      }
    }
  }
  const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, 0, false);
  const RayBox box(surface.bounds());
  Rng rng(95);
  IsosurfaceRays::Counts counts;
  int both = 0;
  int apart = 0;
  for (int n = 0; n < 1500; ++n) {
    const camera::Ray ray = random_ray(rng, surface.bounds());
    const auto chord = box.chord(ray, 0);
    if (!chord) continue;
    const auto hit = surface.first_hit(ray, *chord, counts);
    const auto other = mesh_hit(mesh, ray);
    if (hit.has_value() != other.has_value() || (hit && std::abs(hit->t - other->first) > 1)) {
      ++apart;
      continue;
    }
    if (!hit) continue;
    const double slope = std::abs(hit->normal.dot(ray.direction));
    if (slope < 0.2) continue;  // grazing: both surfaces bend away under the ray
    ++both;
    EXPECT_LE(std::abs(hit->t - other->first) * slope, 1.25 * chord_error) << "ray " << n;
  }
  EXPECT_GT(both, 400);
  EXPECT_LT(apart, 15);
  EXPECT_LT(chord_error, 0.2);
}

// Two roots 1e-6 of the interval apart, anywhere in it.
TEST(FirstCrossing, PairsOfRootsAreNotSkipped) {
  Rng rng(92);
  for (int n = 0; n < 2000; ++n) {
    const double root = rng.uniform(0.05, 0.95);
    const double gap = 1e-6;
    // (u - r)(u - r - gap)(u + 1), by its blossom: b_k = mean over which factors are taken at 1.
    const double at0[3] = {-root, -root - gap, 1};
    const double at1[3] = {1 - root, 1 - root - gap, 2};
    Bernstein p;
    p.degree = 3;
    p.b[0] = at0[0] * at0[1] * at0[2];
    p.b[1] = (at1[0] * at0[1] * at0[2] + at0[0] * at1[1] * at0[2] + at0[0] * at0[1] * at1[2]) / 3;
    p.b[2] = (at1[0] * at1[1] * at0[2] + at1[0] * at0[1] * at1[2] + at0[0] * at1[1] * at1[2]) / 3;
    p.b[3] = at1[0] * at1[1] * at1[2];
    const auto u = first_crossing(p, 0);
    ASSERT_TRUE(u.has_value()) << root;
    // The dip is 2.5e-13 deep: rounding of 1e-16 moves its side by about 1e-16 / 1e-6.
    EXPECT_NEAR(*u, root, 1e-8);
  }
}

TEST(FirstCrossing, TiesAreInside) {
  Bernstein p;
  p.degree = 1;
  p.b = {0, 1};
  EXPECT_FALSE(first_crossing(p, 0).has_value());  // at least 0 throughout
  p.b = {-1, 0};
  EXPECT_NEAR(first_crossing(p, 0).value(), 1, 1e-14);
  p.b = {0, -1};
  EXPECT_NEAR(first_crossing(p, 0).value(), 0, 1e-14);
}

// A closed volume all inside is its box, with the box's normals.
TEST(IsosurfaceRays, ClosedBorderIsSurface) {
  Rng rng(93);
  volume::Volume volume = random_volume(rng, {4, 5, 6});
  const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, -2, true);
  const IsosurfaceRays open(volume, volume::Reconstruction::trilinear, -2, false);
  const RayBox box(surface.bounds());
  IsosurfaceRays::Counts counts;
  for (int n = 0; n < 100; ++n) {
    const camera::Ray ray = random_ray(rng, surface.bounds());
    const auto chord = box.chord(ray, 0);
    ASSERT_TRUE(chord);
    const auto hit = surface.first_hit(ray, *chord, counts);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->t, chord->entry);
    EXPECT_LT(hit->normal.dot(ray.direction), 0);
    EXPECT_FALSE(open.first_hit(ray, *chord, counts));
  }
  EXPECT_THROW(IsosurfaceRays(volume, volume::Reconstruction::nearest, 0, false), Error);
  EXPECT_THROW(IsosurfaceRays(volume, volume::Reconstruction::trilinear, std::nan(""), false), Error);
}

}  // namespace
}  // namespace vol::render
