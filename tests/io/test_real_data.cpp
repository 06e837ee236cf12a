// Volumes in circulation must load with the figures that were measured from their bytes by other means.
#include <gtest/gtest.h>

#include <cstdlib>

#include "files.h"

namespace vol::io {
namespace {

using volume::VoxelType;

struct Known {
  const char* file;
  Dims dims;
  VoxelType type;
  double min, max, mean, mean_tolerance;  ///< the mean as printed: half a unit of its last digit
  Vec3 spacing;
  bool raw = false;
};

/// The file, where a test is named.
void PrintTo(const Known& known, std::ostream* os) {
  *os << known.file;
}

void check(const std::filesystem::path& path, const Known& known) {
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  ReadOptions options;
  if (known.raw) options.raw = RawLayout{known.dims, known.type, false, 0, known.spacing};
  const auto v = read_volume(path, options);
  EXPECT_EQ(v.geometry().dims, known.dims);
  EXPECT_EQ(v.voxel_type(), known.type);
  const auto range = volume::value_range(v);
  const double unit = known.type == VoxelType::f32 ? 1e-5 : 0;  // floats are printed rounded
  EXPECT_NEAR(range.min, known.min, unit);
  EXPECT_NEAR(range.max, known.max, unit);
  EXPECT_NEAR(mean(v), known.mean, known.mean_tolerance);
  EXPECT_LT((v.geometry().spacing - known.spacing).norm(), 1e-12 * known.spacing.norm());
}

class DataSet : public testing::TestWithParam<Known> {};

TEST_P(DataSet, LoadsWithTheKnownFigures) {
  const char* data = std::getenv("PRECIS_DATA");
  if (data == nullptr) GTEST_SKIP() << "PRECIS_DATA is not set";
  check(std::filesystem::path(data) / GetParam().file, GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    All, DataSet,
    testing::Values(
        Known{"hipip/ironProt.vtk", {68, 68, 68}, VoxelType::u8, 0, 255, 13.138259, 5e-7, {1, 1, 1}},
        Known{"neghip/neghip_64x64x64_uint8.raw",
              {64, 64, 64},
              VoxelType::u8,
              0,
              255,
              18.402775,
              5e-7,
              {1, 1, 1},
              true},
        Known{
            "ct-head/quarter.nhdr", {64, 64, 93}, VoxelType::i16, 0, 3926, 507.687324, 5e-7, {3.2, 3.2, 1.5}},
        Known{"mr-head/HeadMRVolume.mhd", {48, 62, 42}, VoxelType::u8, 0, 255, 24.468222, 5e-7, {4, 4, 4}},
        Known{"nucleon/nucleon.nrrd", {41, 41, 41}, VoxelType::u8, 0, 249, 39.397658, 5e-7, {1, 1, 1}},
        Known{"nucleon/nucleon.raw", {41, 41, 41}, VoxelType::u8, 0, 249, 39.397658, 5e-7, {1, 1, 1}, true},
        Known{"bucky/Bucky_32_32_32.raw",
              {32, 32, 32},
              VoxelType::u8,
              0,
              255,
              35.849792,
              5e-7,
              {1, 1, 1},
              true},
        Known{"walnut/walnut.raw",
              {128, 96, 114},
              VoxelType::u16,
              0,
              22526,
              2050.941239,
              5e-7,
              {0.015625, 0.015625, 0.015625},
              true},
        Known{"chest-ct/LIDC2.mha",
              {256, 256, 133},
              VoxelType::u8,
              0,
              255,
              7.054514,
              5e-7,
              {1.4062499999999947, 1.4062499999999909, 2.4999999999999809}},
        Known{"bonsai/bonsai.vti", {256, 256, 256}, VoxelType::u8, 0, 255, 13.711380, 5e-7, {1, 1, 1}},
        Known{"aneurism/aneurism.vti", {256, 256, 256}, VoxelType::u8, 0, 255, 1.069210, 5e-7, {1, 1, 1}},
        Known{"vase/vase_1comp.vti", {115, 101, 75}, VoxelType::u8, 0, 239, 12.309520, 5e-7, {1, 1, 1}},
        Known{"carotid/carotid.vtk", {76, 49, 45}, VoxelType::f32, 0, 580, 99.049093, 5e-7, {1, 1, 1}}),
    [](const auto& instance) {
      std::string name = instance.param.file;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; },
          '_');
      return name;
    });

TEST(DataSet, GeometryOfTheChest) {
  const char* data = std::getenv("PRECIS_DATA");
  if (data == nullptr) GTEST_SKIP() << "PRECIS_DATA is not set";
  const auto v = read_volume(std::filesystem::path(data) / "chest-ct/LIDC2.mha");
  EXPECT_EQ(v.geometry().space, volume::Space::lps);
  EXPECT_LT((v.geometry().direction - Mat3(Vec3(1, -1, -1).asDiagonal())).norm(), 1e-14);
  EXPECT_LT((v.geometry().origin - Vec3(0, 360, 332.5)).norm(), 1e-12);
}

class DebianVolume : public testing::TestWithParam<Known> {};

TEST_P(DebianVolume, LoadsWithTheKnownFigures) {
  check(GetParam().file, GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    All, DebianVolume,
    testing::Values(Known{"/usr/share/mricron/templates/ch2bet.nii.gz",
                          {181, 217, 181},
                          VoxelType::u8,
                          0,
                          133,
                          22.2990,
                          5e-5,
                          {1, 1, 1}},
                    Known{"/usr/share/mricron/templates/ch2.nii.gz",
                          {181, 217, 181},
                          VoxelType::u8,
                          0,
                          254,
                          44.6118,
                          5e-5,
                          {1, 1, 1}},
                    Known{"/usr/share/mricron/templates/inia19-t1-brain.nii.gz",
                          {168, 206, 128},
                          VoxelType::f32,
                          0,
                          383.17554,
                          17.0112,
                          5e-5,
                          {0.5, 0.5, 0.5}},
                    Known{"/usr/lib/python3/dist-packages/nibabel/tests/data/anatomical.nii",
                          {33, 41, 25},
                          VoxelType::i16,
                          -610,
                          30393,
                          8401.0667,
                          5e-5,
                          {2, 2, 2}}));

}  // namespace
}  // namespace vol::io
