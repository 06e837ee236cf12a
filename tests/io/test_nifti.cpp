// Hand-made files of NIfTI-1's variants.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "read_files.h"

namespace vol::io {
namespace {

using testing::HasSubstr;
using volume::Space;
using volume::VoxelType;

struct Nifti {
  bool big = false;
  std::string bytes = std::string(352, '\0');
  template <class T>
  Nifti& set(std::size_t offset, T value) {
    bytes.replace(offset, sizeof(T), packed(std::vector<T>{value}, big));
    return *this;
  }
  explicit Nifti(bool big_endian = false) : big(big_endian) {
    set<std::int32_t>(0, 348);
    const std::vector<std::int16_t> dim = {3, 3, 2, 1, 1, 1, 1, 1};
    for (std::size_t i = 0; i < 8; ++i) set(40 + 2 * i, dim[i]);
    set<std::int16_t>(70, 4).set<std::int16_t>(72, 16).set<float>(108, 352);
    for (std::size_t i = 0; i < 4; ++i) set(76 + 4 * i, i == 0 ? 1.0f : static_cast<float>(i) / 2);
    bytes.replace(344, 4, std::string("n+1\0", 4));
  }
};

TEST(Nifti, BothByteOrdersPlainGzippedAndInTwoFiles) {
  const Folder folder;
  for (const bool big : {false, true}) {
    Nifti n(big);
    const std::string data = packed(kShorts, big);
    const auto v = read_volume(folder.write("a.nii", n.bytes + data));
    EXPECT_EQ(values(v), kSix);
    EXPECT_EQ(v.geometry().spacing, Vec3(0.5, 1, 1.5));
    EXPECT_EQ(v.geometry().space, Space::none);
    EXPECT_EQ(values(read_volume(folder.write("a.nii.gz", gzipped(n.bytes + data)))), kSix);
    EXPECT_EQ(values(read_volume(
                  folder.write("a.nii", n.set<float>(108, 368).bytes + std::string(16, 'e') + data))),
              kSix);
    n.set<float>(108, 0).bytes.replace(344, 4, std::string("ni1\0", 4));
    (void)folder.write("a.img", data);
    EXPECT_EQ(values(read_volume(folder.write("a.hdr", n.bytes))), kSix);
  }
}

TEST(Nifti, ScalingIsApplied) {
  const Folder folder;
  Nifti n;
  const std::string data = packed(kShorts);
  auto v = read_volume(folder.write("a.nii", n.set<float>(112, 0.5f).set<float>(116, 10).bytes + data));
  EXPECT_EQ(v.voxel_type(), VoxelType::f32);
  EXPECT_EQ(values(v), (std::vector<double>{10.5, 9, 160, 12, 12.5, -290}));
  v = read_volume(folder.write("a.nii", n.set<float>(112, 1).set<float>(116, 0).bytes + data));
  EXPECT_EQ(v.voxel_type(), VoxelType::i16);
  n.set<std::int16_t>(70, 8).set<float>(112, 2);
  v = read_volume(folder.write("a.nii", n.bytes + packed(std::vector<std::int32_t>{1, 2, 3, 4, 5, 1 << 30})));
  EXPECT_EQ(v.voxel_type(), VoxelType::f64);
  EXPECT_EQ(values(v).back(), 2147483648.0);
}

TEST(Nifti, SformThenQform) {
  const Folder folder;
  Nifti n;
  const std::string data = packed(kShorts);
  // A quarter turn about z, (b, c, d) = (0, 0, sin 45 degrees), origin (7, 8, 9).
  n.set<std::int16_t>(252, 1)
      .set<float>(264, std::sqrt(0.5f))
      .set<float>(268, 7)
      .set<float>(272, 8)
      .set<float>(276, 9);
  auto g = read_volume(folder.write("a.nii", n.bytes + data)).geometry();
  EXPECT_EQ(g.space, Space::ras);
  EXPECT_LT((g.index_to_world({1, 1, 1}) - Vec3(7 - 1, 8 + 0.5, 9 + 1.5)).norm(),
            1e-6);  // the header holds floats
  g = read_volume(folder.write("a.nii", n.set<float>(76, -1).bytes + data)).geometry();
  EXPECT_LT((g.index_to_world({1, 1, 1}) - Vec3(7 - 1, 8 + 0.5, 9 - 1.5)).norm(), 1e-6);
  n.set<std::int16_t>(254, 1);
  const std::vector<float> rows = {-2, 0, 0, 10, 0, 0, 3, 20, 0, 4, 0, 30};
  for (std::size_t i = 0; i < rows.size(); ++i) n.set(280 + 4 * i, rows[i]);
  g = read_volume(folder.write("a.nii", n.bytes + data)).geometry();
  EXPECT_EQ(g.index_to_world({1, 1, 1}), Vec3(8, 23, 34));
  EXPECT_EQ(g.spacing, Vec3(2, 4, 3));
}

TEST(Nifti, OneVolumeOfSeveral) {
  const Folder folder;
  Nifti n;
  n.set<std::int16_t>(40, 4).set<std::int16_t>(48, 2);
  const auto path =
      folder.write("a.nii", n.bytes + packed(std::vector<std::int16_t>(6, 9)) + packed(kShorts));
  EXPECT_THAT(message_of(path), HasSubstr("holds 2 volumes; choose one with --volume 0 ... 1"));
  ReadOptions options;
  options.volume = 1;
  EXPECT_EQ(values(read_volume(path, options)), kSix);
  options.volume = 0;
  EXPECT_EQ(values(read_volume(path, options)), std::vector<double>(6, 9));
  options.volume = 2;
  EXPECT_THAT(message_of(path, options), HasSubstr("has no volume 2"));
}

}  // namespace
}  // namespace vol::io
