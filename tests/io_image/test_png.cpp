#include "io/png.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/rng.h"
#include "io/write_image.h"
#include "io_image/temporary_folder.h"

namespace vol::io {
namespace {

using image::Image;

TEST(Srgb, ValuesOfTheStandard) {
  EXPECT_EQ(srgb_from_linear(0), 0);
  EXPECT_DOUBLE_EQ(srgb_from_linear(1), 1);
  EXPECT_DOUBLE_EQ(srgb_from_linear(0.001), 0.01292);
  // 1.055 0.5^(1/2.4) - 0.055 and 1.055 0.18^(1/2.4) - 0.055, computed with 20 digits elsewhere
  EXPECT_NEAR(srgb_from_linear(0.5), 0.73535698305, 1e-10);
  EXPECT_NEAR(srgb_from_linear(0.18), 0.46135612950, 1e-10);
}

TEST(Srgb, TheInverseInverts) {
  // The standard's two rounded thresholds leave a gap of 3e-8 in the slope's neighbourhood, hence not 1e-15.
  for (double s = -1.5; s <= 1.5; s += 1.0 / 512)
    EXPECT_NEAR(srgb_from_linear(linear_from_srgb(s)), s, 1e-7) << s;
}

TEST(Png, EveryCodeComesBack) {
  const TemporaryFolder folder;
  for (const int bits : {8, 16}) {
    const int codes = bits == 8 ? 256 : 65536;
    Image image(256, codes / 256, {"R", "G", "B"});
    for (int n = 0; n < codes; ++n) {
      for (int c = 0; c < 3; ++c) {
        const double code = static_cast<double>((n * (1 + 2 * c)) % codes) / (codes - 1);
        image.at(n % 256, n / 256, c) = static_cast<float>(linear_from_srgb(code));
      }
    }
    write_png(folder / "a.png", image, {.bits = bits});
    const Image raw = read_png(folder / "a.png", CodeValues::raw);
    const Image back = read_png(folder / "a.png");
    for (int n = 0; n < codes; ++n) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(std::lround(raw.at(n % 256, n / 256, c) * static_cast<float>(codes - 1)),
                  (n * (1 + 2 * c)) % codes);
        ASSERT_EQ(back.at(n % 256, n / 256, c), image.at(n % 256, n / 256, c));
      }
    }
  }
}

TEST(Png, CompositesScalesAndClamps) {
  const TemporaryFolder folder;
  Image image(4, 1, {"R", "G", "B", "A"});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> pixels{0.25f, 0, 0, 0.5f, 9, -1, inf, 1, 0, nan, 0, 1, 0, 0, 0, 0};
  std::copy(pixels.begin(), pixels.end(), image.pixels.begin());
  write_png(folder / "a.png", image, {.background = {1, 0.5, 0}, .scale = 0.5});
  const Image raw = read_png(folder / "a.png", CodeValues::raw);
  const auto code = [&](int x, int c) { return std::lround(raw.at(x, 0, c) * 255); };
  const auto srgb = [](double linear) { return std::lround(255 * srgb_from_linear(linear)); };
  EXPECT_EQ(code(0, 0), srgb(0.5 * (0.25 + 0.5 * 1)));
  EXPECT_EQ(code(0, 1), srgb(0.5 * (0.5 * 0.5)));
  EXPECT_EQ(code(0, 2), 0);
  EXPECT_EQ(code(1, 0), 255);
  EXPECT_EQ(code(1, 1), 0);
  EXPECT_EQ(code(1, 2), 255);
  EXPECT_EQ(code(2, 0), 255);  // NaN is magenta
  EXPECT_EQ(code(2, 1), 0);
  EXPECT_EQ(code(2, 2), 255);
  EXPECT_EQ(code(3, 1), srgb(0.25));
  EXPECT_FALSE(raw.channel("A"));
}

TEST(Png, GreyAndAttributes) {
  const TemporaryFolder folder;
  Image image(3, 2, {"Y", "depth"});
  image.at(2, 1, 0) = 1;
  image.attributes = {{"precis.tool", "vol-raycast"}, {"precis.options", "{\"note\":\"Büste\"}"}};
  write_image(folder / "a.png", image);
  const Image back = read_png(folder / "a.png");
  EXPECT_EQ(back.attributes, image.attributes);
  EXPECT_THAT(back.channels, testing::ElementsAre("R", "G", "B"));
  for (int c = 0; c < 3; ++c) EXPECT_EQ(back.at(2, 1, c), 1);
  EXPECT_THROW(write_image(folder / "b.png", Image(2, 2, {"depth"})), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "b.png"));
}

TEST(Png, SameImageSameBytes) {
  const TemporaryFolder folder;
  Image image(41, 23, {"R", "G", "B"});
  Rng rng(4);
  for (float& value : image.pixels) value = static_cast<float>(rng.uniform());
  write_png(folder / "a.png", image);
  write_png(folder / "b.png", image);
  EXPECT_EQ(bytes_of(folder / "a.png"), bytes_of(folder / "b.png"));
}

TEST(Png, TruncatedOrGarbledIsReadOrRefused) {
  const TemporaryFolder folder;
  write_png(folder / "a.png", Image(30, 20, {"Y"}));
  const auto whole = bytes_of(folder / "a.png");
  for (std::size_t n = 0; n < whole.size(); ++n) {
    put_bytes(folder / "cut.png", {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)});
    EXPECT_THROW((void)read_png(folder / "cut.png"), Error) << n;
  }
  Rng rng(8);
  int refused = 0;
  for (int n = 0; n < 500; ++n) {
    auto bytes = whole;
    bytes[rng.below(bytes.size())] = static_cast<char>(rng.next());
    put_bytes(folder / "garbled.png", bytes);
    try {
      (void)read_png(folder / "garbled.png");
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 250);  // every chunk carries a checksum
}

TEST(Png, APromiseOfMorePixelsThanTheFileHoldsIsRefused) {
  const TemporaryFolder folder;
  // Signature, then an IHDR of 65536 x 65536 RGB with its checksum, then an empty IDAT and IEND.
  const unsigned char bytes[] = {
      0x89, 'P', 'N', 'G',  13,   10,   26,   10, 0, 0, 0,    13,   'I',  'H',  'D', 'R',  0,    1,    0,
      0,    0,   1,   0,    0,    8,    2,    0,  0, 0, 0xe3, 0xe6, 0xa7, 0xb4, 0,   0,    0,    0,    'I',
      'D',  'A', 'T', 0x35, 0xaf, 0x06, 0x1e, 0,  0, 0, 0,    'I',  'E',  'N',  'D', 0xae, 0x42, 0x60, 0x82};
  put_bytes(folder / "big.png",
            {reinterpret_cast<const char*>(bytes), reinterpret_cast<const char*>(bytes) + sizeof bytes});
  try {
    (void)read_png(folder / "big.png");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("65536x65536"));
  }
}

TEST(Png, AChunkLongerThanTheFileIsRefusedBeforeMemoryIsTaken) {
  const TemporaryFolder folder;
  Image image(3, 2, {"Y"});
  image.attributes["precis.tool"] = "x";
  write_png(folder / "a.png", image);
  auto bytes = bytes_of(folder / "a.png");
  const std::size_t at = std::string(bytes.begin(), bytes.end()).find("iTXt");
  ASSERT_NE(at, std::string::npos);
  bytes[at - 4] = 0x1c;  // its length, most significant byte first: 469 MB
  put_bytes(folder / "long.png", bytes);
  try {
    (void)read_png(folder / "long.png");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("a chunk of 4697"));
  }
}

TEST(WriteImage, TheFormatIsKnownBeforeTheWork) {
  EXPECT_THROW(require_image_format("a.jpg"), Error);
  EXPECT_THROW(require_image_format("a.png", "tiff"), Error);
  EXPECT_NO_THROW(require_image_format("a.jpg", "png"));
  EXPECT_NO_THROW(require_image_format("-"));
}

}  // namespace
}  // namespace vol::io
