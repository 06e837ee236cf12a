// The reference, and what the rules reach, against integrals in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fields.h"
#include "render/gauss.h"

namespace vol::render {
namespace {

constexpr double kTolerance = 1e-10;  // the reference's default, and the figure

RenderOptions options_with(Quadrature quadrature, double step = 0.1) {
  RenderOptions options;
  options.quadrature = quadrature;
  options.step = step;
  return options;
}

TEST(ClosedForm, ConstantMedium) {
  const FunctionField field{[](const Vec3&) { return 3.0; }, {}, generic_box()};
  for (const double opacity : {1e-12, 0.3, 0.99, 1 - 1e-12}) {
    const Scene scene = scene_of(constant_transfer(opacity));
    const double tau = -std::log1p(-opacity) / scene.reference_length * chord_length(field.box, scene);
    const double alpha = -std::expm1(-tau);
    for (const auto rule : {Quadrature::rectangle, Quadrature::trapezoid, Quadrature::preintegrated}) {
      const Pixel p = cast(plain_caster(view_of(field), scene, options_with(rule)), field.box, scene);
      EXPECT_NEAR(p.alpha / alpha, 1, 1e-12);
      EXPECT_NEAR((p.colour - alpha * Vec3(0.2, 0.5, 0.9)).norm(), 0, 1e-12 * alpha);
    }
    const Pixel p = cast(reference_caster(view_of(field), scene, {}), field.box, scene);
    EXPECT_NEAR(p.alpha, alpha, kTolerance);
    EXPECT_NEAR((p.colour - alpha * Vec3(0.2, 0.5, 0.9)).norm(), 0, kTolerance);
    EXPECT_LE(p.error, 2 * kTolerance);
  }
}

/// Along +z over [0, L]: f = z / L, a = A f, c = f. With u = 1 - A z / L, tau(z) = (L / (r A)) (1 - u + u log
/// u).
TEST(ClosedForm, RampMedium) {
  constexpr double kLength = 2.5;
  const FunctionField field{
      [](const Vec3& p) { return p[2] / kLength; }, {}, box_of(Vec3(-1, -1, 0), Vec3(2, 2, kLength))};
  for (const double top : {0.4, 0.99, 1.0}) {
    Scene scene =
        scene_of({{{0, Vec3(0, 0, 0)}, {1, Vec3(1, 1, 1)}}, {{0, 0}, {1, top}}}, 180, 0);  // along +z
    const double k = kLength / (scene.reference_length * top);
    const auto tau = [&](double f) {
      const double u = 1 - top * f;
      return k * (u > 0 ? top * f + u * std::log1p(-top * f) : 1.0);
    };
    // I = integral of c (-dT) = -T(1) + integral_0^1 T df, f the variable (by parts).
    const double integral = gauss_kronrod([&](double f) { return std::exp(-tau(f)); }, 0, 1, 1e-14);
    const double alpha = -std::expm1(-tau(1));
    const double intensity = integral - std::exp(-tau(1));
    const Pixel p = cast(reference_caster(view_of(field), scene, {}), field.box, scene);
    EXPECT_NEAR(p.alpha, alpha, kTolerance) << top;
    EXPECT_NEAR(p.colour[0], intensity, kTolerance) << top;
    // One interval of the transfer function and a linear field: preintegrated is exact at any step.
    const Pixel q = cast(plain_caster(view_of(field), scene, options_with(Quadrature::preintegrated, 0.6)),
                         field.box, scene);
    EXPECT_NEAR(q.alpha, alpha, 1e-12) << top;
    EXPECT_NEAR(q.colour[0], intensity, 1e-12) << top;
    if (tau(1) > std::log(2)) {  // depth: T = 1/2
      const camera::Camera camera(scene.view, field.box.centre(), field.box.longest_edge(), 100, 100);
      const double z = camera.ray(50.3, 49.4).origin[2] + p.depth;
      EXPECT_NEAR(tau(z / kLength), std::log(2), 1e-9);
    }
  }
}

TEST(ClosedForm, GaussianXray) {
  // Integral of exp(-|x - m|^2 / (2 s^2)) along a line at distance b from m: by the error function.
  const Vec3 m(0.3, -0.2, 0.1);
  constexpr double kS = 0.5;
  const FunctionField field{[&](const Vec3& p) { return std::exp(-(p - m).squaredNorm() / (2 * kS * kS)); },
                            {},
                            box_of(Vec3(-2, -1.5, -1), Vec3(4, 2.5, 3))};
  Scene scene = scene_of(ramp_transfer(), 33, 21);
  scene.model = Model::xray;
  const camera::Camera camera(scene.view, field.box.centre(), field.box.longest_edge(), 100, 100);
  for (const double x : {35.0, 48.0, 61.5}) {
    const camera::Ray ray = camera.ray(x, 47);
    const auto chord = RayBox(field.box).chord(ray, -1e9);
    ASSERT_TRUE(chord);
    const double foot = (m - ray.origin).dot(ray.direction);
    const double b2 = (ray.origin + foot * ray.direction - m).squaredNorm();
    const auto phi = [&](double t) { return std::erf((t - foot) / (kS * std::numbers::sqrt2)); };
    const double truth = std::exp(-b2 / (2 * kS * kS)) * kS * std::sqrt(std::numbers::pi / 2) *
                         (phi(chord->exit) - phi(chord->entry));
    EXPECT_NEAR(cast(reference_caster(view_of(field), scene, {}), field.box, scene, x, 47).colour[0], truth,
                1e-12);
  }
}

TEST(ClosedForm, OpaqueSet) {
  // Opacity 0 outside a ball, 1 inside, by a jump in the transfer function over |x - m|: the ray ends on the
  // ball.
  const Vec3 m(0.3, -0.2, 0.1);
  constexpr double kRadius = 0.6;
  const FunctionField field{[&](const Vec3& p) { return (p - m).norm(); },
                            [&](const Vec3& p) { return Vec3((p - m).normalized()); },
                            box_of(Vec3(-2, -1.5, -1), Vec3(4, 2.5, 3))};
  Scene scene = scene_of({{{0, Vec3(0, 1, 0)}, {kRadius, Vec3(1, 0.5, 0)}, {3, Vec3(1, 1, 1)}},
                          {{0, 1}, {kRadius, 1}, {kRadius, 0.2}, {3, 0.2}}},
                         33, 21);
  const camera::Camera camera(scene.view, field.box.centre(), field.box.longest_edge(), 100, 100);
  int hits = 0;
  for (const double x : {40.0, 51.0, 57.0}) {
    const camera::Ray ray = camera.ray(x, 50);
    const auto chord = RayBox(field.box).chord(ray, -1e9);
    const double foot = (m - ray.origin).dot(ray.direction);
    const double b2 = (ray.origin + foot * ray.direction - m).squaredNorm();
    if (b2 >= kRadius * kRadius) continue;
    ++hits;
    const double enter = foot - std::sqrt(kRadius * kRadius - b2);
    const double sigma = -std::log1p(-0.2) / scene.reference_length;
    const double before = std::exp(-sigma * (enter - chord->entry));
    const auto point = [&](double t) { return (ray.origin + t * ray.direction - m).norm(); };
    const double blue = gauss_kronrod(
        [&](double t) {
          const double w = (point(t) - kRadius) / (3 - kRadius);
          return w * sigma * std::exp(-sigma * (t - chord->entry));
        },
        chord->entry, enter, 1e-14);
    const Pixel p = cast(reference_caster(view_of(field), scene, {}), field.box, scene, x, 50);
    EXPECT_NEAR(p.alpha, 1, 1e-15);
    EXPECT_NEAR(p.colour[2], blue, kTolerance);
    EXPECT_NEAR(p.colour[0], (1 - before) + before,
                kTolerance);  // red is 1 outside and where the ball begins
    if (before > 0.5) {
      EXPECT_NEAR(p.depth, enter, 1e-12);
    }
  }
  EXPECT_GE(hits, 2);
}

TEST(ClosedForm, ReferenceIsTheLimitOfThePlainCaster) {
  // Richardson's extrapolation of preintegrated steps 2^-k on a grid with kinks in every cell.
  const volume::Volume volume = generic_volume();
  const auto bounds = volume::field_bounds(volume.geometry());
  for (const auto kernel : {volume::Reconstruction::trilinear, volume::Reconstruction::catmull_rom}) {
    for (const bool shaded : {false, true}) {
      Scene scene = scene_of({{{0, Vec3(0, 0, 0)}, {0.4, Vec3(1, 0.2, 0)}, {1, Vec3(0, 0.8, 1)}},
                              {{0.2, 0}, {0.5, 0.4}, {0.7, 0.05}, {1, 0.3}}});
      scene.reference_length = 2;
      if (shaded) scene.shading = Shading{};
      RenderOptions options = options_with(Quadrature::preintegrated, 1e-3);
      options.reconstruction = kernel;
      const Pixel fine = cast(plain_caster(volume, scene, options), bounds, scene);
      RenderOptions truth;
      truth.reconstruction = kernel;
      const Pixel reference = cast(reference_caster(volume, scene, truth), bounds, scene);
      // Trilinear gradients jump at cell faces: shaded, a step that straddles one is off by its length.
      EXPECT_LT(difference(fine, reference), shaded ? 2e-4 : 3e-7);
      EXPECT_LT(reference.error, 1e-9);
      EXPECT_GT(reference.alpha, 0.1);
      truth.tolerance = 1e-5;
      EXPECT_LT(difference(cast(reference_caster(volume, scene, truth), bounds, scene), reference), 1e-5);
    }
  }
}

TEST(ClosedForm, XrayAndMaximumOfGrids) {
  const volume::Volume volume = generic_volume(0.8);
  const auto bounds = volume::field_bounds(volume.geometry());
  for (const auto kernel : {volume::Reconstruction::nearest, volume::Reconstruction::trilinear,
                            volume::Reconstruction::catmull_rom, volume::Reconstruction::b_spline}) {
    Scene scene = scene_of(ramp_transfer());
    RenderOptions options = options_with(Quadrature::trapezoid, 2e-4);
    options.reconstruction = kernel;
    scene.model = Model::xray;
    const Pixel sum = cast(plain_caster(volume, scene, options), bounds, scene);
    const Pixel exact = cast(reference_caster(volume, scene, options), bounds, scene);
    // Order 2 with step 2e-4, or half a step a jump for nearest.
    EXPECT_NEAR(sum.colour[0], exact.colour[0], kernel == volume::Reconstruction::nearest ? 4e-3 : 1e-6);
    scene.model = Model::mip;
    const Pixel most = cast(plain_caster(volume, scene, options), bounds, scene);
    const Pixel truth = cast(reference_caster(volume, scene, options), bounds, scene);
    EXPECT_LE(most.colour[0], truth.colour[0] + 1e-10);
    EXPECT_NEAR(most.colour[0], truth.colour[0], 2e-3);  // nodes lie within 1e-4 of it, slopes are below 10
    if (kernel != volume::Reconstruction::nearest) {
      EXPECT_NEAR(most.depth, truth.depth, 0.05);
    }
  }
}

}  // namespace
}  // namespace vol::render
