// Hand-made files of VTK's variants: XML image data, and legacy structured points.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "read_files.h"

namespace vol::io {
namespace {

using testing::HasSubstr;
using volume::Volume;
using volume::VoxelType;

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

}  // namespace
}  // namespace vol::io
