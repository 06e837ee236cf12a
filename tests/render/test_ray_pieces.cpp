#include <gtest/gtest.h>

#include "fields.h"
#include "render/grid_field.h"
#include "render/ray_polynomial.h"

namespace vol::render {
namespace {

using volume::Reconstruction;

class Pieces : public ::testing::TestWithParam<std::tuple<Reconstruction, Dims>> {};

TEST_P(Pieces, AreTheFieldItself) {
  const auto [kernel, dims] = GetParam();
  const volume::Volume volume = generic_volume(0.5, dims);
  const GridField field(volume, kernel);
  const GridPieces pieces(volume, kernel);
  const auto& bounds = field.view().bounds;
  Rng rng(11);
  for (int trial = 0; trial < 60; ++trial) {
    const auto point = [&] {
      return Vec3(bounds.corner + bounds.edges * Vec3(rng.uniform(), rng.uniform(), rng.uniform()));
    };
    const Vec3 p = point();
    camera::Ray ray{p, (point() - p).normalized()};
    if (trial % 4 == 3) ray.direction = bounds.edges.col(trial % 3).normalized();  // along an axis
    const auto chord = RayBox(bounds).chord(ray, -1e9);
    ASSERT_TRUE(chord);
    double t = chord->entry;
    pieces(ray, *chord, [&](const RayPiece& piece) {
      EXPECT_EQ(piece.t0, t);
      EXPECT_GT(piece.t1, piece.t0);
      t = piece.t1;
      for (const double u : {0.01, 0.31, 0.77, 0.99}) {
        const double at = piece.t0 + u * (piece.t1 - piece.t0);
        // Very short pieces at cell corners: rounding of the position may fall into the neighbour of a step.
        if (kernel == Reconstruction::nearest && piece.t1 - piece.t0 < 1e-9) continue;
        EXPECT_NEAR(piece.p(u), field.view().value(ray.origin + at * ray.direction), 2e-13);
        EXPECT_GE(piece.p(u), piece.p.min() - 1e-14);
        EXPECT_LE(piece.p(u), piece.p.max() + 1e-14);
      }
      return true;
    });
    EXPECT_EQ(t, chord->exit);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, Pieces,
    ::testing::Combine(::testing::Values(Reconstruction::nearest, Reconstruction::trilinear,
                                         Reconstruction::catmull_rom, Reconstruction::b_spline),
                       ::testing::Values(Dims{9, 12, 7}, Dims{1, 5, 2}, Dims{1, 1, 6}, Dims{3, 2, 2},
                                         Dims{1, 1, 1})));

TEST(Pieces, ConstantVolumesAreConstantToTheBit) {
  volume::Volume volume = generic_volume();
  for (auto& v : std::get<volume::Grid<double>>(volume.grid).voxels) v = 0.1;
  const GridPieces pieces(volume, Reconstruction::catmull_rom);
  const auto bounds = volume::field_bounds(volume.geometry());
  const camera::Ray ray{bounds.centre(), Vec3(1, 2, 3).normalized()};
  pieces(ray, *RayBox(bounds).chord(ray, -1e9), [](const RayPiece& piece) {
    EXPECT_EQ(piece.p.min(), 0.1);
    EXPECT_EQ(piece.p.max(), 0.1);
    return true;
  });
}

TEST(Fit, SmoothFieldToRoundingAndJumpsToTheirPlace) {
  const auto bounds = generic_box();
  const camera::Ray ray{bounds.centre(), Vec3(1, 2, 3).normalized()};
  const auto chord = RayBox(bounds).chord(ray, -1e9);
  const FunctionField smooth{
      [](const Vec3& p) { return std::exp(-p.squaredNorm() / 20) * std::sin(3 * p[0]); }, {}, bounds};
  const FunctionField jump{
      [&](const Vec3& p) { return (p - bounds.centre()).norm() < 0.4 ? 1.0 : 0.0; }, {}, bounds};
  double jump_integral = 0;
  fit_pieces(view_of(smooth), ray, *chord, [&](const RayPiece& piece) {
    for (const double u : {0.1, 0.5, 0.9}) {
      const double t = piece.t0 + u * (piece.t1 - piece.t0);
      EXPECT_NEAR(piece.p(u), smooth.value(ray.origin + t * ray.direction), 2e-13);
    }
    return true;
  });
  fit_pieces(view_of(jump), ray, *chord, [&](const RayPiece& piece) {
    jump_integral += (piece.t1 - piece.t0) * piece.p.integral();
    return true;
  });
  EXPECT_NEAR(jump_integral, 0.8, 1e-12);
}

}  // namespace
}  // namespace vol::render
