// Hand-made files of MetaImage's variants.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "read_files.h"

namespace vol::io {
namespace {

using volume::Space;

const std::string kMeta = "ObjectType = Image\nNDims = 3\nDimSize = 3 2 1\nElementType = MET_SHORT\n";

TEST(MetaImage, LocalOfBothByteOrdersCompressedAndAscii) {
  const Folder folder;
  for (const bool big : {false, true}) {
    const std::string head = kMeta + "BinaryDataByteOrderMSB = " + (big ? "True" : "False") + "\n";
    const std::string data = packed(kShorts, big);
    const std::string stream = zlibbed(data);
    EXPECT_EQ(values(read_volume(folder.write("a.mha", head + "ElementDataFile = LOCAL\n" + data))), kSix);
    EXPECT_EQ(values(read_volume(
                  folder.write("a.mha", head + "CompressedData = True\nElementDataFile = LOCAL\n" + stream))),
              kSix);
    EXPECT_EQ(values(read_volume(folder.write("a.mha", head + "CompressedData = True\nCompressedDataSize = " +
                                                           std::to_string(stream.size()) +
                                                           "\nElementDataFile = LOCAL\n" + stream))),
              kSix);
  }
  EXPECT_EQ(values(read_volume(folder.write(
                "a.mha", kMeta + "BinaryData = False\nElementDataFile = LOCAL\n1 -2 300 4 5 -600"))),
            kSix);
}

TEST(MetaImage, DataInOtherFiles) {
  const Folder folder;
  const std::string data = packed(kShorts);
  (void)folder.write("a.raw", "head" + data);
  (void)folder.write("a.zraw", zlibbed(data));
  EXPECT_EQ(values(read_volume(folder.write("a.mhd", kMeta + "HeaderSize = 4\nElementDataFile = a.raw\n"))),
            kSix);
  EXPECT_EQ(values(read_volume(folder.write("a.mhd", kMeta + "HeaderSize = -1\nElementDataFile = a.raw\n"))),
            kSix);
  EXPECT_EQ(
      values(read_volume(folder.write("a.mhd", kMeta + "CompressedData = True\nElementDataFile = a.zraw\n"))),
      kSix);
  for (int n = 0; n < 3; ++n) {
    (void)folder.write(
        "s" + std::to_string(n + 1),
        packed(std::vector<std::int16_t>(kShorts.begin() + 2 * n, kShorts.begin() + 2 * n + 2)));
  }
  const std::string slices = "NDims = 3\nDimSize = 2 1 3\nElementType = MET_SHORT\n";
  EXPECT_EQ(values(read_volume(folder.write("a.mhd", slices + "ElementDataFile = LIST\ns1\ns2\ns3\n"))),
            kSix);
  EXPECT_EQ(values(read_volume(folder.write("a.mhd", slices + "ElementDataFile = s%d 1 3 1\n"))), kSix);
  EXPECT_EQ(message_of(folder.write("a.mhd", kMeta + "ElementDataFile = a.raw\n")),
            (folder / "a.raw").string() + ": holds more than the 12 bytes that its header promises");
}

TEST(MetaImage, Geometry) {
  const Folder folder;
  const auto v =
      read_volume(folder.write("a.mha", kMeta +
                                            "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 1 2 "
                                            "3\nElementSpacing = 2 3 4\nAnatomicalOrientation = RAI\n"
                                            "Comment = hello\nElementDataFile = LOCAL\n" +
                                            packed(kShorts)));
  EXPECT_EQ(v.geometry().space, Space::lps);
  EXPECT_EQ(v.geometry().index_to_world({1, 1, 1}), Vec3(1 - 3, 2 + 2, 3 + 4));
  EXPECT_EQ(v.attributes.at("Comment"), "hello");
  const auto plain = read_volume(
      folder.write("a.mha", kMeta + "ElementSize = 2 3 4\nElementDataFile = LOCAL\n" + packed(kShorts)));
  EXPECT_EQ(plain.geometry().spacing, Vec3(2, 3, 4));
  EXPECT_EQ(plain.geometry().space, Space::none);
}

}  // namespace
}  // namespace vol::io
