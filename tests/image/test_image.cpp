#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "image/exposure.h"
#include "image/image.h"

namespace vol::image {
namespace {

TEST(Image, ChannelsAreFoundByName) {
  Image im(5, 3, {"R", "G", "B", "A", "samples"});
  im.at(4, 2, *im.channel("samples")) = 7;
  EXPECT_EQ(im.pixels.back(), 7);
  EXPECT_FALSE(im.channel("depth"));
}

TEST(Image, SizesAreChecked) {
  EXPECT_THROW(Image(0, 3, {"Y"}), Error);
  EXPECT_THROW(Image(100000, 3, {"Y"}), Error);
  EXPECT_THROW(Image(4, 3, {}), Error);
}

TEST(Image, PixelsAreAlikeWhateverTheSpareMemoryHeld) {
  const std::vector<float> pixel{1, 2, 3};
  for (const int width : {1, 40, 90}) {
    Image spare(width, 50, {"Y"});
    spare.pixels.assign(spare.pixels.size(), -5.0F);
    const float* const memory = spare.pixels.data();
    const Image im(11, 70, {"X", "Y", "Z"}, pixel, std::move(spare));
    ASSERT_EQ(im.pixels.size(), 3U * 11 * 70);
    for (std::size_t i = 0; i < im.pixels.size(); ++i) ASSERT_EQ(im.pixels[i], pixel[i % 3]);
    EXPECT_EQ(im.pixels.data() == memory, width == 90) << "memory is taken where it is large enough";
  }
  EXPECT_THROW(Image(4, 3, {"Y"}, pixel, Image()), Error);
}

TEST(Image, ExposureMakesTheLargestColourWhite) {
  Image im(3, 2, {"A", "R", "G", "B", "depth"});
  EXPECT_EQ(exposure_to_white(im), 1);    // black stays black
  im.at(0, 0, 0) = im.at(0, 0, 4) = 100;  // no colours
  im.at(2, 1, 1) = -8;
  im.at(2, 0, 2) = 0.25F;
  im.at(1, 1, 3) = 4;
  EXPECT_EQ(exposure_to_white(im), 0.25);
  im.at(1, 0, 1) = std::numeric_limits<float>::infinity();
  im.at(0, 1, 2) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(exposure_to_white(im), 0.25);
  EXPECT_THROW((void)exposure_to_white(Image(3, 2, {"Y"})), Error);
}

}  // namespace
}  // namespace vol::image
