// Damaged, lying and useless files: each is refused with one line that names the file, without taking the
// memory that its header promises.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <thread>

#include "base/error.h"
#include "files.h"

namespace vol::io {
namespace {

struct Hostile {
  const char* name;
  std::string bytes;
  const char* message;  ///< a part of it
};

std::string nrrd(const std::string& fields, const std::string& data = "abcdef") {
  return "NRRD0004\n" + fields + "\n" + data;
}
const std::string kSizes = "type: uint8\ndimension: 3\nsizes: 3 2 1\n";
const std::string kRaw = "encoding: raw\n";

std::string meta(const std::string& lines, const std::string& data = "abcdef") {
  return "NDims = 3\n" + lines + "ElementDataFile = LOCAL\n" + data;
}
const std::string kMetaBase = "DimSize = 3 2 1\nElementType = MET_UCHAR\n";

std::string vtk(const std::string& rest) {
  return "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\n" + rest;
}
const std::string kVtkGrid = "DIMENSIONS 3 2 1\nSPACING 1 1 1\nORIGIN 0 0 0\n";
const std::string kVtkScalars = "SCALARS s unsigned_char\nLOOKUP_TABLE default\n";

std::string vti(const std::string& array, const std::string& extent = "0 2 0 1 0 0",
                const std::string& head = "", const std::string& image = "",
                const std::string& appended = "") {
  return "<VTKFile type=\"ImageData\" " + head + "><ImageData WholeExtent=\"" + extent + "\" " + image +
         "><Piece><PointData>" + array + "</PointData></Piece></ImageData>" + appended + "</VTKFile>";
}
const std::string kU8 = "<DataArray type=\"UInt8\" Name=\"a\" ";
std::string appended(const std::string& data, const std::string& encoding = "raw") {
  return "<AppendedData encoding=\"" + encoding + "\">_" + data;
}

std::string nifti(std::initializer_list<std::pair<std::size_t, std::string>> changes,
                  const std::string& data = "abcdef") {
  std::string bytes(352, '\0');
  const auto put = [&](std::size_t at, const std::string& what) { bytes.replace(at, what.size(), what); };
  put(0, packed<std::int32_t>({348}));
  put(40, packed<std::int16_t>({3, 3, 2, 1, 1, 1, 1, 1}));
  put(70, packed<std::int16_t>({2, 8}));
  put(76, packed<float>({1, 1, 1, 1}));
  put(108, packed<float>({352}));
  put(344, std::string("n+1\0", 4));
  for (const auto& [at, what] : changes) put(at, what);
  return bytes + data;
}

std::vector<Hostile> hostile_files() {
  const std::string zeros = gzipped(std::string(1 << 24, '\0'));
  const std::string huge = "sizes: 1000000 1000000 1000000\n";
  const std::string words = packed<std::uint32_t>({1, 6, 0});
  const std::string z = zlibbed("abcdef");
  return {
      {"empty", "", "is empty"},
      {"noise", "\x01\x02\x03\x04nothing at all", "is none of the volume formats"},
      {"text", "hello world\n", "is none of the volume formats"},
      {"a_png", "\x89PNG\r\n\x1a\n", "is none of the volume formats"},
      // NRRD
      {"nrrd_truncated", nrrd(kSizes + kRaw, "abc"), "data ends after 3 of 6 bytes"},
      {"nrrd_oversized", nrrd(kSizes + kRaw, "abcdefg"), "holds more than the 6 bytes"},
      {"nrrd_version", "NRRD0009\n" + kSizes + kRaw + "\nabcdef", "NRRD version is 'NRRD0009'"},
      {"nrrd_only_magic", "NRRD0004", "NRRD header ends"},
      {"nrrd_no_blank_line", "NRRD0004\n" + kSizes + kRaw, "without the blank line"},
      {"nrrd_1e18", nrrd("type: uint8\ndimension: 3\n" + huge + kRaw),
       "1000000 x 1000000 x 1000000 voxels need"},
      {"nrrd_1e18_gzip", nrrd("type: uint8\ndimension: 3\n" + huge + "encoding: gzip\n", zeros),
       "voxels need"},
      {"nrrd_overflow",
       nrrd("type: double\ndimension: 3\nsizes: 4000000000 4000000000 4000000000\nendian: little\n" + kRaw),
       "overflows"},
      {"nrrd_zero_size", nrrd("type: uint8\ndimension: 3\nsizes: 3 0 1\n" + kRaw), "at least 1"},
      {"nrrd_negative_size", nrrd("type: uint8\ndimension: 3\nsizes: 3 -2 1\n" + kRaw), "at least 1"},
      {"nrrd_sizes_words", nrrd("type: uint8\ndimension: 3\nsizes: 3 two 1\n" + kRaw), "expected an integer"},
      {"nrrd_sizes_short", nrrd("type: uint8\ndimension: 3\nsizes: 3 2\n" + kRaw), "expected 3 integers"},
      {"nrrd_dimension", nrrd("type: uint8\ndimension: 99\nsizes: 3 2 1\n" + kRaw), "expected 1 to 16"},
      {"nrrd_int64", nrrd("type: int64\ndimension: 3\nsizes: 3 2 1\n" + kRaw), "type is 'int64'"},
      {"nrrd_block", nrrd("type: block\ndimension: 3\nsizes: 3 2 1\n" + kRaw), "type is 'block'"},
      {"nrrd_no_type", nrrd("dimension: 3\nsizes: 3 2 1\n" + kRaw), "no 'type' field"},
      {"nrrd_no_encoding", nrrd(kSizes), "no 'encoding' field"},
      {"nrrd_no_endian", nrrd("type: short\ndimension: 3\nsizes: 3 1 1\n" + kRaw), "no 'endian' field"},
      {"nrrd_endian", nrrd("type: short\ndimension: 3\nsizes: 3 1 1\nendian: middle\n" + kRaw),
       "expected little or big"},
      {"nrrd_bzip2", nrrd(kSizes + "encoding: bzip2\n"), "expected raw, gzip or ascii"},
      {"nrrd_twice", nrrd(kSizes + kSizes + kRaw), "twice"},
      {"nrrd_no_colon", nrrd(kSizes + "nonsense\n" + kRaw), "is neither 'field: value'"},
      {"nrrd_negative_spacing", nrrd(kSizes + "spacings: 1 -1 1\n" + kRaw),
       "spacing -1 along y is not positive"},
      {"nrrd_zero_spacing", nrrd(kSizes + "spacings: 1 1 0\n" + kRaw), "spacing 0 along z"},
      {"nrrd_zero_direction", nrrd(kSizes + "space: LPS\nspace directions: (1,0,0) (0,0,0) (0,0,1)\n" + kRaw),
       "is not a positive length"},
      {"nrrd_parallel_directions",
       nrrd(kSizes + "space: LPS\nspace directions: (1,0,0) (1,0,0) (0,0,1)\n" + kRaw), "do not span space"},
      {"nrrd_directions_garbage",
       nrrd(kSizes + "space: LPS\nspace directions: (1,0,0) (0,1 (0,0,1)\n" + kRaw), "space directions is"},
      {"nrrd_nan_origin", nrrd(kSizes + "space: LPS\nspace origin: (nan,0,0)\n" + kRaw), "expected a number"},
      {"nrrd_space_2d", nrrd(kSizes + "space dimension: 2\n" + kRaw), "space dimension is '2'"},
      {"nrrd_colour", nrrd(kSizes + "kinds: RGB-color domain domain\n" + kRaw), "expected a scalar volume"},
      {"nrrd_4d", nrrd("type: uint8\ndimension: 4\nsizes: 3 2 1 2\n" + kRaw, "abcdefabcdef"), "accepted"},
      {"nrrd_4d_full", nrrd("type: uint8\ndimension: 4\nsizes: 3 2 2 2\n" + kRaw, std::string(24, 'x')),
       "3 axes longer than 1"},
      {"nrrd_byte_skip", nrrd(kSizes + "byte skip: 1000000000000000000\n" + kRaw), "data ends after"},
      {"nrrd_byte_skip_negative", nrrd(kSizes + "byte skip: -2\n" + kRaw), "expected at least -1"},
      {"nrrd_line_skip", nrrd(kSizes + "line skip: 1000000000\n" + kRaw), "ends"},
      {"nrrd_ascii_letters", nrrd(kSizes + "encoding: ascii\n", "1 2 x 4 5 6"),
       "'x' among the data is not a u8"},
      {"nrrd_ascii_range", nrrd(kSizes + "encoding: ascii\n", "1 2 300 4 5 6"), "'300' among the data"},
      {"nrrd_ascii_short", nrrd(kSizes + "encoding: ascii\n", "1 2 3 4 5"), "5 of 6 numbers"},
      {"nrrd_ascii_1e12", nrrd("type: uint8\ndimension: 1\nsizes: 1000000000\nencoding: ascii\n", "1 2 3"),
       "data ends after"},
      {"nrrd_ascii_long_word", nrrd(kSizes + "encoding: ascii\n", std::string(70000, '1')),
       "word of text longer"},
      {"nrrd_gzip_garbage", nrrd(kSizes + "encoding: gzip\n", "this is no gzip stream"),
       "compressed data are damaged"},
      {"nrrd_gzip_empty", nrrd(kSizes + "encoding: gzip\n", ""), "compressed data are cut off"},
      {"nrrd_gzip_short", nrrd(kSizes + "encoding: gzip\n", gzipped("abc")), "data ends after 3 of 6 bytes"},
      {"nrrd_gzip_cut", nrrd(kSizes + "encoding: gzip\n", gzipped("abcdef").substr(0, 20)),
       "compressed data are cut off"},
      {"nrrd_gzip_crc", nrrd(kSizes + "encoding: gzip\n", gzipped("abcdef").substr(0, 18) + "XXXXYYYY"),
       "compressed data are damaged"},
      {"nrrd_gzip_bomb", nrrd(kSizes + "encoding: gzip\n", zeros), "holds more than the 6 bytes"},
      {"nrrd_missing_data_file", "NRRD0004\n" + kSizes + kRaw + "data file: nowhere.raw\n",
       "nowhere.raw: cannot read"},
      {"nrrd_device_as_data", "NRRD0004\n" + kSizes + kRaw + "data file: /dev/zero\n",
       "/dev/zero: is not a regular file"},
      {"nrrd_pattern", "NRRD0004\n" + kSizes + kRaw + "data file: %s%n 1 2 1\n", "a file name with one %d"},
      {"nrrd_pattern_count",
       "NRRD0004\n" + kSizes + kRaw + "data file: a%d -9000000000000000000 9000000000000000000 1\n",
       "expected 1 of them"},
      {"nrrd_pattern_step", "NRRD0004\n" + kSizes + kRaw + "data file: a%d 1 2 0\n", "by 0"},
      {"nrrd_list_empty", "NRRD0004\n" + kSizes + kRaw + "data file: LIST\n", "followed by no file name"},
      {"nrrd_long_line", "NRRD0004\ncontent: " + std::string(1 << 21, 'x'), "header line longer"},
      // MetaImage
      {"meta_truncated", meta(kMetaBase, "abc"), "data ends after 3 of 6 bytes"},
      {"meta_oversized", meta(kMetaBase, "abcdefg"), "holds more than the 6 bytes"},
      {"meta_no_data_file", "NDims = 3\n" + kMetaBase, "no 'ElementDataFile'"},
      {"meta_no_ndims", "ObjectType = Image\n" + kMetaBase + "ElementDataFile = LOCAL\nabcdef", "no 'NDims'"},
      {"meta_1e18", meta("DimSize = 1000000 1000000 1000000\nElementType = MET_UCHAR\n"), "voxels need"},
      {"meta_zero", meta("DimSize = 3 0 1\nElementType = MET_UCHAR\n"), "each must be at least 1"},
      {"meta_negative", meta("DimSize = 3 -2 1\nElementType = MET_UCHAR\n"), "each must be at least 1"},
      {"meta_type", meta("DimSize = 3 2 1\nElementType = MET_LONG_LONG\n"), "ElementType is 'MET_LONG_LONG'"},
      {"meta_spacing", meta(kMetaBase + "ElementSpacing = 1 -1 1\n"), "along y is not a positive length"},
      {"meta_matrix", meta(kMetaBase + "TransformMatrix = 1 0 0 1 0 0 0 0 1\n"), "do not span space"},
      {"meta_matrix_short", meta(kMetaBase + "TransformMatrix = 1 0 0\n"), "expected 9 numbers"},
      {"meta_channels", meta(kMetaBase + "ElementNumberOfChannels = 3\n"), "a scalar volume"},
      {"meta_tube", "ObjectType = Tube\n" + meta(kMetaBase), "ObjectType is 'Tube'"},
      {"meta_bool", meta(kMetaBase + "CompressedData = maybe\n"), "expected True or False"},
      {"meta_compressed_size",
       meta(kMetaBase + "CompressedData = True\nCompressedDataSize = 1000000000000\n", z),
       "compressed data end after"},
      {"meta_compressed_negative", meta(kMetaBase + "CompressedData = True\nCompressedDataSize = -1\n", z),
       "expected 0 or more"},
      {"meta_compressed_cut", meta(kMetaBase + "CompressedData = True\nCompressedDataSize = 5\n", z),
       "data ends after 2 of 6 bytes"},
      {"meta_bomb", meta(kMetaBase + "CompressedData = True\n", zlibbed(std::string(1 << 24, '\0'))),
       "holds more than the 6 bytes"},
      {"meta_missing", "NDims = 3\n" + kMetaBase + "ElementDataFile = gone.raw\n", "gone.raw: cannot read"},
      {"meta_folder", "NDims = 3\n" + kMetaBase + "ElementDataFile = .\n", "is not a regular file"},
      {"meta_no_equals", "NDims = 3\nnonsense\n", "is not 'Key = Value'"},
      {"meta_header_size", "NDims = 3\n" + kMetaBase + "HeaderSize = -7\nElementDataFile = x\n",
       "HeaderSize is '-7'"},
      // legacy VTK
      {"vtk_truncated", vtk(kVtkGrid + "POINT_DATA 6\n" + kVtkScalars + "abc"),
       "data ends after 3 of 6 bytes"},
      {"vtk_oversized", vtk(kVtkGrid + "POINT_DATA 6\n" + kVtkScalars + "abcdef\x01\x02\x03"),
       "holds more data"},
      {"vtk_only_title", "# vtk DataFile Version 3.0\nt\n", "expected ASCII or BINARY"},
      {"vtk_polydata", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n",
       "expected STRUCTURED_POINTS"},
      {"vtk_1e18",
       vtk("DIMENSIONS 1000000 1000000 1000000\nPOINT_DATA 1000000000000000000\n" + kVtkScalars + "abc"),
       "voxels need"},
      {"vtk_zero", vtk("DIMENSIONS 3 0 1\nPOINT_DATA 0\n" + kVtkScalars), "each must be at least 1"},
      {"vtk_count", vtk(kVtkGrid + "POINT_DATA 7\n" + kVtkScalars + "abcdefg"),
       "POINT_DATA says 7 values, DIMENSIONS says 6"},
      {"vtk_spacing", vtk("DIMENSIONS 3 2 1\nSPACING 1 -1 1\nPOINT_DATA 6\n" + kVtkScalars + "abcdef"),
       "along y is not a positive length"},
      {"vtk_no_data", vtk(kVtkGrid), "has no scalar array"},
      {"vtk_type", vtk(kVtkGrid + "POINT_DATA 6\nSCALARS s string\nLOOKUP_TABLE default\n"),
       "data type is 'string'"},
      {"vtk_long",
       vtk(kVtkGrid + "POINT_DATA 6\nSCALARS s long\nLOOKUP_TABLE default\n" + std::string(48, 'x')),
       "data type is 'long'"},
      {"vtk_keyword", vtk(kVtkGrid + "POINT_DATA 6\nNONSENSE\n"), "where a keyword"},
      {"vtk_skip_huge", vtk(kVtkGrid + "FIELD f 1\nx 1000000000 1000000000 double\n"), "data ends after"},
      {"vtk_skip_overflow", vtk(kVtkGrid + "FIELD f 1\nx 9000000000 9000000000 double\n"), "overflows"},
      {"vtk_scalars_first", vtk(kVtkGrid + kVtkScalars), "before POINT_DATA"},
      // VTI
      {"vti_not_xml", "<VTKFile type=\"ImageData\"", "a tag has no end"},
      {"vti_no_quotes", "<VTKFile type=ImageData>", "has no quotes"},
      {"vti_comment", "<?xml version=\"1.0\"?><!-- never ends", "has no end"},
      {"vti_polydata", "<VTKFile type=\"PolyData\"></VTKFile>", "expected ImageData"},
      {"vti_no_array", vti(""), "has no scalar array"},
      {"vti_extent", vti(kU8 + "format=\"ascii\">1</DataArray>", "0 -5 0 1 0 0"), "Extent is"},
      {"vti_extent_words", vti(kU8 + "format=\"ascii\">1</DataArray>", "0 a 0 1 0 0"), "expected an integer"},
      {"vti_1e18", vti(kU8 + "format=\"ascii\">1</DataArray>", "0 999999 0 999999 0 999999"), "voxels need"},
      {"vti_spacing",
       vti(kU8 + "format=\"ascii\">1 2 3 4 5 6</DataArray>", "0 2 0 1 0 0", "", "Spacing=\"1 -1 1\""),
       "not a positive length"},
      {"vti_direction",
       vti(kU8 + "format=\"ascii\">1 2 3 4 5 6</DataArray>", "0 2 0 1 0 0", "",
           "Direction=\"1 1 1 1 1 1 1 1 1\""),
       "unit vector"},
      {"vti_ascii_short", vti(kU8 + "format=\"ascii\">1 2 3</DataArray>"), "data ends after 3 of 6 numbers"},
      {"vti_ascii_long", vti(kU8 + "format=\"ascii\">1 2 3 4 5 6 7</DataArray>"), "holds more numbers"},
      {"vti_base64", vti(kU8 + "format=\"binary\">$$$$</DataArray>"), "none of base64"},
      {"vti_base64_cut", vti(kU8 + "format=\"binary\">BgA</DataArray>"), "inside a group of four"},
      {"vti_base64_short",
       vti(kU8 + "format=\"binary\">" + base64(packed<std::uint32_t>({6}) + "abc") + "</DataArray>"),
       "data ends after 3 of 6 bytes"},
      {"vti_count",
       vti(kU8 + "format=\"binary\">" + base64(packed<std::uint32_t>({5}) + "abcde") + "</DataArray>"),
       "array holds 5 bytes, its extent and type take 6"},
      {"vti_int64", vti("<DataArray type=\"Int64\" Name=\"a\" format=\"ascii\">1 2 3 4 5 6</DataArray>"),
       "is 'Int64'"},
      {"vti_array_of_two_lines", vti("<DataArray type=\"Int\n64\" Name=\"a\nb\" format=\"ascii\">1</DataArray>"),
       "type of array 'a?b' is 'Int?64'"},
      {"vti_appended_nowhere", vti(kU8 + "format=\"appended\" offset=\"0\"/>"), "has no AppendedData"},
      {"vti_offset", vti(kU8 + "format=\"appended\" offset=\"-4\"/>", "0 2 0 1 0 0", "", "", appended("")),
       "expected 0 or more"},
      {"vti_offset_far",
       vti(kU8 + "format=\"appended\" offset=\"4000000000000000000\"/>", "0 2 0 1 0 0", "", "",
           appended("abc")),
       "data ends after"},
      {"vti_no_underscore",
       vti(kU8 + "format=\"appended\" offset=\"0\"/>", "0 2 0 1 0 0", "", "",
           "<AppendedData encoding=\"raw\">" + std::string(9000, ' ')),
       "begin with an underscore"},
      {"vti_lz4",
       vti(kU8 + "format=\"appended\" offset=\"0\"/>", "0 2 0 1 0 0", "compressor=\"vtkLZ4DataCompressor\"",
           "", appended("abc")),
       "vtkLZ4DataCompressor"},
      {"vti_blocks",
       vti(kU8 + "format=\"appended\" offset=\"0\"/>", "0 2 0 1 0 0", "compressor=\"vtkZLibDataCompressor\"",
           "", appended(packed<std::uint32_t>({4000000000U, 4000000000U, 0}))),
       "compressed blocks hold"},
      {"vti_block_size",
       vti(kU8 + "format=\"appended\" offset=\"0\"/>", "0 2 0 1 0 0", "compressor=\"vtkZLibDataCompressor\"",
           "", appended(words + packed<std::uint32_t>({4000000000U}))),
       "compressed data"},
      {"vti_block_garbage",
       vti(kU8 + "format=\"appended\" offset=\"0\"/>", "0 2 0 1 0 0", "compressor=\"vtkZLibDataCompressor\"",
           "", appended(words + packed<std::uint32_t>({20}) + "aaaaaaaaaaaaaaaaaaaa")),
       "compressed data are damaged"},
      {"vti_two_pieces",
       "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 "
       "1\"><Piece/><Piece/></ImageData></VTKFile>",
       "several pieces"},
      // NIfTI
      {"nifti_truncated", nifti({}, "abc"), "data ends after 3 of 6 bytes"},
      {"nifti_oversized", nifti({}, "abcdefg"), "holds more than the 6 bytes"},
      {"nifti_header", nifti({}).substr(0, 200), "NIfTI header ends after 200 of 348 bytes"},
      {"nifti_magic", nifti({{344, "xxxx"}}), "no NIfTI-1 magic word"},
      {"nifti_2", packed<std::int32_t>({540}) + std::string(600, '\0'), "is NIfTI-2"},
      {"nifti_type", nifti({{70, packed<std::int16_t>({128})}}), "datatype is 128"},
      {"nifti_dim0", nifti({{40, packed<std::int16_t>({9})}}), "dim[0] is 9"},
      {"nifti_zero", nifti({{42, packed<std::int16_t>({0})}}), "each must be at least 1"},
      {"nifti_negative", nifti({{42, packed<std::int16_t>({-3})}}), "each must be at least 1"},
      {"nifti_spacing", nifti({{80, packed<float>({-1})}}), "along x is not a positive length"},
      {"nifti_nan_spacing", nifti({{80, packed<float>({std::nanf("")})}}),
       "along x is not a positive length"},
      {"nifti_offset", nifti({{108, packed<float>({1e30f})}}), "vox_offset"},
      {"nifti_offset_negative", nifti({{108, packed<float>({-352})}}), "vox_offset"},
      {"nifti_offset_nan", nifti({{108, packed<float>({std::nanf("")})}}), "vox_offset"},
      {"nifti_4d", nifti({{40, packed<std::int16_t>({4})}, {48, packed<std::int16_t>({100})}}),
       "choose one with --volume"},
      {"nifti_5d", nifti({{40, packed<std::int16_t>({5})}, {50, packed<std::int16_t>({3})}}), "dim[5] is 3"},
      {"nifti_sform", nifti({{254, packed<std::int16_t>({1})}}), "is not a positive length"},
      {"nifti_sform_inf", nifti({{254, packed<std::int16_t>({1})}, {280, packed<float>({INFINITY})}}),
       "sform is not finite"},
      {"nifti_gzip_of_text", gzipped("hello"), "no NIfTI-1 file"},
      {"nifti_gzip_cut", gzipped(nifti({})).substr(0, 40), "NIfTI header ends"},
      {"nifti_scale",
       nifti({{70, packed<std::int16_t>({64})}, {112, packed<float>({1e38f})}},
             packed<double>({1, 2, 3, 4, 5, 1.7e308})),
       "NaN or infinite"},
  };
}

std::string refusal(const std::filesystem::path& path) {
  try {
    (void)read_volume(path);
  } catch (const Error& e) {
    return e.what();
  } catch (const std::exception& e) {
    return std::string("not vol::Error: ") + e.what();
  }
  return "accepted";
}

TEST(Hostile, EveryFileIsRefusedWithOneLineThatNamesIt) {
  const Folder folder;
  const auto files = hostile_files();
  EXPECT_GE(files.size(), 40U);
  for (const auto& file : files) {
    if (std::string(file.message) == "accepted") {
      const auto path = folder.write("a.dat", file.bytes);
      EXPECT_EQ(refusal(path), "accepted") << file.name;
      continue;
    }
    const std::string message = refusal(folder.write(file.name, file.bytes));
    EXPECT_THAT(message, testing::HasSubstr(file.message)) << file.name;
    const bool names_it = message.find((folder / "").string()) == 0 || message.find("/dev/zero: ") == 0;
    EXPECT_TRUE(names_it) << file.name << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << file.name;
    EXPECT_LT(message.size(), 400U) << file.name << ": " << message;
  }
}

std::int64_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

// What is promised is within the machine's memory, so that only the growth of the buffer protects it.
TEST(Hostile, MemoryGrowsWithWhatComesFromAPipe) {
  const std::int64_t promised =
      std::min<std::int64_t>(ReadOptions::physical_memory() / 2, std::int64_t{1} << 32);
  for (const std::string encoding : {"raw", "gzip", "ascii"}) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    std::string text = "NRRD0004\ntype: uint8\ndimension: 1\nsizes: " + std::to_string(promised) +
                       "\nencoding: " + encoding + "\n\n";
    text += encoding == "gzip" ? gzipped(std::string(1000, 'x')) : "1 2 3";
    ASSERT_EQ(write(ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    close(ends[1]);
    const int saved = dup(STDIN_FILENO);
    dup2(ends[0], STDIN_FILENO);
    const std::int64_t before = peak_memory();
    const std::string message = refusal("-");
    const std::int64_t taken = peak_memory() - before;
    dup2(saved, STDIN_FILENO);
    close(saved);
    close(ends[0]);
    EXPECT_THAT(message, testing::HasSubstr("standard input: data ends after")) << encoding;
    EXPECT_LT(taken, std::int64_t{32} << 20) << encoding;
  }
}

TEST(Hostile, ABombIsNotInflatedBeyondItsPromise) {
  const Folder folder;
  // 256 MB of zeros in 260 kB.
  const std::string bomb = gzipped(std::string(std::size_t{1} << 28, '\0'));
  const auto path = folder.write("bomb.nrrd", nrrd(kSizes + "encoding: gzip\n", bomb));
  const std::int64_t before = peak_memory();
  EXPECT_THAT(refusal(path), testing::HasSubstr("holds more than the 6 bytes"));
  EXPECT_LT(peak_memory() - before, std::int64_t{8} << 20);
}

TEST(Hostile, EveryTruncationOfAGoodFileIsRefused) {
  const Folder folder;
  volume::GridGeometry g;
  g.dims = {3, 2, 2};
  g.space = volume::Space::lps;
  volume::Volume v = volume::allocate(volume::VoxelType::i16, g);
  volume::visit(v, [](auto& grid) {
    std::fill(grid.voxels.begin(), grid.voxels.end(), typename std::decay_t<decltype(grid)>::value_type(1));
  });
  for (const char* name : {"v.nrrd", "v.mha", "v.vti"}) {
    for (const bool compress : {false, true}) {
      write_volume(folder / name, v, {.format = {}, .compress = compress});
      const std::string whole = bytes_of(folder / name);
      // VTI ends with closing tags that hold nothing.
      const std::size_t needed =
          std::string(name) == "v.vti" ? whole.find("\n  </AppendedData>") : whole.size();
      for (std::size_t n = 0; n < needed; ++n) {
        const std::string message = refusal(folder.write("cut", whole.substr(0, n)));
        ASSERT_EQ(message.find((folder / "").string()), 0U) << name << " cut to " << n << ": " << message;
      }
    }
  }
}

}  // namespace
}  // namespace vol::io
