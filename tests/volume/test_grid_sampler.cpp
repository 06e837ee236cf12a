#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "generic_grid.h"
#include "volume/grid_sampler.h"

namespace vol::volume {
namespace {

static_assert(FieldSampler<GridSampler<std::uint8_t, Reconstruction::nearest>>);
static_assert(FieldSampler<GridSampler<float, Reconstruction::b_spline>>);

/// Tensor-product polynomial of a degree per axis with random coefficients, in index coordinates.
class Polynomial {
 public:
  Polynomial(int degree, std::uint64_t seed) : degree_(degree) {
    Rng rng(seed);
    for (auto& axis : a_) {
      for (int d = 0; d <= degree; ++d) axis[d] = rng.uniform(-1, 1) / std::pow(6.0, d);
    }
  }
  double value(const Vec3& p) const { return axis(0, p[0]) * axis(1, p[1]) * axis(2, p[2]); }
  Vec3 gradient(const Vec3& p) const {
    return {slope(0, p[0]) * axis(1, p[1]) * axis(2, p[2]), axis(0, p[0]) * slope(1, p[1]) * axis(2, p[2]),
            axis(0, p[0]) * axis(1, p[1]) * slope(2, p[2])};
  }

 private:
  double axis(int n, double x) const {
    double sum = 0;
    for (int d = degree_; d >= 0; --d) sum = sum * x + a_[n][d];
    return sum;
  }
  double slope(int n, double x) const {
    double sum = 0;
    for (int d = degree_; d >= 1; --d) sum = sum * x + d * a_[n][d];
    return sum;
  }
  int degree_;
  double a_[3][4];
};

/// The field equals the polynomial, value and world gradient, at random points `margin` samples off the
/// border.
template <Reconstruction kKernel>
void expect_reproduced(int degree, double margin, double tolerance, const Dims& dims = {9, 12, 7}) {
  const auto geometry = generic_geometry(dims);
  const Polynomial f(degree, 17);
  const auto grid = sampled(geometry, [&](const Vec3& p) { return f.value(p); });
  const GridSampler<double, kKernel> field(grid);
  const Mat3 to_index = geometry.world_to_index_matrix();
  Rng rng(3);
  for (int n = 0; n < 400; ++n) {
    Vec3 p;
    for (int a = 0; a < 3; ++a) p[a] = rng.uniform(margin, static_cast<double>(dims[a] - 1) - margin);
    const Vec3 world = geometry.index_to_world(p);
    ASSERT_NEAR(field.value(world), f.value(p), tolerance) << p.transpose();
    const Vec3 gradient = to_index.transpose() * f.gradient(p);
    ASSERT_LT((field.gradient(world) - gradient).norm(), 10 * tolerance) << p.transpose();
  }
}

// 1e-13: some hundred roundings of terms of order 1 to 10; gradients divide by spacings down to 0.5.
TEST(GridSampler, TrilinearReproducesLinear) {
  expect_reproduced<Reconstruction::trilinear>(1, 0, 1e-13);
}
TEST(GridSampler, CatmullRomReproducesQuadraticsUpToTheBorder) {
  expect_reproduced<Reconstruction::catmull_rom>(2, 0, 1e-13);
  expect_reproduced<Reconstruction::catmull_rom>(2, 0, 1e-13, {3, 4, 5});
}
TEST(GridSampler, CatmullRomOfTwoSamplesIsLinear) {
  expect_reproduced<Reconstruction::catmull_rom>(1, 0, 1e-13, {2, 3, 2});
}
// The mirrored border disturbs the coefficients by |z|^margin, z = -0.268, of order 1: 26 samples off, 1e-15.
TEST(GridSampler, BSplineReproducesCubicsAwayFromTheBorder) {
  const Dims dims{61, 58, 59};
  const auto geometry = generic_geometry(dims);
  const auto cubic = [](const Vec3& p) {
    const Vec3 q = (p - Vec3(30, 29, 28)) / 6;
    return q.x() * q.x() * q.x() - 2 * q.y() * q.y() * q.y() + q.z() * q.z() * q.z() * (1 + q.x()) +
           q.y() * q.z() - 3;
  };
  const auto grid = sampled(geometry, cubic);
  const GridSampler<double, Reconstruction::b_spline> field(grid);
  Rng rng(5);
  for (int n = 0; n < 200; ++n) {
    const Vec3 p(rng.uniform(27, 33), rng.uniform(27, 31), rng.uniform(27, 31));
    const Vec3 q = (p - Vec3(30, 29, 28)) / 6;
    // Values at the border are of order 1e3, so the disturbance is 1e3 * 0.268^27 = 4e-13.
    ASSERT_NEAR(field.value_index(p), cubic(p), 5e-12);
    const Vec3 gradient(3 * q.x() * q.x() + q.z() * q.z() * q.z(), -6 * q.y() * q.y() + q.z(),
                        3 * q.z() * q.z() * (1 + q.x()) + q.y());
    ASSERT_LT((field.gradient_index(p) - gradient / 6).norm(), 5e-12);
  }
}

class Interpolation : public testing::TestWithParam<Dims> {};

template <Reconstruction kKernel>
void expect_interpolating(const Grid<double>& grid) {
  const GridSampler<double, kKernel> field(grid);
  for (std::int64_t k = 0; k < grid.dims()[2]; ++k) {
    for (std::int64_t j = 0; j < grid.dims()[1]; ++j) {
      for (std::int64_t i = 0; i < grid.dims()[0]; ++i) {
        const Vec3 p(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        // Noise of order 1; the prefilter amplifies roundings by at most 3 per axis.
        ASSERT_NEAR(field.value_index(p), grid(i, j, k), 1e-13) << p.transpose();
      }
    }
  }
}

TEST_P(Interpolation, EveryKernelPassesThroughTheVoxels) {
  Rng rng(11);
  const auto grid = sampled(generic_geometry(GetParam()), [&](const Vec3&) { return rng.uniform(-1, 1); });
  expect_interpolating<Reconstruction::nearest>(grid);
  expect_interpolating<Reconstruction::trilinear>(grid);
  expect_interpolating<Reconstruction::catmull_rom>(grid);
  expect_interpolating<Reconstruction::b_spline>(grid);
}

INSTANTIATE_TEST_SUITE_P(Sizes, Interpolation,
                         testing::Values(Dims{9, 12, 7}, Dims{1, 5, 2}, Dims{2, 1, 1}, Dims{1, 1, 1},
                                         Dims{3, 4, 1}, Dims{50, 3, 45}, Dims{2, 600, 2}));

template <Reconstruction kKernel>
void expect_gradient_is_derivative() {
  Rng rng(23);
  const auto grid = sampled(generic_geometry(), [&](const Vec3&) { return rng.uniform(-1, 1); });
  const GridSampler<double, kKernel> field(grid);
  const double h = 1e-5;
  for (int n = 0; n < 200; ++n) {
    // Strictly inside a cell, so that the difference does not cross a kink.
    Vec3 p;
    for (int a = 0; a < 3; ++a) {
      p[a] = static_cast<double>(rng.below(static_cast<std::uint64_t>(grid.dims()[a] - 1))) +
             rng.uniform(0.1, 0.9);
    }
    const Vec3 gradient = field.gradient_index(p);
    for (int a = 0; a < 3; ++a) {
      const double difference =
          (field.value_index(p + h * Vec3::Unit(a)) - field.value_index(p - h * Vec3::Unit(a))) / (2 * h);
      ASSERT_NEAR(gradient[a], difference, 1e-8);  // h^2 f''' + eps / h
    }
  }
}

TEST(GridSampler, GradientIsTheDerivativeOfTheValue) {
  expect_gradient_is_derivative<Reconstruction::trilinear>();
  expect_gradient_is_derivative<Reconstruction::catmull_rom>();
  expect_gradient_is_derivative<Reconstruction::b_spline>();
}

TEST(GridSampler, OutsideIsClampedAndOneSampleIsConstant) {
  Rng rng(29);
  auto geometry = generic_geometry({6, 1, 5});
  const auto grid = sampled(geometry, [&](const Vec3&) { return rng.uniform(-1, 1); });
  const GridSampler<double, Reconstruction::catmull_rom> field(grid);
  EXPECT_EQ(field.value_index({-3, 0, 1.5}), field.value_index({0, 0, 1.5}));
  EXPECT_EQ(field.value_index({9, 0, 1.5}), field.value_index({5, 0, 1.5}));
  EXPECT_EQ(field.value_index({2.25, -0.4, 1.5}), field.value_index({2.25, 0.5, 1.5}));
  EXPECT_EQ(field.gradient_index({2.25, 0.2, 1.5}).y(), 0);
  EXPECT_FALSE(std::isnan(field.value_index(Vec3::Constant(std::nan("")))));
}

template <Reconstruction kKernel>
double worst_error(std::int64_t n) {
  GridGeometry geometry = generic_geometry({n + 1, n + 3, n + 6});
  geometry.spacing /= static_cast<double>(n);
  geometry.origin.setZero();
  const auto f = [](const Vec3& q) {
    return std::sin(q.x() * 2 + 0.3) * std::cos(q.y() - 0.2) + std::exp(-q.z());
  };
  const auto grid = sampled(geometry, [&](const Vec3& p) { return f(geometry.index_to_world(p)); });
  const GridSampler<double, kKernel> field(grid);
  Rng rng(31);
  double worst = 0;
  for (int m = 0; m < 3000; ++m) {
    // World box common to all sizes, clear of the border by a quarter, which the spline's mirrors need.
    const Vec3 world =
        geometry.direction * Vec3(rng.uniform(0.125, 0.375), rng.uniform(0.5, 1.5), rng.uniform(0.3, 0.9));
    worst = std::max(worst, std::abs(field.value(world) - f(world)));
  }
  return worst;
}

// Halving the spacing divides the error by 2^order; a quarter of an order is left for the next term.
TEST(GridSampler, OrderOfConvergence) {
  EXPECT_NEAR(std::log2(worst_error<Reconstruction::nearest>(32) / worst_error<Reconstruction::nearest>(64)),
              1, 0.25);
  EXPECT_NEAR(
      std::log2(worst_error<Reconstruction::trilinear>(32) / worst_error<Reconstruction::trilinear>(64)), 2,
      0.25);
  EXPECT_NEAR(
      std::log2(worst_error<Reconstruction::catmull_rom>(32) / worst_error<Reconstruction::catmull_rom>(64)),
      3, 0.25);
  EXPECT_NEAR(
      std::log2(worst_error<Reconstruction::b_spline>(64) / worst_error<Reconstruction::b_spline>(128)), 4,
      0.25);
}

}  // namespace
}  // namespace vol::volume
