// Splatted voxels: the field against its sum, the contour against the closed form of one ball and against
// dense samples.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/rng.h"
#include "render/splat_rays.h"
#include "render/surfaces.h"

namespace vol::render {
namespace {

static_assert(volume::FieldSampler<volume::SplatField>);

/// Odd dims, spacings that differ, axes turned against the world's.
volume::Grid<std::uint8_t> random_labels(std::uint64_t seed, double filled) {
  volume::GridGeometry g;
  g.dims = {9, 6, 7};
  g.spacing = {0.5, 1.25, 0.75};
  g.origin = {-3, 7, 2};
  g.direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  volume::Volume volume = volume::allocate(volume::VoxelType::u8, g);
  auto& grid = std::get<volume::Grid<std::uint8_t>>(volume.grid);
  Rng rng(seed);
  for (auto& v : grid.voxels)
    v = static_cast<std::uint8_t>(rng.uniform() < filled ? 1 + 2 * rng.uniform() : 0);
  return grid;
}

const std::vector<bool> kChosen{false, true, true};
const std::vector<LabelLook> kLooks{{}, {Vec3(1, 0, 0), 1}, {Vec3(0, 0, 1), 1}};

Vec3 random_point(Rng& rng, const volume::FieldBounds& b, double around = 0) {
  const auto u = [&] { return rng.uniform(-around, 1 + around); };
  return b.corner + b.edges * Vec3(u(), u(), u());
}

double sum_at(const volume::Grid<std::uint8_t>& labels, const Vec3& p, double support) {
  double sum = 0;
  const auto [nx, ny, nz] = labels.dims();
  for (std::int64_t k = 0; k < nz; ++k) {
    for (std::int64_t j = 0; j < ny; ++j) {
      for (std::int64_t i = 0; i < nx; ++i) {
        if (labels(i, j, k) == 0) continue;
        const Vec3 x = labels.geometry.index_to_world(Vec3(double(i), double(j), double(k)));
        sum += std::pow(std::max(0.0, 1 - (p - x).squaredNorm() / (support * support)), 3);
      }
    }
  }
  return sum;
}

TEST(SplatField, IsItsSum) {
  for (const double support : {0.4, 1.3, 3.1}) {
    const auto labels = random_labels(1, 0.4);
    const volume::SplatField field(labels, kChosen, {support});
    Rng rng(2);
    double most = 0;
    for (int n = 0; n < 300; ++n) {
      const Vec3 p = random_point(rng, field.bounds(), 0.1);
      const double truth = sum_at(labels, p, support);
      most = std::max(most, truth);
      EXPECT_NEAR(field.value(p), truth, 1e-13 * std::max(1.0, truth));  // a few hundred terms of 1e-16
      std::array<double, 256> shares;
      field.shares(p, shares);
      EXPECT_NEAR(shares[1] + shares[2], truth, 1e-13 * std::max(1.0, truth));
      // Central differences of a function with third derivatives of 120 / support^3 at most, a splat.
      const double h = 1e-4 * support;
      const Vec3 gradient = field.gradient(p);
      for (int a = 0; a < 3; ++a) {
        const double slope =
            (field.value(p + h * Vec3::Unit(a)) - field.value(p - h * Vec3::Unit(a))) / (2 * h);
        EXPECT_NEAR(gradient[a], slope, 1e-6 * (1 + truth) / support);
      }
    }
    EXPECT_GT(most, 0.1);
  }
}

// One splat: (1 - r^2/R^2)^3 = threshold is the sphere of radius R sqrt(1 - threshold^(1/3)).
TEST(SplatRays, OneVoxelIsASphere) {
  auto labels = random_labels(1, 0);
  labels(4, 2, 5) = 2;
  const Vec3 centre = labels.geometry.index_to_world(Vec3(4, 2, 5));
  constexpr double kSupport = 1.7, kThreshold = 0.4;
  const double radius = kSupport * std::sqrt(1 - std::cbrt(kThreshold));
  const SplatRays rays(volume::SplatField(labels, kChosen, {kSupport}), kLooks, kThreshold);
  Rng rng(4);
  int hits = 0;
  for (int n = 0; n < 400; ++n) {
    const Vec3 through =
        centre + 1.2 * radius * Vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    const Vec3 d = Vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)).normalized();
    const camera::Ray ray{through - 20 * d, d};
    const double along = (centre - ray.origin).dot(d);
    const double distance2 = (centre - ray.origin - along * d).squaredNorm();
    bool undecided = false;
    const auto hit = rays.first_hit(ray, 0, &undecided);
    ASSERT_EQ(hit.has_value(), distance2 < radius * radius);
    EXPECT_FALSE(undecided);  // none is tangent: that takes roots within 2^-46 of a piece of each other
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->t, along - std::sqrt(radius * radius - distance2), 1e-11);  // t of 20, steep to grazing
    EXPECT_NEAR((hit->normal - (hit->position - centre) / radius).norm(), 0, 1e-10);
    EXPECT_NEAR((hit->colour - Vec3(0, 0, 1)).norm(), 0, 1e-15);
    // From its centre the first change of side is where the ray leaves.
    const auto out = rays.first_hit({centre, d}, 0);
    ASSERT_TRUE(out.has_value());
    EXPECT_NEAR(out->t, radius, 1e-12);
  }
  EXPECT_GT(hits, 100);
}

// No sample of the ray is inside before the hit, the next one is, and the field takes the threshold there.
TEST(SplatRays, FirstHitIsTheFirst) {
  for (const double filled : {0.02, 0.3, 1.0}) {
    for (const double support : {0.6, 1.4, 2.6, 3.9}) {
      for (const double threshold : {0.05, 0.5, 1.6, 12.0}) {
        const auto labels = random_labels(7, filled);
        const volume::SplatField field(labels, kChosen, {support});
        const SplatRays rays(field, kLooks, threshold);
        Rng rng(9);
        for (int n = 0; n < 40; ++n) {
          const Vec3 from = random_point(rng, field.bounds(), 1.5), to = random_point(rng, field.bounds());
          const camera::Ray ray{from, (to - from).normalized()};
          const bool inside = field.value(from) >= threshold;
          const auto hit = rays.first_hit(ray, 0);
          if (hit) {
            EXPECT_NEAR(field.value(hit->position), threshold, 1e-9 * static_cast<double>(1 + field.count()));
          }
          constexpr int kSamples = 1500;
          const double length = 2 * (to - from).norm();
          for (int s = 0; s <= kSamples; ++s) {
            const double t = s * length / kSamples;
            if (hit && t >= hit->t) break;
            const double f = field.value(ray.origin + t * ray.direction);
            if (inside) {
              ASSERT_GE(f, threshold - 1e-9) << filled << " " << support << " " << threshold << " ray " << n;
            } else {
              ASSERT_LT(f, threshold + 1e-9) << filled << " " << support << " " << threshold << " ray " << n;
            }
          }
        }
      }
    }
  }
}

// Between two splats f has a saddle; a ray that crosses it from inside, where it is the threshold itself,
// touches the contour. The numbers are halves, quarters, ...: f there is the threshold to the last bit, and
// what the Bernstein coefficients beside it are is for rounding to say.
TEST(SplatRays, ATouchIsUndecided) {
  volume::GridGeometry g;
  g.dims = {2, 1, 1};
  g.spacing = {2.75, 1, 1};
  volume::Volume volume = volume::allocate(volume::VoxelType::u8, g);
  auto& labels = std::get<volume::Grid<std::uint8_t>>(volume.grid);
  labels.voxels = {1, 1};
  constexpr double kSupport = 2, kAway = 0.375;
  const camera::Ray ray{Vec3(1.25, kAway, 0),
                        Vec3::UnitX()};  // the saddle: a quarter of a stretch further on
  const volume::SplatField field(labels, kChosen, {kSupport});
  const double saddle = field.value(Vec3(1.375, kAway, 0));
  EXPECT_EQ(saddle, 2 * std::pow(1 - (kAway * kAway + 1.375 * 1.375) / (kSupport * kSupport), 3));
  // Where one splat alone is left and has fallen to a threshold.
  const auto leaves = [&](double threshold) {
    return 1.5 + std::sqrt(kSupport * kSupport * (1 - std::cbrt(threshold)) - kAway * kAway);
  };
  Scene scene;
  scene.view.projection = camera::Projection::perspective;
  for (const double threshold : {saddle, 0.9 * saddle, 1.02 * saddle}) {
    const SplatRays rays(field, kLooks, threshold);
    bool undecided = false;
    const auto hit = rays.first_hit(ray, 0, &undecided);
    EXPECT_EQ(undecided, threshold == saddle);
    ASSERT_TRUE(hit.has_value());
    if (threshold <= saddle) {
      EXPECT_NEAR(hit->t, leaves(threshold), 1e-13);
    } else {
      EXPECT_TRUE(hit->t > 0 && hit->t < 0.125) << hit->t;
    }
    Surfaces surfaces(scene);
    surfaces.add(rays);
    std::vector<SurfaceHit> hits;
    RenderCounts counts;
    surfaces.find(ray, nullptr, hits, counts);
    EXPECT_EQ(counts.surface_undecided, undecided ? 1 : 0);
    EXPECT_EQ(counts.surface_hits, 1);
  }
}

TEST(SplatRays, NothingAndRefusals) {
  const auto labels = random_labels(1, 0.5);
  const SplatRays none(volume::SplatField(labels, {false, false, false, true}, {1}), kLooks, 0.5);
  EXPECT_EQ(none.field().count(), 0);
  EXPECT_FALSE(none.first_hit({Vec3::Zero(), Vec3::UnitX()}, 0).has_value());
  const SplatRays high(volume::SplatField(labels, kChosen, {0.4}), kLooks,
                       1.1);  // none reaches another's centre
  EXPECT_FALSE(high.first_hit({labels.geometry.centre() - 9 * Vec3::UnitX(), Vec3::UnitX()}, 0).has_value());
  EXPECT_THROW((void)volume::SplatField(labels, kChosen, {0}), Error);
  EXPECT_THROW((void)volume::SplatField(labels, kChosen, {40}), Error);  // 80 voxels along x
  EXPECT_THROW((void)SplatRays(volume::SplatField(labels, kChosen, {1}), kLooks, 0), Error);
}

}  // namespace
}  // namespace vol::render
