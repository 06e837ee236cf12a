// Hand-made files of NRRD's variants.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "read_files.h"

namespace vol::io {
namespace {

using testing::HasSubstr;
using volume::Space;

const std::string kNrrd = "NRRD0004\n# a comment\ntype: short\ndimension: 3\nsizes: 3 2 1\n";

TEST(Nrrd, RawOfBothByteOrdersGzipAndAscii) {
  const Folder folder;
  for (const bool big : {false, true}) {
    const std::string head = kNrrd + "endian: " + (big ? "big" : "little") + "\n";
    const std::string data = packed(kShorts, big);
    EXPECT_EQ(values(read_volume(folder.write("a.nrrd", head + "encoding: raw\n\n" + data))), kSix);
    EXPECT_EQ(values(read_volume(folder.write("a.nrrd", head + "encoding: gzip\n\n" + gzipped(data)))), kSix);
    const std::string members = gzipped(data.substr(0, 5)) + gzipped(data.substr(5));
    EXPECT_EQ(values(read_volume(folder.write("a.nrrd", head + "encoding: gz\n\n" + members))), kSix);
  }
  EXPECT_EQ(values(read_volume(folder.write("a.nrrd", kNrrd + "encoding: ascii\n\n1 -2 300\n4 +5.0 -600\n"))),
            kSix);
}

TEST(Nrrd, LineAndByteSkips) {
  const Folder folder;
  const std::string head = kNrrd + "endian: little\n";
  const std::string data = packed(kShorts);
  EXPECT_EQ(values(read_volume(folder.write(
                "a.nrrd", head + "encoding: raw\nline skip: 2\nbyte skip: 3\n\nx\ny\nabc" + data))),
            kSix);
  EXPECT_EQ(
      values(read_volume(folder.write("a.nrrd", head + "encoding: raw\nbyte skip: -1\n\nwhatever" + data))),
      kSix);
  EXPECT_EQ(values(read_volume(
                folder.write("a.nrrd", head + "encoding: gzip\nbyteskip: 3\n\n" + gzipped("abc" + data)))),
            kSix);
  (void)folder.write("a.raw", "one\ntwo\nabc" + data);
  EXPECT_EQ(values(read_volume(folder.write(
                "a.nhdr", head + "encoding: raw\nline skip: 2\nbyte skip: 3\ndata file: a.raw\n"))),
            kSix);
  EXPECT_EQ(
      values(read_volume(folder.write("a.nhdr", head + "encoding: raw\nbyte skip: -1\ndata file: a.raw\n"))),
      kSix);
}

TEST(Nrrd, DetachedSlicesByPatternAndList) {
  const Folder folder;
  const std::string head =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 1 2 3\nendian: little\nencoding: raw\n";
  for (int n = 0; n < 3; ++n) {
    const std::vector<std::int16_t> slice(kShorts.begin() + 2 * n, kShorts.begin() + 2 * n + 2);
    (void)folder.write("s" + std::to_string(9 + n), packed(slice));
    (void)folder.write("p0" + std::to_string(30 - 10 * n) + ".raw", packed(slice));
  }
  EXPECT_EQ(values(read_volume(folder.write("a.nhdr", head + "data file: s%d 9 11 1\n"))), kSix);
  EXPECT_EQ(values(read_volume(folder.write("a.nhdr", head + "data file: p%03d.raw 30 10 -10 2\n"))), kSix);
  EXPECT_EQ(values(read_volume(folder.write("a.nhdr", head + "data file: LIST\ns9\ns10\ns11\n"))), kSix);
  EXPECT_THAT(message_of(folder.write("a.nhdr", head + "data file: s%d 9 12 1\n")),
              HasSubstr("expected 3 of them"));
  EXPECT_THAT(message_of(folder.write("a.nhdr", head + "data file: LIST\ns9\ns10\nmissing\n")),
              HasSubstr("missing: cannot read"));
  (void)folder.write("s10", "abc");
  EXPECT_THAT(message_of(folder / "a.nhdr"), testing::MatchesRegex(".*/s10: data ends after 3 of 4 bytes"));
  (void)folder.write("s10", "abcde");
  EXPECT_THAT(message_of(folder / "a.nhdr"), HasSubstr("s10: holds more than the 4 bytes"));
}

volume::GridGeometry nrrd_geometry(const Folder& folder, const std::string& fields, int dimension = 3,
                                   const std::string& sizes = "3 2 1") {
  return read_volume(folder.write("g.nrrd", "NRRD0004\ntype: int8\ndimension: " + std::to_string(dimension) +
                                                "\nsizes: " + sizes + "\nencoding: raw\n" + fields +
                                                "\nabcdef"))
      .geometry();
}

TEST(Nrrd, GeometryFromDirections) {
  const Folder folder;
  const auto g =
      nrrd_geometry(folder,
                    "space: right-anterior-superior\nspace directions: (0,2,0) (-3,0,0) (0, 0, -4)\n"
                    "space origin: (1,2.5,-3)\n");
  EXPECT_EQ(g.space, Space::ras);
  EXPECT_EQ(g.spacing, Vec3(2, 3, 4));
  EXPECT_EQ(g.origin, Vec3(1, 2.5, -3));
  EXPECT_EQ(g.index_to_world({1, 1, 1}), Vec3(1 - 3, 2.5 + 2, -3 - 4));
  // LAS is RAS with x turned.
  const auto las =
      nrrd_geometry(folder, "space: LAS\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)\n");
  EXPECT_EQ(las.space, Space::ras);
  EXPECT_EQ(las.index_to_world({1, 1, 0}), Vec3(-3, 5, 3));
}

TEST(Nrrd, GeometryFromSpacingsAndAxisMinima) {
  const Folder folder;
  auto g = nrrd_geometry(folder, "spacings: 0.5 2 nan\n");
  EXPECT_EQ(g.spacing, Vec3(0.5, 2, 1));
  EXPECT_EQ(g.space, Space::none);
  // Three cells from 10 to 16: samples at 11, 13, 15. Two nodes from 1 to 4. An axis that says nothing.
  g = nrrd_geometry(folder, "axis mins: 10 1 nan\naxis maxs: 16 4 nan\ncenterings: cell node none\n");
  EXPECT_EQ(g.spacing, Vec3(2, 3, 1));
  EXPECT_EQ(g.origin, Vec3(11, 1, 0));
}

TEST(Nrrd, SpacingsArePositiveAndKnownForAllAxesOrNone) {
  const Folder folder;
  const auto message = [&](const std::string& fields, const std::string& sizes = "3 2 1") {
    try {
      (void)nrrd_geometry(folder, fields, 3, sizes);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  for (const char* bad : {"0.5 0 1", "0.5 -2 1", "0.5 inf 1", "0.5 -inf 1", "0.5 -nan 1", "0.5 1e999 1"}) {
    EXPECT_THAT(message(std::string("spacings: ") + bad + "\n"), HasSubstr("spacing")) << bad;
  }
  EXPECT_THAT(message("spacings: 0.5 nan 1\n"), HasSubstr("the spacing along y is not known (nan)"));
  EXPECT_THAT(message("spacings: nan 2 2\n", "1 2 3"), HasSubstr("accepted"));
  EXPECT_THAT(message("axis mins: 10 nan 0\naxis maxs: 16 4 1\n"),
              HasSubstr("the spacing along y is not known"));
  // None is known: what a file without spacings means. One that min and max tell is known.
  EXPECT_EQ(nrrd_geometry(folder, "spacings: nan NaN nan\n").spacing, Vec3(1, 1, 1));
  EXPECT_EQ(nrrd_geometry(folder, "spacings: 0.5 nan nan\naxis mins: 0 0 0\naxis maxs: 9 8 7\n").spacing,
            Vec3(0.5, 4, 7));
}

TEST(Nrrd, AxesOfOneSampleAreDroppedDownToThree) {
  const Folder folder;
  EXPECT_EQ(nrrd_geometry(folder, "", 4, "1 3 2 1").dims, (Dims{3, 2, 1}));
  EXPECT_EQ(nrrd_geometry(folder, "", 4, "3 2 1 1").dims, (Dims{3, 2, 1}));
  EXPECT_EQ(nrrd_geometry(folder, "", 2, "2 3").dims, (Dims{2, 3, 1}));
  EXPECT_EQ(nrrd_geometry(folder, "", 1, "6").dims, (Dims{6, 1, 1}));
  const auto g =
      nrrd_geometry(folder, "space: LPS\nspace directions: none (1,0,0) (0,2,0) (0,0,3)\n", 4, "1 1 2 3");
  EXPECT_EQ(g.dims, (Dims{1, 2, 3}));
  EXPECT_EQ(g.spacing, Vec3(1, 2, 3));
  // Two directions: the third axis stands at right angles to them.
  const auto flat = nrrd_geometry(folder, "space: LPS\nspace directions: (0,2,0) (0,0,3)\n", 2, "2 3");
  EXPECT_EQ(flat.direction.col(2), Vec3(1, 0, 0));
}

TEST(Nrrd, AttributesAndContent) {
  const Folder folder;
  const auto v = read_volume(folder.write("a.nrrd",
                                          "NRRD0005\ntype: uchar\ncontent: a: head\ndimension: 3\nsizes: 1 1 "
                                          "1\nencoding: raw\nkey:=value: x:=y\nk\\n2:=a\\\\b\\nc\n\n!"));
  EXPECT_EQ(v.attributes, (std::map<std::string, std::string>{
                              {"content", "a: head"}, {"key", "value: x:=y"}, {"k\n2", "a\\b\nc"}}));
}

}  // namespace
}  // namespace vol::io
