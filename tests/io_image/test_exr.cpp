#include "io/exr.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "io_image/temporary_folder.h"

namespace vol::io {
namespace {

using image::Image;

/// Any bit pattern a float can have, NaN payloads included.
Image arbitrary_image(int width, int height, std::vector<std::string> channels, std::uint64_t seed) {
  Image image(width, height, std::move(channels));
  Rng rng(seed);
  for (float& value : image.pixels) value = std::bit_cast<float>(static_cast<std::uint32_t>(rng.next()));
  return image;
}

void expect_same_bits(const Image& a, const Image& b) {
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  ASSERT_EQ(a.channels.size(), b.channels.size());
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    const auto other = b.channel(a.channels[c]);
    ASSERT_TRUE(other) << a.channels[c];
    for (int y = 0; y < a.height; ++y) {
      for (int x = 0; x < a.width; ++x) {
        ASSERT_EQ(std::bit_cast<std::uint32_t>(a.at(x, y, static_cast<int>(c))),
                  std::bit_cast<std::uint32_t>(b.at(x, y, *other)))
            << a.channels[c] << " at " << x << "," << y;
      }
    }
  }
}

TEST(Exr, EveryBitOfEveryChannelComesBack) {
  const TemporaryFolder folder;
  const std::vector<std::vector<std::string>> sets{{"Y"},
                                                   {"R", "G", "B"},
                                                   {"R", "G", "B", "A", "samples", "depth", "error"},
                                                   {"error", "A", "layer.one", "B", "R", "G"}};
  const std::vector<std::pair<int, int>> sizes{{1, 1}, {1, 37}, {53, 1}, {17, 16}, {31, 33}, {129, 65}};
  std::uint64_t seed = 1;
  for (const auto& channels : sets) {
    for (const auto& [width, height] : sizes) {
      const Image image = arbitrary_image(width, height, channels, ++seed);
      write_exr(folder / "a.exr", image);
      expect_same_bits(image, read_exr(folder / "a.exr"));
    }
  }
  std::vector<std::string> many;
  for (int n = 0; n < 40; ++n) many.push_back("channel" + std::to_string(n));
  const Image image = arbitrary_image(19, 23, many, 99);
  write_exr(folder / "many.exr", image);
  expect_same_bits(image, read_exr(folder / "many.exr"));
}

TEST(Exr, ColourComesFirst) {
  const TemporaryFolder folder;
  write_exr(folder / "a.exr", Image(3, 2, {"depth", "A", "B", "C", "G", "R"}));
  EXPECT_THAT(read_exr(folder / "a.exr").channels, testing::ElementsAre("R", "G", "B", "A", "C", "depth"));
}

TEST(Exr, AttributesComeBackAndNoneIsAdded) {
  const TemporaryFolder folder;
  Image image(3, 2, {"Y"});
  image.attributes = {{"precis.tool", "vol-raycast"},
                      {"precis.options", R"({"step":"0.5v","view":[30,20]})"},
                      {"an attribute with a name longer than the thirty-one characters of old", "x"},
                      {"empty", ""},
                      {"unicode", "Büste"}};
  write_exr(folder / "a.exr", image);
  EXPECT_EQ(read_exr(folder / "a.exr").attributes, image.attributes);
  image.attributes = {{"dataWindow", "0"}};
  EXPECT_THROW(write_exr(folder / "a.exr", image), Error);
}

TEST(Exr, SameImageSameBytesWhateverTheThreads) {
  const TemporaryFolder folder;
  const Image image =
      arbitrary_image(601, 700, {"R", "G", "B"}, 5);  // large enough to be written in parallel
  write_exr(folder / "a.exr", image);
  set_thread_count(1);
  write_exr(folder / "b.exr", image);
  set_thread_count(0);
  EXPECT_EQ(bytes_of(folder / "a.exr"), bytes_of(folder / "b.exr"));
}

/// One half, one float and one UINT channel, as other programs write them.
void write_foreign(const std::filesystem::path& path, Imf::Compression compression, bool tiled, int width,
                   int height, std::uint32_t integer, int first_row = 0) {
  Imf::Header header(Imath::Box2i({0, 0}, {width - 1, height - 1}),
                     Imath::Box2i({0, first_row}, {width - 1, height - 1}));
  header.compression() = compression;
  header.channels().insert("R", Imf::Channel(Imf::HALF));
  header.channels().insert("depth", Imf::Channel(Imf::FLOAT));
  header.channels().insert("id", Imf::Channel(Imf::UINT));
  const auto n = static_cast<std::size_t>(width * height);
  std::vector<Imath::half> half(n);
  std::vector<float> depth(n);
  std::vector<std::uint32_t> id(n, integer);
  for (std::size_t k = 0; k < n; ++k) {
    half[k] = Imath::half(static_cast<float>(k % 1000) / 8);
    depth[k] = static_cast<float>(k) * 0.25f;
  }
  const auto w = static_cast<std::size_t>(width);
  Imf::FrameBuffer frame;
  frame.insert("R", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(half.data()), 2, 2 * w));
  frame.insert("depth", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(depth.data()), 4, 4 * w));
  frame.insert("id", Imf::Slice(Imf::UINT, reinterpret_cast<char*>(id.data()), 4, 4 * w));
  if (tiled) {
    header.setTileDescription(Imf::TileDescription(16, 24, Imf::MIPMAP_LEVELS));
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(frame);
    for (int level = 0; level < file.numLevels(); ++level) {
      file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    }
  } else {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(height - first_row);
  }
}

void expect_foreign(const Image& image, float integer) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int k = y * image.width + x;
      ASSERT_EQ(image.at(x, y, *image.channel("R")), static_cast<float>(k % 1000) / 8) << x << "," << y;
      ASSERT_EQ(image.at(x, y, *image.channel("depth")), static_cast<float>(k) * 0.25f) << x << "," << y;
      ASSERT_EQ(image.at(x, y, *image.channel("id")), integer) << x << "," << y;
    }
  }
}

TEST(Exr, OtherProgramsFilesAreRead) {
  const TemporaryFolder folder;
  for (const auto compression : {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION,
                                 Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
    for (const bool tiled : {false, true}) {
      SCOPED_TRACE(std::to_string(compression) + (tiled ? " tiled" : " scan lines"));
      write_foreign(folder / "f.exr", compression, tiled, 77, 53, 16777216);
      const Image image = read_exr(folder / "f.exr");
      EXPECT_EQ(image.width, 77);
      EXPECT_EQ(image.height, 53);
      expect_foreign(image, 16777216.0f);
    }
  }
}

void expect_refused(const std::filesystem::path& path, const std::string& why) {
  try {
    (void)read_exr(path);
    FAIL() << "was read, expected: " << why;
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(path.string()));
    EXPECT_THAT(error.what(), testing::HasSubstr(why));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
  }
}

TEST(Exr, WhatFloatCannotHoldIsRefused) {
  const TemporaryFolder folder;
  write_foreign(folder / "f.exr", Imf::ZIP_COMPRESSION, false, 20, 20, 16777217);
  expect_refused(folder / "f.exr", "float cannot hold");
}

TEST(Exr, ACroppedDataWindowIsRefused) {
  const TemporaryFolder folder;
  write_foreign(folder / "f.exr", Imf::ZIP_COMPRESSION, false, 20, 20, 1, 5);
  expect_refused(folder / "f.exr", "data window");
}

TEST(Exr, TruncatedAtAnyByteIsRefused) {
  const TemporaryFolder folder;
  write_exr(folder / "a.exr", arbitrary_image(13, 40, {"R", "G", "B"}, 3));
  const auto whole = bytes_of(folder / "a.exr");
  for (std::size_t n = 0; n < whole.size(); n += 1 + n / 40) {
    put_bytes(folder / "cut.exr", {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)});
    EXPECT_THROW((void)read_exr(folder / "cut.exr"), Error) << n << " of " << whole.size() << " bytes";
  }
}

TEST(Exr, GarbledBytesAreReadOrRefused) {
  const TemporaryFolder folder;
  Image image(33, 40, {"R", "G", "B", "A"});
  image.attributes["precis.tool"] = "test";
  write_exr(folder / "a.exr", image);
  const auto whole = bytes_of(folder / "a.exr");
  Rng rng(8);
  int refused = 0;
  for (int n = 0; n < 2000; ++n) {
    auto bytes = whole;
    for (int k = 0; k < 3; ++k) bytes[rng.below(bytes.size())] = static_cast<char>(rng.next());
    try {
      (void)decode_exr(std::as_bytes(std::span(bytes)), "garbled");
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
}

TEST(Exr, APromiseOfMorePixelsThanTheFileHoldsIsRefused) {
  const TemporaryFolder folder;
  write_exr(folder / "a.exr", Image(4, 4, {"Y"}));
  auto bytes = bytes_of(folder / "a.exr");
  const std::string text(bytes.begin(), bytes.end());
  for (const char* window : {"dataWindow", "displayWindow"}) {
    const std::size_t at = text.find(window);
    ASSERT_NE(at, std::string::npos);
    const std::size_t values = at + std::string(window).size() + 1 + std::string("box2i").size() + 1 + 4;
    const std::int32_t far = 65535;
    std::memcpy(bytes.data() + values + 8, &far, 4);
    std::memcpy(bytes.data() + values + 12, &far, 4);
  }
  put_bytes(folder / "big.exr", bytes);
  expect_refused(folder / "big.exr", "65536x65536");
}

TEST(Exr, WhatIsNoExrIsNamed) {
  const TemporaryFolder folder;
  put_bytes(folder / "text.exr", {'h', 'e', 'l', 'l', 'o'});
  expect_refused(folder / "text.exr", "not an OpenEXR file");
  put_bytes(folder / "empty.exr", {});
  expect_refused(folder / "empty.exr", "not an OpenEXR file");
  expect_refused(folder / "absent.exr", "");
}

}  // namespace
}  // namespace vol::io
