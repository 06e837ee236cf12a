#include <gtest/gtest.h>

#include "base/error.h"
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

}  // namespace
}  // namespace vol::image
