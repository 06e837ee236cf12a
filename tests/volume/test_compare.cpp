#include "volume/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"

namespace vol::volume {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class T, class F>
Volume volume_of(const Dims& dims, const F& f) {
  GridGeometry geometry;
  geometry.dims = dims;
  Grid<T> grid{geometry, Buffer<T>(static_cast<std::size_t>(geometry.count()))};
  for (std::size_t n = 0; n < grid.voxels.size(); ++n) grid.voxels[n] = static_cast<T>(f(n));
  Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

TEST(CompareVolumes, EqualsTheDefinitions) {
  const Dims dims{41, 37, 29};
  Rng rng(1);
  const Volume a = volume_of<float>(dims, [&](std::size_t) { return rng.normal(); });
  const Volume b = volume_of<std::int16_t>(dims, [&](std::size_t) { return 20 * rng.normal(); });
  const auto& x = std::get<Grid<float>>(a.grid).voxels;
  const auto& y = std::get<Grid<std::int16_t>>(b.grid).voxels;
  long double squares = 0;
  long double absolutes = 0;
  long double reference = 0;
  double maximum = 0;
  std::size_t at = 0;
  double lo = 1e9;
  double hi = -1e9;
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double d = std::abs(static_cast<double>(x[n]) - y[n]);
    squares += static_cast<long double>(d) * d;
    absolutes += d;
    reference += static_cast<long double>(y[n]) * y[n];
    lo = std::min<double>(lo, y[n]);
    hi = std::max<double>(hi, y[n]);
    if (d > maximum) {
      maximum = d;
      at = n;
    }
  }
  const VolumeError error = compare(a, b);
  const auto count = static_cast<long double>(x.size());
  const auto mse = static_cast<double>(squares / count);
  EXPECT_NEAR(error.mse, mse, 1e-15 * mse * 4);
  EXPECT_NEAR(error.rmse, std::sqrt(mse), 1e-14);
  EXPECT_NEAR(error.mae, static_cast<double>(absolutes / count), 1e-14);
  EXPECT_EQ(error.maximum, maximum);
  EXPECT_EQ(error.maximum_at[0] + 41 * (error.maximum_at[1] + 37 * error.maximum_at[2]),
            static_cast<std::int64_t>(at));
  EXPECT_EQ(error.reference_range.min, lo);
  EXPECT_EQ(error.reference_range.max, hi);
  EXPECT_NEAR(error.rmse_byte, std::sqrt(mse) * 255 / (hi - lo), 1e-13);
  EXPECT_NEAR(error.psnr, 10 * std::log10((hi - lo) * (hi - lo) / mse), 1e-12);
  EXPECT_NEAR(error.relative_l2, static_cast<double>(std::sqrt(squares / reference)), 1e-14);
}

TEST(CompareVolumes, AConstantOffset) {
  const Volume a = volume_of<std::uint8_t>({5, 6, 7}, [](std::size_t n) { return n % 201; });
  const Volume b =
      volume_of<double>({5, 6, 7}, [](std::size_t n) { return static_cast<double>(n % 201) + 2; });
  const VolumeError error = compare(b, a);
  EXPECT_EQ(error.mse, 4);
  EXPECT_EQ(error.mae, 2);
  EXPECT_EQ(error.maximum, 2);
  EXPECT_EQ(error.maximum_at, (std::array<std::int64_t, 3>{0, 0, 0}));
  EXPECT_DOUBLE_EQ(error.psnr, 40);  // range 200, rmse 2
  EXPECT_EQ(error.differing, 210);
}

TEST(CompareVolumes, EqualAndConstant) {
  const Volume zero = volume_of<float>({3, 1, 4}, [](std::size_t) { return 0; });
  const Volume one = volume_of<float>({3, 1, 4}, [](std::size_t) { return 1; });
  const VolumeError same = compare(zero, zero);
  EXPECT_EQ(same.mse, 0);
  EXPECT_EQ(same.rmse_byte, 0);
  EXPECT_EQ(same.relative_l2, 0);
  EXPECT_EQ(same.psnr, kInf);
  EXPECT_EQ(same.maximum_at[0], -1);
  const VolumeError differ = compare(one, zero);
  EXPECT_EQ(differ.relative_l2, kInf);
  EXPECT_EQ(differ.rmse_byte, kInf);
  EXPECT_EQ(differ.psnr, -kInf);
}

TEST(CompareVolumes, ValuesOfAnySize) {
  Rng rng(2);
  std::vector<double> values(2 * 3 * 50);
  for (double& value : values) value = rng.uniform(-1, 1);
  const auto scaled = [&](int exponent, double shift) {
    return volume_of<double>({2, 3, 50}, [&](std::size_t n) {
      return std::ldexp(values[n] + shift * static_cast<double>(n % 3), exponent);
    });
  };
  const VolumeError expected = compare(scaled(0, 0.1), scaled(0, 0));
  for (const int k : {-1000, -600, 600, 1020}) {
    const VolumeError error = compare(scaled(k, 0.1), scaled(k, 0));
    // Scaling by powers of two is exact but for denormals, which stay away from 2^-1000 by 2^-74.
    EXPECT_DOUBLE_EQ(error.rmse, std::ldexp(expected.rmse, k));
    EXPECT_DOUBLE_EQ(error.maximum, std::ldexp(expected.maximum, k));
    EXPECT_NEAR(error.psnr, expected.psnr, 1e-11);  // differences of logarithms up to 700 in size
    EXPECT_DOUBLE_EQ(error.relative_l2, expected.relative_l2);
    EXPECT_DOUBLE_EQ(error.rmse_byte, expected.rmse_byte);
  }
}

TEST(CompareVolumes, InfinityAndNaNAreSaid) {
  const auto with = [](double value) {
    return volume_of<float>({4, 4, 4},
                            [value](std::size_t n) { return n == 21 ? value : static_cast<double>(n); });
  };
  EXPECT_EQ(compare(with(kInf), with(kInf)).mse, 0);
  EXPECT_EQ(compare(with(kInf), with(-kInf)).mse, kInf);
  EXPECT_EQ(compare(with(kInf), with(0)).maximum, kInf);
  EXPECT_EQ(compare(with(kInf), with(-kInf)).infinite, 2);
  EXPECT_EQ(compare(with(0), with(kInf)).reference_range.max, 63);
  const VolumeError error = compare(with(kNaN), with(0));
  EXPECT_TRUE(std::isnan(error.mse));
  EXPECT_TRUE(std::isnan(error.maximum));
  EXPECT_EQ(error.maximum_at, (std::array<std::int64_t, 3>{1, 1, 1}));
  EXPECT_EQ(error.nan, 1);
}

TEST(CompareVolumes, TheSameBitsForAnyNumberOfThreads) {
  Rng rng(3);
  const Volume a = volume_of<float>({67, 71, 73}, [&](std::size_t) { return rng.normal(); });
  const Volume b = volume_of<float>({67, 71, 73}, [&](std::size_t) { return rng.normal(); });
  const VolumeError expected = compare(a, b);
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    const VolumeError error = compare(a, b);
    EXPECT_EQ(error.mse, expected.mse);
    EXPECT_EQ(error.mae, expected.mae);
    EXPECT_EQ(error.relative_l2, expected.relative_l2);
  }
  set_thread_count(0);
}

TEST(CompareVolumes, DimsThatDifferAreNamed) {
  const auto zero = [](std::size_t) { return 0; };
  try {
    (void)compare(volume_of<float>({3, 4, 5}, zero), volume_of<float>({5, 4, 3}, zero));
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("3x4x5"), testing::HasSubstr("5x4x3")));
  }
}

TEST(GeometryDifferences, OneSentenceEach) {
  GridGeometry a;
  a.spacing = {1, 2, 3};
  a.origin = {-90.3, 4, 5};
  GridGeometry b = a;
  EXPECT_THAT(geometry_differences(a, b), testing::IsEmpty());
  b.origin[0] = static_cast<float>(b.origin[0]);
  EXPECT_THAT(geometry_differences(a, b), testing::IsEmpty());  // a header of floats holds no more
  b.origin[0] += 0.01;
  b.spacing[1] = 2.001;
  b.space = Space::lps;
  b.direction.col(2) *= -1;
  EXPECT_THAT(geometry_differences(a, b),
              testing::ElementsAre(testing::StartsWith("spacing 1,2,3 against 1,2.001,3"),
                                   testing::StartsWith("origin"), testing::StartsWith("direction of k"),
                                   testing::StartsWith("space")));
}

}  // namespace
}  // namespace vol::volume
