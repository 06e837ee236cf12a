#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.h"
#include "base/parallel.h"
#include "camera/camera.h"
#include "curvilinear/cast_solids.h"
#include "curvilinear/phantom.h"

namespace vol::curvilinear {
namespace {

using Values = std::vector<std::vector<double>>;

/// The field at the points of every block.
template <class F>
Values sampled(const Grid& grid, const F& f) {
  Values values;
  for (const Block& block : grid.blocks) {
    values.emplace_back();
    for (const Vec3& p : block.points) values.back().push_back(f(p));
  }
  return values;
}

/// White light; opacity from `low` at value 0 to `high` at 1, per length 1.
render::Scene white(double low, double high) {
  render::Scene scene;
  scene.view.azimuth = 33;
  scene.view.elevation = 21;
  scene.transfer = transfer::TransferFunction({{0, Vec3::Ones()}, {1, Vec3::Ones()}}, {{0, low}, {1, high}});
  scene.reference_length = 1;
  return scene;
}

render::RenderOptions square(int pixels, double tolerance = 1e-10) {
  render::RenderOptions options;
  options.width = options.height = pixels;
  options.tolerance = tolerance;
  return options;
}

camera::Ray ray_of(const render::Scene& scene, const Grid& grid, const render::RenderOptions& options, int x,
                   int y) {
  const Box3 box = grid.bounds();
  const camera::Camera camera(scene.view, box.centre(), box.size().maxCoeff(), options.width, options.height);
  return camera.ray(x + 0.5, y + 0.5);
}

constexpr double kOpacity = 0.37;
/// Of a pixel: float channels of up to 1 are rounded by 6e-8.
constexpr double kFloat = 1e-7;

// The sheared box is an affine map, which both kinds of cells reproduce: the chord of a parallelepiped in
// closed form; perspective too, and with the eye inside.
TEST(CastSolids, ShearedBoxIsTheClosedShape) {
  const Grid grid = make_phantom("sheared-box", {4, 5, 3}, "constant", 1);
  const Values values = sampled(grid, [](const Vec3&) { return 0.5; });
  const Vec3 corner = phantom_position("sheared-box", Vec3::Zero());
  Mat3 edges;
  for (int a = 0; a < 3; ++a) edges.col(a) = phantom_position("sheared-box", Vec3::Unit(a)) - corner;
  const Mat3 inverse = edges.inverse();
  for (const auto kind : {CellKind::tricubic, CellKind::trilinear}) {
    const SolidRays rays(grid, values, kind, 1);
    for (int view = 0; view < 3; ++view) {
      render::Scene scene = white(kOpacity, kOpacity);
      if (view > 0) scene.view.projection = camera::Projection::perspective;
      if (view == 2) scene.view.distance = 0.2;
      const double t_min = view > 0 ? 0.0 : -1e9;
      const auto options = square(31);
      const auto picture = cast_solids(rays, scene, options).image;
      for (int y = 0; y < options.height; ++y) {
        for (int x = 0; x < options.width; ++x) {
          const camera::Ray ray = ray_of(scene, grid, options, x, y);
          const Vec3 o = inverse * (ray.origin - corner), d = inverse * ray.direction;
          double enter = t_min, leave = 1e9;
          for (int a = 0; a < 3; ++a) {
            enter = std::max(enter, std::min(-o[a] / d[a], (1 - o[a]) / d[a]));
            leave = std::min(leave, std::max(-o[a] / d[a], (1 - o[a]) / d[a]));
          }
          const double expected = -std::expm1(std::max(0.0, leave - enter) * std::log1p(-kOpacity));
          EXPECT_NEAR(picture.at(x, y, 0), expected, kFloat) << view << ' ' << x << ' ' << y;
        }
      }
    }
  }
}

// A linear field over an affine map: the solids reproduce both, so xray is length times the value in the
// middle, mip the larger end, composite the integral of a linear ramp of opacity, by Simpson's rule at 2000
// steps.
TEST(CastSolids, LinearFieldInAllModels) {
  const Grid grid = make_phantom("sheared-box", {4, 5, 3}, "constant", 1);
  const auto f = [](const Vec3& p) { return 0.3 + p.dot(Vec3(0.11, -0.07, 0.05)); };
  const Values values = sampled(grid, f);
  const SolidRays rays(grid, values, CellKind::tricubic, 1);
  const auto options = square(17);
  render::Scene scene = white(0.1, 0.9);
  const auto composite = cast_solids(rays, scene, options);
  scene.model = render::Model::xray;
  const auto xray = cast_solids(rays, scene, options);
  scene.model = render::Model::mip;
  const auto mip = cast_solids(rays, scene, options);
  RayScratch scratch;
  std::vector<RaySegment> segments;
  int seen = 0;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      const camera::Ray ray = ray_of(scene, grid, options, x, y);
      rays.segments(ray, -std::numeric_limits<double>::infinity(), scratch, segments);
      if (segments.empty()) {
        EXPECT_EQ(composite.image.at(x, y, 3), 0);
        EXPECT_EQ(xray.image.at(x, y, 0), 0);
        EXPECT_EQ(mip.image.at(x, y, 0), 0);
        continue;
      }
      ++seen;
      const double t0 = segments.front().t0, t1 = segments.back().t1, length = t1 - t0;
      const double f0 = f(ray.origin + t0 * ray.direction), f1 = f(ray.origin + t1 * ray.direction);
      EXPECT_NEAR(xray.image.at(x, y, 0), length * 0.5 * (f0 + f1), kFloat);
      EXPECT_NEAR(mip.image.at(x, y, 0), std::max(f0, f1), kFloat);
      constexpr int kSteps = 2000;
      double depth = 0;
      for (int n = 0; n <= kSteps; ++n) {
        const double at = f0 + (f1 - f0) * n / kSteps;
        depth += (n == 0 || n == kSteps ? 1 : n % 2 == 1 ? 4 : 2) * -std::log1p(-(0.1 + 0.8 * at));
      }
      depth *= length / kSteps / 3;
      EXPECT_NEAR(composite.image.at(x, y, 3), -std::expm1(-depth), kFloat);
    }
  }
  EXPECT_GT(seen, 40);
  EXPECT_LT(composite.error_estimate, 1e-9);
}

/// Optical depth of white(0.1, 0.9) along a chord, by Simpson's rule.
template <class F>
double optical_depth(const camera::Ray& ray, double t0, double t1, const F& f) {
  constexpr int kSteps = 2000;
  double depth = 0;
  for (int n = 0; n <= kSteps; ++n) {
    const double at = f(ray.origin + (t0 + (t1 - t0) * n / kSteps) * ray.direction);
    depth += (n == 0 || n == kSteps ? 1 : n % 2 == 1 ? 4 : 2) * -std::log1p(-(0.1 + 0.8 * at));
  }
  return depth * (t1 - t0) / kSteps / 3;
}

/// RMS of the alpha of a spherical shell with a smooth field, against the integral over the closed shape.
/// The pixels look at the inner sphere, away from where rays touch it.
double shell_error(int refinement, CellKind kind) {
  const auto f = [](const Vec3& p) {
    return 0.5 + 0.3 * std::sin(1.1 * p[0] - 0.4) * std::cos(0.9 * p[1] + 0.7 * p[2]);
  };
  const Grid grid = make_phantom(
      "spherical-shell", {2 * refinement + 1, 6 * refinement + 1, 12 * refinement + 1}, "constant", 1);
  const Values values = sampled(grid, f);
  const SolidRays rays(grid, values, kind, 1);
  render::Scene scene = white(0.1, 0.9);
  scene.view.width = 1;
  scene.view.target = Vec3::Zero();
  const auto options = square(16);
  const auto picture = cast_solids(rays, scene, options).image;
  double sum = 0;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      const camera::Ray ray = ray_of(scene, grid, options, x, y);
      const double middle = -ray.origin.dot(ray.direction);
      const double b2 = ray.origin.squaredNorm() - middle * middle;
      const double outer = std::sqrt(4 - b2), inner = std::sqrt(1 - b2);
      const double depth = optical_depth(ray, middle - outer, middle - inner, f) +
                           optical_depth(ray, middle + inner, middle + outer, f);
      const double off = picture.at(x, y, 3) + std::expm1(-depth);
      sum += off * off;
    }
  }
  return std::sqrt(sum / (options.width * options.height));
}

// Smooth field, smooth map with collapsed edges and a seam, beta = 1: the error against the closed shape
// falls with the third power of the spacing or better for tricubic solids, the second for trilinear ones.
// Orders of two successive refinements come within 0.2 of their limit.
TEST(CastSolids, OrderUnderRefinement) {
  for (const auto kind : {CellKind::tricubic, CellKind::trilinear}) {
    const double wanted = kind == CellKind::tricubic ? 3 : 2;
    const double coarse = shell_error(1, kind), middle = shell_error(2, kind), fine = shell_error(4, kind);
    RecordProperty("error_fine", std::to_string(fine));
    EXPECT_GT(std::log2(coarse / middle), wanted - 0.2) << coarse << ' ' << middle << ' ' << fine;
    EXPECT_GT(std::log2(middle / fine), wanted - 0.2) << coarse << ' ' << middle << ' ' << fine;
  }
}

// Whatever the number of threads, the same bits.
TEST(CastSolids, ThreadsChangeNothing) {
  const Grid grid = make_phantom("delta-wing", {6, 8, 9}, "marschner-lobb", 1);
  const Values values{grid.blocks[0].arrays[0].values};
  const SolidRays rays(grid, values, CellKind::tricubic, 1);
  render::Scene scene = white(0, 0.8);
  scene.shading.emplace();
  set_thread_count(1);
  const auto one = cast_solids(rays, scene, square(24, 1e-6));
  set_thread_count(0);
  const auto all = cast_solids(rays, scene, square(24, 1e-6));
  EXPECT_EQ(one.counts.samples, all.counts.samples);
  EXPECT_GT(one.counts.gradients, 0);
  for (int c = 0; c < 6; ++c) {
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 24; ++x) EXPECT_EQ(one.image.at(x, y, c), all.image.at(x, y, c));
    }
  }
}

TEST(CastSolids, RefusesWhatItCannotDraw) {
  const Grid grid = make_phantom("sheared-box", {3, 3, 3}, "constant", 1);
  const Values values = sampled(grid, [](const Vec3&) { return 0.5; });
  const SolidRays rays(grid, values, CellKind::tricubic, 1);
  render::Scene scene = white(0, 1);
  scene.reference_length = 0;
  EXPECT_THROW((void)cast_solids(rays, scene, square(4)), Error);
  Grid missing = grid;
  missing.blocks[0].hidden.assign(27, 1);
  EXPECT_THROW((void)SolidRays(missing, values, CellKind::tricubic, 1), Error);
  EXPECT_THROW((void)SolidRays(grid, values, CellKind::tricubic, 0), Error);
  EXPECT_THROW((void)SolidRays(grid, Values(2), CellKind::tricubic, 1), Error);
}

}  // namespace
}  // namespace vol::curvilinear
