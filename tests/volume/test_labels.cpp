#include "volume/labels.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace vol::volume {
namespace {

using ::testing::HasSubstr;

template <class T>
Volume holding(VoxelType type, const std::vector<T>& values) {
  GridGeometry g;
  g.dims = {static_cast<std::int64_t>(values.size()) / 2, 2, 1};
  Volume volume = allocate(type, g);
  std::copy(values.begin(), values.end(), std::get<Grid<T>>(volume.grid).voxels.begin());
  return volume;
}

TEST(Labels, WholeNumbersOfAnyTypeAreLabels) {
  const std::vector<std::uint8_t> expected{0, 3, 255, 3};
  const auto same = [&](const Volume& volume) {
    const auto labels = label_grid(volume);
    EXPECT_EQ(std::vector<std::uint8_t>(labels.voxels.begin(), labels.voxels.end()), expected);
    EXPECT_EQ(labels.geometry, volume.geometry());
    EXPECT_EQ(labels_in(labels), (std::vector<int>{0, 3, 255}));
  };
  same(holding<std::uint8_t>(VoxelType::u8, {0, 3, 255, 3}));
  same(holding<std::int16_t>(VoxelType::i16, {0, 3, 255, 3}));
  same(holding<float>(VoxelType::f32, {0, 3, 255, 3}));
}

TEST(Labels, OthersAreRefusedWithTheirPlace) {
  const auto refusal = [](const Volume& volume) -> std::string {
    try {
      (void)label_grid(volume);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal(holding<std::int16_t>(VoxelType::i16, {0, 1, 2, 256})), HasSubstr("(1, 1, 0) is 256"));
  EXPECT_THAT(refusal(holding<std::int16_t>(VoxelType::i16, {-1, 1, 2, 3})), HasSubstr("(0, 0, 0) is -1"));
  EXPECT_THAT(refusal(holding<float>(VoxelType::f32, {0, 1, 2.5F, 3})), HasSubstr("(0, 1, 0) is 2.5"));
  EXPECT_THAT(refusal(holding<float>(VoxelType::f32, {0, NAN, 2, 3})), HasSubstr("(1, 0, 0) is nan"));
}

TEST(Labels, IndicatorsOfAllLabelsSumToOne) {
  const auto labels = label_grid(holding<std::uint8_t>(VoxelType::u8, {0, 3, 7, 3, 0, 7}));
  std::vector<int> sum(6, 0);
  for (const int label : labels_in(labels)) {
    const Volume share = indicator(labels, label);
    const auto& voxels = std::get<Grid<std::uint8_t>>(share.grid).voxels;
    for (std::size_t n = 0; n < sum.size(); ++n) sum[n] += voxels[n];
  }
  EXPECT_EQ(sum, std::vector<int>(6, 1));
}

}  // namespace
}  // namespace vol::volume
