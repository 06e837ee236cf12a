#include <gtest/gtest.h>

#include "base/error.h"
#include "base/rng.h"
#include "generic_grid.h"
#include "volume/arithmetic.h"
#include "volume/grid_sampler.h"
#include "volume/rearrange.h"
#include "volume/resample.h"

namespace vol::volume {
namespace {

constexpr Reconstruction kAll[] = {Reconstruction::nearest, Reconstruction::trilinear,
                                   Reconstruction::catmull_rom, Reconstruction::b_spline};

Volume noise(const Dims& dims, std::uint64_t seed = 1) {
  Rng rng(seed);
  Volume volume;
  volume.grid = sampled(generic_geometry(dims), [&](const Vec3&) { return rng.uniform(-1, 1); });
  volume.attributes["note"] = "kept";
  return volume;
}

const Grid<double>& f64(const Volume& volume) {
  return std::get<Grid<double>>(volume.grid);
}

/// Every voxel of `result` has the value that `field` has at its world position.
template <class Field>
void expect_same_field(const Volume& result, const Field& field, double tolerance) {
  const auto& grid = f64(result);
  for (std::int64_t k = 0; k < grid.dims()[2]; ++k) {
    for (std::int64_t j = 0; j < grid.dims()[1]; ++j) {
      for (std::int64_t i = 0; i < grid.dims()[0]; ++i) {
        const Vec3 p(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        ASSERT_NEAR(grid(i, j, k), field.value(grid.geometry.index_to_world(p)), tolerance) << p.transpose();
      }
    }
  }
}

// 1e-12: rounding of positions (1e-15 of a dozen) times slopes of order 1 to 10.
TEST(Resample, IsTheReconstructedFieldAtTheNewCentres) {
  for (const Dims& dims : {Dims{23, 9, 40}, Dims{5, 12, 3}, Dims{1, 30, 7}}) {
    const Volume v = noise({9, 12, 7});
    expect_same_field(resampled(v, dims, Reconstruction::trilinear),
                      GridSampler<double, Reconstruction::trilinear>(f64(v)), 1e-12);
    expect_same_field(resampled(v, dims, Reconstruction::catmull_rom),
                      GridSampler<double, Reconstruction::catmull_rom>(f64(v)), 1e-12);
    expect_same_field(resampled(v, dims, Reconstruction::b_spline),
                      GridSampler<double, Reconstruction::b_spline>(f64(v)), 1e-12);
  }
}

TEST(Resample, KeepsTheBox) {
  for (const Dims& from : {Dims{9, 12, 7}, Dims{1, 2, 7}}) {
    for (const Dims& to : {Dims{4, 1, 31}, Dims{1, 1, 1}, Dims{9, 12, 7}}) {
      const auto a = field_bounds(generic_geometry(from));
      const auto b = field_bounds(resampled_geometry(generic_geometry(from), to));
      EXPECT_LT((a.corner - b.corner).norm(), 1e-13);
      EXPECT_LT((a.edges - b.edges).norm(), 1e-13);
    }
  }
}

TEST(Resample, SameSizeIsTheSameVolume) {
  const Volume v = noise({9, 12, 7});
  for (const auto kernel : kAll) {
    const Volume w = resampled(v, {9, 12, 7}, kernel);
    EXPECT_EQ(w.geometry(), v.geometry());
    EXPECT_EQ(w.attributes, v.attributes);
    for (std::size_t n = 0; n < f64(v).voxels.size(); ++n) {
      ASSERT_NEAR(f64(w).voxels[n], f64(v).voxels[n], kernel == Reconstruction::b_spline ? 1e-14 : 0)
          << name(kernel);
    }
  }
}

TEST(Resample, OvershootOfIntegersIsClamped) {
  GridGeometry geometry = generic_geometry({6, 1, 1});
  Volume v = allocate(VoxelType::u8, geometry);
  std::get<Grid<std::uint8_t>>(v.grid).voxels = {0, 0, 0, 255, 255, 255};
  const Volume w = resampled(v, {61, 1, 1}, Reconstruction::catmull_rom);
  const auto& voxels = std::get<Grid<std::uint8_t>>(w.grid).voxels;
  for (std::size_t n = 1; n < voxels.size(); ++n)
    EXPECT_GE(voxels[n], voxels[n - 1]);  // no wrap from -1 to 255
}

TEST(Rearrange, TheFieldStaysInItsPlace) {
  const Volume v = noise({9, 12, 7});
  const GridSampler<double, Reconstruction::trilinear> field(f64(v));
  expect_same_field(cropped(v, {2, 0, 3}, {9, 5, 4}), field, 1e-13);
  expect_same_field(flipped(v, 0), field, 1e-13);
  expect_same_field(flipped(v, 1), field, 1e-13);
  expect_same_field(flipped(v, 2), field, 1e-13);
  expect_same_field(transposed(v, axis_order("zxy")), field, 1e-13);
  expect_same_field(transposed(v, axis_order("yxz")), field, 1e-13);
}

TEST(Rearrange, UndoesItself) {
  const Volume v = noise({9, 12, 7});
  EXPECT_EQ(f64(flipped(flipped(v, 1), 1)).voxels, f64(v).voxels);
  EXPECT_EQ(f64(transposed(transposed(v, axis_order("zxy")), axis_order("yzx"))).voxels, f64(v).voxels);
  const Volume padded_and_cropped = cropped(padded(v, 3, -5), {3, 3, 3}, {12, 15, 10});
  EXPECT_EQ(f64(padded_and_cropped).voxels, f64(v).voxels);
  EXPECT_TRUE(padded_and_cropped.geometry().origin.isApprox(v.geometry().origin, 1e-14));
  EXPECT_EQ(f64(padded(v, 3, -5))(2, 5, 5), -5);
  EXPECT_EQ(f64(padded(v, 3, -5))(3, 3, 3), f64(v)(0, 0, 0));
}

TEST(Rearrange, RefusesWhatIsNoBoxAndNoOrder) {
  const Volume v = noise({9, 12, 7});
  EXPECT_THROW((void)cropped(v, {0, 0, 0}, {10, 12, 7}), Error);
  EXPECT_THROW((void)cropped(v, {-1, 0, 0}, {9, 12, 7}), Error);
  EXPECT_THROW((void)cropped(v, {3, 0, 0}, {3, 12, 7}), Error);
  EXPECT_THROW((void)axis_order("zzy"), Error);
  EXPECT_THROW((void)axis_order("xy"), Error);
  EXPECT_THROW((void)padded(v, std::int64_t{1} << 62, 0), Error);
}

TEST(Arithmetic, DifferenceOfBytesIsSigned) {
  GridGeometry geometry = generic_geometry({2, 1, 1});
  Volume p = allocate(VoxelType::u8, geometry);
  Volume n = allocate(VoxelType::u8, geometry);
  std::get<Grid<std::uint8_t>>(p.grid).voxels = {255, 0};
  std::get<Grid<std::uint8_t>>(n.grid).voxels = {0, 255};
  const Volume d = difference(p, n);
  ASSERT_EQ(d.voxel_type(), VoxelType::i16);
  EXPECT_EQ(std::get<Grid<std::int16_t>>(d.grid).voxels[0], 255);
  EXPECT_EQ(std::get<Grid<std::int16_t>>(d.grid).voxels[1], -255);
  EXPECT_THROW((void)difference(p, noise({3, 1, 1})), Error);
}

TEST(Arithmetic, RescaleMeetsTheEndsAndConstantsStayFinite) {
  const Volume v = noise({9, 12, 7});
  const Range range = value_range(rescaled(v, -2, 10, VoxelType::f64));
  EXPECT_NEAR(range.min, -2, 1e-14);
  EXPECT_NEAR(range.max, 10, 1e-14);
  EXPECT_EQ(value_range(rescaled(v, 0, 255, VoxelType::u8)).max, 255);
  const Volume constant = scaled(v, 0, 3, VoxelType::f32);
  EXPECT_EQ(value_range(rescaled(constant, 1, 2, VoxelType::f32)).max, 1);
}

}  // namespace
}  // namespace vol::volume
