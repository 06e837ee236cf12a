#include <gtest/gtest.h>

#include <limits>

#include "base/error.h"
#include "files.h"

namespace vol::io {
namespace {

using volume::Grid;
using volume::Space;
using volume::Volume;
using volume::VoxelType;

/// Dims odd and different on each axis, anisotropic spacing, rotated axes, origin off centre, every bit
/// pattern of the type that is a finite number.
Volume generic(VoxelType type, Dims dims = {7, 5, 3}, Space space = Space::lps, bool rotated = true) {
  volume::GridGeometry g;
  g.dims = dims;
  g.spacing = {0.5, 2, 1.25};
  g.origin = {-7.125, 3.1, 11};
  if (rotated) g.direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  g.space = space;
  Volume v = volume::allocate(type, g);
  std::mt19937_64 random(42);
  volume::visit(v, [&](auto& grid) {
    using T = typename std::decay_t<decltype(grid)>::value_type;
    for (auto& voxel : grid.voxels) {
      do {
        const auto bits = random();
        std::memcpy(static_cast<void*>(&voxel), &bits, sizeof(T));
      } while (!std::isfinite(static_cast<double>(voxel)));
    }
  });
  v.attributes = {{"precis.tool", "vol-test"},
                  {"precis.options", R"({"a":"b c","d":[1,2]})"},
                  {"subject", "head = 1: x"}};
  return v;
}

void expect_same(const Volume& read, const Volume& written) {
  ASSERT_EQ(read.voxel_type(), written.voxel_type());
  ASSERT_EQ(read.geometry().dims, written.geometry().dims);
  EXPECT_EQ(values(read), values(written));
  const auto& a = read.geometry();
  const auto& b = written.geometry();
  EXPECT_EQ(a.space, b.space);
  // NRRD stores spacing times direction: splitting it again costs a rounding or two.
  EXPECT_LT((a.spacing - b.spacing).norm(), 4e-16 * b.spacing.norm());
  EXPECT_LT((a.direction - b.direction).norm(), 1e-15);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(read.attributes, written.attributes);
}

struct Format {
  const char* name;
  bool compress;
};
std::ostream& operator<<(std::ostream& out, const Format& f) {
  return out << f.name << (f.compress ? " compressed" : "");
}

class Writer : public testing::TestWithParam<std::tuple<Format, VoxelType>> {};

TEST_P(Writer, RoundTripKeepsEverything) {
  const auto [format, type] = GetParam();
  const Folder folder;
  const auto path = folder / (std::string("v.") + format.name);
  for (const Dims& dims : {Dims{7, 5, 3}, Dims{1, 6, 2}, Dims{4, 1, 1}, Dims{1, 1, 1}}) {
    for (const Space space : {Space::none, Space::lps, Space::ras}) {
      const Volume written = generic(type, dims, space);
      const auto warnings = write_volume(path, written, {.format = {}, .compress = format.compress});
      EXPECT_TRUE(warnings.empty()) << warnings.front();
      Volume expected = written;
      if (std::string(format.name).substr(0, 2) == "mh" && space == Space::ras) {
        // MetaImage's world is LPS: the same points, with x and y turned.
        auto& g = expected.geometry();
        g.space = Space::lps;
        const Mat3 turn = Vec3(-1, -1, 1).asDiagonal();
        g.direction = turn * g.direction;
        g.origin = turn * g.origin;
      }
      expect_same(read_volume(path), expected);
    }
  }
}

TEST_P(Writer, SameVolumeGivesTheSameBytes) {
  const auto [format, type] = GetParam();
  const Folder a, b;
  const std::string name = std::string("v.") + format.name;
  write_volume(a / name, generic(type), {.format = {}, .compress = format.compress});
  write_volume(b / name, generic(type), {.format = {}, .compress = format.compress});
  EXPECT_EQ(bytes_of(a / name), bytes_of(b / name));
  EXPECT_EQ(bytes_of(a / "v.raw"), bytes_of(b / "v.raw"));
}

INSTANTIATE_TEST_SUITE_P(All, Writer,
                         testing::Combine(testing::Values(Format{"nrrd", false}, Format{"nrrd", true},
                                                          Format{"nhdr", false}, Format{"nhdr", true},
                                                          Format{"mha", false}, Format{"mha", true},
                                                          Format{"mhd", false}, Format{"mhd", true},
                                                          Format{"vti", false}, Format{"vti", true}),
                                          testing::Values(VoxelType::i8, VoxelType::u8, VoxelType::i16,
                                                          VoxelType::u16, VoxelType::i32, VoxelType::u32,
                                                          VoxelType::f16, VoxelType::f32, VoxelType::f64)));

TEST(Raw, RoundTripOfEveryType) {
  const Folder folder;
  for (int t = 0; t <= static_cast<int>(VoxelType::f64); ++t) {
    Volume written = generic(static_cast<VoxelType>(t), {7, 5, 3}, Space::none, false);
    const auto warnings = write_volume(folder / "v.raw", written);
    ASSERT_EQ(warnings.size(), 1U);  // says how to read it back
    EXPECT_NE(warnings[0].find("--raw-dims 7x5x3"), std::string::npos);
    ReadOptions options;
    options.raw = RawLayout{{7, 5, 3}, static_cast<VoxelType>(t), false, 0, {0.5, 2, 1.25}};
    written.geometry().origin.setZero();
    written.attributes.clear();
    expect_same(read_volume(folder / "v.raw", options), written);
  }
}

TEST(Raw, BigEndianAfterAHeader) {
  const Folder folder;
  const auto path = folder.write("v.raw", "head" + packed<std::uint16_t>({1, 0x0203, 65535, 4}, true));
  ReadOptions options;
  options.raw = RawLayout{{2, 1, 2}, VoxelType::u16, true, 4, {1, 1, 1}};
  EXPECT_EQ(values(read_volume(path, options)), (std::vector<double>{1, 0x0203, 65535, 4}));
}

TEST(Writer, LargeVolumesCrossTheBlocksOfEveryCoder) {
  // 3 MB: several zlib blocks of VTI, several fills of every buffer; noise does not compress, zeros do.
  const Folder folder;
  for (const bool noise : {true, false}) {
    Volume v = generic(VoxelType::u16, {101, 127, 119}, Space::none);
    if (!noise) {
      auto& voxels = std::get<Grid<std::uint16_t>>(v.grid).voxels;
      std::fill(voxels.begin(), voxels.end(), std::uint16_t{7});
    }
    for (const char* name : {"v.nrrd", "v.mha", "v.vti"}) {
      write_volume(folder / name, v, {.format = {}, .compress = true});
      expect_same(read_volume(folder / name), v);
    }
  }
}

TEST(Writer, AttributesWithOddCharactersComeBackOrAreWarnedOf) {
  const Folder folder;
  Volume v = generic(VoxelType::u8);
  v.attributes = {
      {"lines", "one\ntwo\\n \\ three"}, {"xml", "<a b=\"c\">&amp;</a>"}, {"utf-8", "Précis"}, {"empty", ""}};
  EXPECT_TRUE(write_volume(folder / "v.nrrd", v).empty());
  EXPECT_EQ(read_volume(folder / "v.nrrd").attributes, v.attributes);
  EXPECT_TRUE(write_volume(folder / "v.vti", v).empty());
  EXPECT_EQ(read_volume(folder / "v.vti").attributes, v.attributes);
  EXPECT_EQ(write_volume(folder / "v.mha", v).size(), 1U);  // the line breaks
  EXPECT_EQ(read_volume(folder / "v.mha").attributes.size(), 3U);
}

TEST(Writer, RefusesWhatItCannotWriteAndLeavesNothing) {
  const Folder folder;
  const Volume v = generic(VoxelType::u8);
  EXPECT_THROW(write_volume(folder / "v.nii", v), Error);
  EXPECT_THROW(write_volume(folder / "v", v), Error);
  EXPECT_THROW(write_volume(folder / "missing/v.nrrd", v), Error);
  EXPECT_THROW(write_volume("-", v, {.format = "mhd", .compress = false}), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder / ""));
}

TEST(Writer, FormatOverridesTheExtension) {
  const Folder folder;
  const Volume v = generic(VoxelType::i16);
  write_volume(folder / "v.dat", v, {.format = "mha", .compress = false});
  InputFile file(folder / "v.dat");
  EXPECT_EQ(volume_format(file), "MetaImage");
  expect_same(read_volume(file), v);
}

}  // namespace
}  // namespace vol::io
