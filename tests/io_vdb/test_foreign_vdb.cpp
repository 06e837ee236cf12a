// Files as other programs write them, made with OpenVDB itself.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <unistd.h>

#include <filesystem>

#include "base/error.h"
#include "io/vdb.h"

namespace vol::io {
namespace {

class ForeignVdb : public testing::Test {
 protected:
  ForeignVdb()
      : path_(std::filesystem::path(testing::TempDir()) /
              ("precis-foreign-" + std::to_string(::getpid()) + ".vdb")) {
    openvdb::initialize();
  }
  ~ForeignVdb() override { std::filesystem::remove(path_); }

  void write(const openvdb::GridPtrVec& grids, std::uint32_t compression) const {
    openvdb::io::File file(path_.string());
    file.setCompression(compression);
    file.write(grids);
  }
  [[nodiscard]] volume::Volume read(const VdbOptions& options = {}) const {
    InputFile in(path_);
    return read_vdb_volume(in, options);
  }
  std::filesystem::path path_;
};

openvdb::FloatGrid::Ptr sphere() {
  auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(4.0f, openvdb::Vec3f(3, -2, 10), 0.5f);
  grid->setName("sphere");
  return grid;
}

constexpr std::uint32_t kCompressions[] = {
    openvdb::io::COMPRESS_NONE,        openvdb::io::COMPRESS_ZIP,
    openvdb::io::COMPRESS_ACTIVE_MASK, openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK,
    openvdb::io::COMPRESS_BLOSC,       openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK};

TEST_F(ForeignVdb, LevelSetIsTheDenseBoxOfItsBand) {
  const auto grid = sphere();
  const auto box = grid->evalActiveVoxelBoundingBox();
  for (const bool half : {false, true}) {
    for (const auto compression : kCompressions) {
      grid->setSaveFloatAsHalf(half);
      write({grid}, compression);
      const auto volume = read();
      const auto& g = volume.geometry();
      EXPECT_EQ(g.dims, (Dims{box.dim()[0], box.dim()[1], box.dim()[2]}));
      EXPECT_TRUE(g.spacing.isApprox(Vec3::Constant(0.5), 1e-15));
      const auto& voxels = std::get<volume::Grid<float>>(volume.grid);
      const auto corner = grid->indexToWorld(box.min());
      EXPECT_TRUE(g.origin.isApprox(Vec3(corner[0], corner[1], corner[2]), 1e-14));
      auto accessor = grid->getConstAccessor();
      for (std::int64_t k = 0; k < g.dims[2]; ++k) {
        for (std::int64_t j = 0; j < g.dims[1]; ++j) {
          for (std::int64_t i = 0; i < g.dims[0]; ++i) {
            const openvdb::Coord at(static_cast<int>(i), static_cast<int>(j), static_cast<int>(k));
            // Half precision keeps 11 bits of distances up to 1.5.
            ASSERT_NEAR(voxels(i, j, k), accessor.getValue(box.min() + at), half ? 1e-3 : 0) << compression;
          }
        }
      }
    }
  }
}

TEST_F(ForeignVdb, TheScalarGridIsChosenOrNamed) {
  auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("velocity");
  velocity->tree().setValue(openvdb::Coord(1, 2, 3), openvdb::Vec3s(1, 2, 3));
  auto density = openvdb::DoubleGrid::create(0.25);
  density->setName("density");
  density->tree().setValue(openvdb::Coord(-5, 0, 7), 3.0);
  density->tree().setValue(openvdb::Coord(-3, 1, 7), 4.0);
  write({velocity, density, sphere()}, openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
  const auto volume = read();
  const auto& grid = std::get<volume::Grid<double>>(volume.grid);
  EXPECT_EQ(grid.dims(), (Dims{3, 2, 1}));
  EXPECT_EQ(grid(0, 0, 0), 3);
  EXPECT_EQ(grid(2, 1, 0), 4);
  EXPECT_EQ(grid(1, 0, 0), 0.25);  // the background
  EXPECT_EQ(read({.array = "sphere", .memory_limit = 0}).voxel_type(), volume::VoxelType::f32);
  try {
    (void)read({.array = "pressure", .memory_limit = 0});
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("'velocity' (vec3s), 'density' (double), 'sphere' (float)"),
              std::string::npos)
        << e.what();
  }
}

TEST_F(ForeignVdb, AHugeBoxIsRefusedBeforeItIsAllocated) {
  auto grid = openvdb::FloatGrid::create(0);
  grid->tree().setValue(openvdb::Coord(-2147483647, -2147483647, -2147483647), 1);
  grid->tree().setValue(openvdb::Coord(2147483646, 2147483646, 2147483646), 1);
  write({grid}, openvdb::io::COMPRESS_ACTIVE_MASK);
  EXPECT_THROW((void)read(), Error);
}

TEST_F(ForeignVdb, EmptyGridsAndOtherTreesAreRefusedInWords) {
  write({openvdb::FloatGrid::create(0)}, openvdb::io::COMPRESS_ACTIVE_MASK);
  EXPECT_THROW((void)read(), Error);
  auto mask = openvdb::BoolGrid::create();
  mask->setName("mask");
  mask->tree().setValue(openvdb::Coord(0, 0, 0), true);
  write({mask}, openvdb::io::COMPRESS_ACTIVE_MASK);
  try {
    (void)read();
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("'mask'"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace vol::io
