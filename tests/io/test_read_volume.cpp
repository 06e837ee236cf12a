// What holds for every format alike.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "read_files.h"

namespace vol::io {
namespace {

using testing::HasSubstr;
using volume::VoxelType;

const std::string kNrrd =
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 1\nendian: little\nencoding: raw\n\n";

TEST(ReadVolume, NonFiniteVoxelsAreRefusedOrReplaced) {
  const Folder folder;
  const auto path = folder.write(
      "a.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 3 2 1\nencoding: ascii\n\n1 nan 3 inf 5 -inf");
  const std::string message = message_of(path);
  EXPECT_EQ(message.find(path.string() + ": 3 voxels are NaN or infinite, the first at (1,0,0)"), 0U)
      << message;
  ReadOptions options;
  options.missing = -1;
  EXPECT_EQ(values(read_volume(path, options)), (std::vector<double>{1, -1, 3, -1, 5, -1}));
}

TEST(ReadVolume, MemoryLimitIsRespected) {
  const Folder folder;
  const auto path = folder.write("a.nrrd", kNrrd + packed(kShorts));
  ReadOptions options;
  options.memory_limit = 11;
  EXPECT_THAT(message_of(path, options), HasSubstr("3 x 2 x 1 voxels need 12 bytes, more than the 11"));
}

TEST(ReadVolume, AChoiceThatTheFormatDoesNotHaveIsRefused) {
  const Folder folder;
  const auto nrrd = folder.write("a.nrrd", kNrrd + packed(kShorts));
  const auto meta = folder.write("a.mha",
                                 "ObjectType = Image\nNDims = 3\nDimSize = 3 2 1\nElementType = MET_SHORT\n"
                                 "ElementDataFile = LOCAL\n" +
                                     packed(kShorts));
  ReadOptions first;
  first.volume = 0;
  for (const auto& path : {nrrd, meta}) {
    EXPECT_EQ(values(read_volume(path)), kSix);
    EXPECT_THAT(message_of(path, {.array = "density"}), HasSubstr("has no arrays by name"));
    EXPECT_THAT(message_of(path, first), HasSubstr("has no numbered volumes"));
  }
  ReadOptions raw;
  raw.raw = RawLayout{.dims = {3, 2, 1}, .type = VoxelType::i16};
  const auto headerless = folder.write("a.raw", packed(kShorts));
  EXPECT_EQ(values(read_volume(headerless, raw)), kSix);
  raw.array = "density";
  EXPECT_THAT(message_of(headerless, raw), HasSubstr("has no arrays by name"));
}

}  // namespace
}  // namespace vol::io
