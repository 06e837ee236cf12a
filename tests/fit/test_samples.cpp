#include <gtest/gtest.h>

#include "base/error.h"
#include "fit/samples.h"

namespace vol::fit {
namespace {

template <class T>
volume::Volume volume_of(const std::vector<double>& values) {
  volume::Grid<T> grid;
  grid.geometry.dims = {static_cast<std::int64_t>(values.size()), 1, 1};
  grid.voxels = Buffer<T>(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) grid.voxels[i] = static_cast<T>(values[i]);
  volume::Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

TEST(Samples, IntegersCountAtTheirOwnValues) {
  const auto samples = histogram_samples(volume_of<std::int16_t>({-5, -5, 0, 3, 3, 3, 900, -90}), {-5, 15}, 7,
                                         Weighting::histogram);
  EXPECT_EQ(samples.v, (std::vector<double>{0, 0.25, 0.4, 1}));  // what lies outside counts at the ends
  EXPECT_EQ(samples.weight, (std::vector<double>{3 / 8.0, 1 / 8.0, 3 / 8.0, 1 / 8.0}));
  const auto logarithmic =
      histogram_samples(volume_of<std::int16_t>({0, 1, 1, 1}), {0, 1}, 7, Weighting::log_histogram);
  EXPECT_DOUBLE_EQ(logarithmic.weight[1] / logarithmic.weight[0], std::log(4) / std::log(2));
}

// A band of one integer has that integer, whatever v and the range make of it: (k - min)/(max - min) and back
// misses it for some k.
TEST(Samples, IntegersAreWithinTheBandsThatEndAtThem) {
  for (const auto& [least, most] : {std::pair{0, 2000}, {-100, 200}}) {
    std::vector<double> values;
    for (int k = least; k <= most; ++k) values.push_back(k);
    const auto samples = histogram_samples(volume_of<std::int16_t>(values), {double(least), double(most)}, 16,
                                           Weighting::histogram);
    int rounded = 0;
    for (int k = least; k <= most; ++k) {
      const auto within = samples.targets([k](double value) { return value >= k && value <= k ? 1.0 : 0.0; });
      const auto i = static_cast<std::size_t>(k - least);
      ASSERT_EQ(within[i], 1) << k;
      if (least + samples.v[i] * (most - least) != k) ++rounded;
    }
    EXPECT_GT(rounded, 0);  // or v would do
  }
}

TEST(Samples, OtherNumbersCountInBins) {
  const auto samples =
      histogram_samples(volume_of<float>({0.1, 0.2, 0.9, 5}), {0, 1}, 2, Weighting::histogram);
  EXPECT_EQ(samples.v, (std::vector<double>{0.25, 0.75}));
  EXPECT_EQ(samples.weight, (std::vector<double>{0.5, 0.5}));
}

// Three bins of a range of four doubles: the middles of the last two are one double.
TEST(Samples, BinsWithOneMiddleCountTogether) {
  const auto samples = histogram_samples(volume_of<double>({1e16, 1e16 + 2, 1e16 + 4, 1e16 + 6}),
                                         {1e16, 1e16 + 6}, 3, Weighting::histogram);
  EXPECT_EQ(samples.value, (std::vector<double>{1e16, 1e16 + 4}));
  EXPECT_EQ(samples.weight, (std::vector<double>{0.25, 0.75}));
}

TEST(Samples, NothingToCountIsRefused) {
  EXPECT_THROW((void)uniform_samples({0, 1}, 0), Error);
  EXPECT_THROW((void)uniform_samples({1, 1}, 5), Error);
  EXPECT_THROW((void)histogram_samples(volume_of<float>({1, 1}), {1, 1}, 5, Weighting::histogram), Error);
  EXPECT_THROW((void)histogram_samples(volume_of<float>({1, std::nan("")}), {0, 1}, 5, Weighting::histogram),
               Error);
  EXPECT_THROW((void)weighting_from_name("loud"), Error);
}

// A constant volume has one value that counts.
TEST(Samples, AConstantVolumeIsOneSample) {
  const auto samples =
      histogram_samples(volume_of<std::uint8_t>({7, 7, 7}), {0, 14}, 5, Weighting::histogram);
  EXPECT_EQ(samples.v, std::vector<double>{0.5});
}

}  // namespace
}  // namespace vol::fit
