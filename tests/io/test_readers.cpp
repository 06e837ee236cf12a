// Hand-made files of each format's variants.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "files.h"

namespace vol::io {
namespace {

using testing::HasSubstr;
using volume::Space;
using volume::Volume;
using volume::VoxelType;

const std::vector<double> kSix = {1, -2, 300, 4, 5, -600};
const std::vector<std::int16_t> kShorts = {1, -2, 300, 4, 5, -600};

std::string message_of(const std::filesystem::path& path, const ReadOptions& options = {}) {
  try {
    (void)read_volume(path, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

// ---------------------------------------------------------------------------------------------------- NRRD

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

// ----------------------------------------------------------------------------------------------------
// MetaImage

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

// ---------------------------------------------------------------------------------------------------- VTI

std::string vti(const std::string& file_attributes, const std::string& data, const std::string& appended = {},
                const std::string& image = R"(WholeExtent="0 2 0 1 0 0" Origin="1 2 3" Spacing="0.5 2 4")") {
  return "<?xml version=\"1.0\"?>\n<!-- a > comment -->\n<VTKFile type=\"ImageData\" " + file_attributes +
         ">\n<ImageData " + image + ">\n<Piece>\n" + data + "</Piece>\n</ImageData>\n" + appended +
         "</VTKFile>\n";
}
std::string point_array(const std::string& attributes, const std::string& text) {
  return "<PointData>\n<DataArray type=\"Int16\" Name=\"a\" " + attributes + ">\n" + text +
         "\n</DataArray></PointData>\n";
}

TEST(Vti, EveryEncoding) {
  const Folder folder;
  EXPECT_EQ(values(read_volume(
                folder.write("a.vti", vti("", point_array("format='ascii'", "1 -2 300\n 4 5 -600"))))),
            kSix);
  for (const bool big : {false, true}) {
    for (const bool wide : {false, true}) {
      const std::string head = std::string("byte_order=\"") + (big ? "BigEndian" : "LittleEndian") + "\" " +
                               (wide ? "header_type=\"UInt64\"" : "");
      const auto words = [&](std::vector<std::uint64_t> n) {
        return wide ? packed(n, big) : packed(std::vector<std::uint32_t>(n.begin(), n.end()), big);
      };
      const std::string data = packed(kShorts, big);
      const std::string plain = words({12}) + data;
      const std::string first = zlibbed(data.substr(0, 8)), second = zlibbed(data.substr(8));
      const std::string counts = words({2, 8, 4, first.size(), second.size()});
      const std::string whole_blocks =
          words({2, 6, 0, zlibbed(data.substr(0, 6)).size(), zlibbed(data.substr(6)).size()}) +
          zlibbed(data.substr(0, 6)) + zlibbed(data.substr(6));
      const std::string zlib = head + " compressor=\"vtkZLibDataCompressor\"";
      const auto read = [&](const std::string& text) {
        return values(read_volume(folder.write("a.vti", text)));
      };
      const auto appended = [](const std::string& encoding, const std::string& bytes) {
        return "<AppendedData encoding=\"" + encoding + "\">\n _" + bytes + "\n</AppendedData>";
      };
      EXPECT_EQ(read(vti(head, point_array("format=\"binary\"", base64(plain)))), kSix);
      EXPECT_EQ(read(vti(head, point_array("format=\"binary\"", base64(words({12})) + base64(data)))), kSix);
      EXPECT_EQ(read(vti(zlib, point_array("format=\"binary\"", base64(counts) + base64(first + second)))),
                kSix);
      EXPECT_EQ(read(vti(head, point_array("format=\"appended\" offset=\"3\"", ""),
                         appended("raw", "xyz" + plain))),
                kSix);
      EXPECT_EQ(read(vti(head, point_array("format=\"appended\" offset=\"4\"", ""),
                         appended("base64", base64("xyz") + base64(plain)))),
                kSix);
      EXPECT_EQ(read(vti(zlib, point_array("format=\"appended\" offset=\"0\"", ""),
                         appended("raw", counts + first + second))),
                kSix);
      EXPECT_EQ(
          read(vti(zlib, point_array("format=\"appended\" offset=\"0\"", ""), appended("raw", whole_blocks))),
          kSix);
      EXPECT_EQ(read(vti(zlib, point_array("format=\"appended\" offset=\"0\"", ""),
                         appended("base64", base64(counts) + base64(first + second)))),
                kSix);
    }
  }
}

TEST(Vti, CellDataAreShiftedByHalfASpacing) {
  const Folder folder;
  const auto v = read_volume(
      folder.write("a.vti", vti("",
                                "<CellData><DataArray type=\"UInt8\" Name=\"c\" format=\"ascii\">1 2 3 4 5 "
                                "6</DataArray></CellData>",
                                "", R"(WholeExtent="2 5 0 2 7 7" Origin="1 2 3" Spacing="0.5 2 4")")));
  EXPECT_EQ(v.geometry().dims, (Dims{3, 2, 1}));
  EXPECT_EQ(v.geometry().origin, Vec3(1 + 2.5 * 0.5, 2 + 0.5 * 2, 3 + 7 * 4));
}

TEST(Vti, DirectionIsWrittenByRows) {
  const Folder folder;
  const auto v =
      read_volume(folder.write("a.vti", vti("", point_array("format='ascii'", "1 2 3 4 5 6"), "",
                                            R"(WholeExtent="0 2 0 1 0 0" Direction="0 -1 0 1 0 0 0 0 1")")));
  EXPECT_EQ(v.geometry().index_to_world({1, 0, 0}), Vec3(0, 1, 0));
}

TEST(Vti, ChoosesTheArray) {
  const Folder folder;
  const auto array = [](const char* name, const char* rest, const char* data) {
    return std::string("<DataArray type=\"UInt8\" Name=\"") + name + "\" format=\"ascii\" " + rest + ">" +
           data + "</DataArray>";
  };
  const std::string v3 = array("v", "NumberOfComponents=\"3\"", "1 2 3 4 5 6 7 8 9 1 2 3 4 5 6 7 8 9");
  const std::string points =
      v3 + array("a", "", "1 1 1 1 1 1") + array("b", "NumberOfComponents=\"1\"", "2 2 2 2 2 2");
  const std::string cells = "<CellData>" + array("c", "", "3 3") + "</CellData>";
  const auto first = [](const Volume& v) { return values(v)[0]; };
  auto path = folder.write("a.vti", vti("", "<PointData>" + points + "</PointData>" + cells));
  EXPECT_EQ(first(read_volume(path)), 1);
  EXPECT_EQ(first(read_volume(path, {.array = "b"})), 2);
  EXPECT_EQ(first(read_volume(path, {.array = "c"})), 3);
  EXPECT_THAT(message_of(path, {.array = "v"}), HasSubstr("array 'v' has '3' components"));
  EXPECT_THAT(message_of(path, {.array = "d"}), HasSubstr("there are 'v' (3 components), 'a', 'b', 'c'"));
  path = folder.write("a.vti", vti("", "<PointData Scalars=\"b\">" + points + "</PointData>"));
  EXPECT_EQ(first(read_volume(path)), 2);
  path = folder.write("a.vti", vti("", "<PointData Scalars=\"v\">" + v3 + "</PointData>" + cells));
  EXPECT_EQ(first(read_volume(path)), 3);
}

// ---------------------------------------------------------------------------------------------------- legacy
// VTK

const std::string kVtk = "DATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 1\nSPACING 0.5 2 4\nORIGIN 1 2 3\n";

TEST(VtkLegacy, AsciiAndBinary) {
  const Folder folder;
  const std::string scalars = "POINT_DATA 6\nSCALARS s short\nLOOKUP_TABLE default\n";
  auto v = read_volume(folder.write(
      "a.vtk", "# vtk DataFile Version 3.0\ntitle\nASCII\n" + kVtk + scalars + "1 -2 300\n4 5 -600\n"));
  EXPECT_EQ(values(v), kSix);
  EXPECT_EQ(v.geometry().spacing, Vec3(0.5, 2, 4));
  EXPECT_EQ(v.geometry().origin, Vec3(1, 2, 3));
  EXPECT_EQ(v.attributes.at("title"), "title");
  v = read_volume(folder.write("a.vtk", "# vtk DataFile Version 2.0\ntitle\nBINARY\n" + kVtk + scalars +
                                            packed(kShorts, true) + "\n"));
  EXPECT_EQ(values(v), kSix);
}

TEST(VtkLegacy, SkipsWhatIsNoScalarAndReadsFields) {
  const Folder folder;
  const std::string head = "# vtk DataFile Version 5.1\ntitle\nBINARY\n" + kVtk + "POINT_DATA 6\n";
  const std::string vectors = "VECTORS v float\n" + packed(std::vector<float>(18, 0.5f), true) + "\n";
  const std::string two = "SCALARS two unsigned_char 2\nLOOKUP_TABLE t\n" + std::string(12, 'x') + "\n";
  const std::string table = "LOOKUP_TABLE t 2\n" + std::string(8, '\xff') + "\n";
  const std::string field =
      "FIELD FieldData 3\nnames 1 2 string\n\xc3"
      "abc\x80\x01x\nskipped 3 6 double\n" +
      packed(std::vector<double>(18, 1.5), true) + "\nMETADATA\nINFORMATION 0\n\nf 1 6 short\n" +
      packed(kShorts, true) + "\n";
  const auto path = folder.write("a.vtk", head + vectors + two + table + field);
  EXPECT_EQ(values(read_volume(path)), kSix);
  EXPECT_EQ(values(read_volume(path, {.array = "f"})), kSix);
  EXPECT_THAT(message_of(path, {.array = "two"}), HasSubstr("has 2 components"));
  EXPECT_THAT(message_of(path, {.array = "x"}),
              HasSubstr("there are 'two' (2 components), 'skipped' (3 components), 'f'"));
}

TEST(VtkLegacy, CellData) {
  const Folder folder;
  const auto v = read_volume(
      folder.write("a.vtk",
                   "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 1\n"
                   "ASPECT_RATIO 1 2 4\nORIGIN 0 0 0\nCELL_DATA 6\nSCALARS s int 1\nLOOKUP_TABLE default\n"
                   "1 -2 300 4 5 -600"));
  EXPECT_EQ(v.geometry().dims, (Dims{3, 2, 1}));
  EXPECT_EQ(v.geometry().origin, Vec3(0.5, 1, 0));
  EXPECT_EQ(v.voxel_type(), VoxelType::i32);
}

// ---------------------------------------------------------------------------------------------------- NIfTI

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

// ---------------------------------------------------------------------------------------------------- all

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
  const auto path = folder.write("a.nrrd", kNrrd + "endian: little\nencoding: raw\n\n" + packed(kShorts));
  ReadOptions options;
  options.memory_limit = 11;
  EXPECT_THAT(message_of(path, options), HasSubstr("3 x 2 x 1 voxels need 12 bytes, more than the 11"));
}

}  // namespace
}  // namespace vol::io
