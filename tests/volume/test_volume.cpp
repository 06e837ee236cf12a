#include <gtest/gtest.h>

#include <limits>

#include "base/error.h"
#include "volume/volume.h"

namespace vol::volume {
namespace {

GridGeometry generic() {
  GridGeometry g;
  g.dims = {5, 4, 3};
  g.spacing = {0.5, 2, 1.25};
  g.origin = {-7, 3, 11};
  g.direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  return g;
}

TEST(GridGeometry, IndexAndWorldAreInverse) {
  const auto g = generic();
  const Vec3 p(1.25, 0.5, 1.75);
  EXPECT_TRUE(g.world_to_index(g.index_to_world(p)).isApprox(p, 1e-14));
  EXPECT_TRUE(g.index_to_world(Vec3::Zero()).isApprox(g.origin));
  EXPECT_NEAR((g.index_to_world({1, 0, 0}) - g.origin).norm(), 0.5, 1e-14);
}

TEST(GridGeometry, AnAxisOfOneSampleIsOneSpacingThick) {
  auto g = generic();
  g.dims = {5, 1, 3};
  EXPECT_EQ(g.index_box().min.y(), -0.5);
  EXPECT_EQ(g.edge_lengths().y(), 2);
  EXPECT_EQ(g.edge_lengths().x(), 2);
}

TEST(GridGeometry, RefusesWhatIsNoGrid) {
  auto g = generic();
  g.spacing.y() = -1;
  EXPECT_THROW(g.validate(), Error);
  g = generic();
  g.dims[2] = 0;
  EXPECT_THROW(g.validate(), Error);
  g = generic();
  g.direction.col(1) = g.direction.col(0);
  EXPECT_THROW(g.validate(), Error);
  g = generic();
  g.origin.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(g.validate(), Error);
}

// More bytes than there are addresses, which containers tell by another exception than too little memory.
TEST(Volume, SizesBeyondAddressesAreRefusedInWords) {
  auto g = generic();
  g.dims = {1500000, 1500000, 1500000};
  try {
    (void)allocate(VoxelType::f32, g);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("1500000x1500000x1500000 voxels of type f32 take"),
              std::string::npos)
        << e.what();
  }
}

TEST(Volume, NonFiniteVoxelsAreRefusedWithCountAndPosition) {
  Volume v = allocate(VoxelType::f32, generic());
  auto& grid = std::get<Grid<float>>(v.grid);
  std::fill(grid.voxels.begin(), grid.voxels.end(), 1.0f);
  grid(3, 2, 1) = std::numeric_limits<float>::infinity();
  grid(4, 3, 2) = std::numeric_limits<float>::quiet_NaN();
  try {
    (void)value_range(v);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("2 voxels are NaN or infinite, the first at (3,2,1)"),
              std::string::npos)
        << e.what();
  }
  const double missing = -4;
  require_finite(v, &missing);
  EXPECT_EQ(value_range(v).min, -4);
  EXPECT_EQ(value_range(v).max, 1);
}

TEST(Volume, ConversionRoundsToEvenAndClamps) {
  GridGeometry g;
  g.dims = {4, 1, 1};
  Volume v = allocate(VoxelType::f64, g);
  std::get<Grid<double>>(v.grid).voxels = {-3.0, 2.5, 3.5, 300.0};
  const auto bytes = converted<std::uint8_t>(v);
  EXPECT_EQ(bytes.voxels[0], 0);
  EXPECT_EQ(bytes.voxels[1], 2);
  EXPECT_EQ(bytes.voxels[2], 4);
  EXPECT_EQ(bytes.voxels[3], 255);
}

}  // namespace
}  // namespace vol::volume
