// MetaImage, after the MetaIO documentation ("MetaImage: tags, reading") and what ITK writes.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/error.h"
#include "io/header_text.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"

namespace vol::io {
namespace {

constexpr std::size_t kLongestLine = 1 << 20;
constexpr std::int64_t kLongestHeader = 1 << 24;

/// Keys of the format that describe the volume or are of no use to us; every other key becomes an attribute.
bool is_structural(std::string_view key) {
  static constexpr std::string_view kKeys[] = {"ObjectType",
                                               "ObjectSubType",
                                               "TransformType",
                                               "NDims",
                                               "Name",
                                               "ID",
                                               "ParentID",
                                               "CompressionLevel",
                                               "CompressedData",
                                               "CompressedDataSize",
                                               "BinaryData",
                                               "ElementByteOrderMSB",
                                               "BinaryDataByteOrderMSB",
                                               "Color",
                                               "Position",
                                               "Offset",
                                               "Origin",
                                               "Orientation",
                                               "Rotation",
                                               "TransformMatrix",
                                               "CenterOfRotation",
                                               "AnatomicalOrientation",
                                               "ElementSpacing",
                                               "DimSize",
                                               "HeaderSize",
                                               "HeaderSizePerSlice",
                                               "Modality",
                                               "SequenceID",
                                               "ElementMin",
                                               "ElementMax",
                                               "ElementNumberOfChannels",
                                               "ElementSize",
                                               "ElementType",
                                               "ElementDataFile"};
  return std::find(std::begin(kKeys), std::end(kKeys), key) != std::end(kKeys);
}

struct Header {
  std::string name;
  std::map<std::string, std::string> values;
  std::map<std::string, std::string> attributes;
  std::int64_t lines_after = 0;

  [[nodiscard]] Field field(std::string_view which) const { return {name, which}; }
  [[nodiscard]] const std::string* find(std::initializer_list<const char*> keys) const {
    for (const char* key : keys) {
      if (const auto found = values.find(key); found != values.end()) return &found->second;
    }
    return nullptr;
  }
  [[nodiscard]] const std::string& need(const char* key) const {
    const std::string* value = find({key});
    if (value == nullptr) throw Error(name + ": MetaImage header has no '" + std::string(key) + "'");
    return *value;
  }
  [[nodiscard]] bool flag(std::initializer_list<const char*> keys, bool otherwise) const {
    const std::string* text = find(keys);
    if (text == nullptr) return otherwise;
    const std::string value = lower_case(*text);
    if (value == "true" || value == "1") return true;
    if (value == "false" || value == "0") return false;
    field(*keys.begin()).refuse(*text, "True or False");
  }
};

Header read_header(InputFile& file) {
  Header header;
  header.name = display_name(file.path());
  for (;;) {
    if (file.at_end()) throw Error(header.name + ": MetaImage header has no 'ElementDataFile'");
    if (file.position() > kLongestHeader) throw Error(header.name + ": MetaImage header is too long");
    const std::string line = file.read_line(kLongestLine);
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) {
      if (trimmed(line).empty()) continue;
      throw Error(header.name + ": MetaImage header line " + in_quotes(line) + " is not 'Key = Value'");
    }
    const std::string key(trimmed(std::string_view(line).substr(0, equals)));
    const std::string value(trimmed(std::string_view(line).substr(equals + 1)));
    if (!is_structural(key)) {
      header.attributes[key] = value;
      continue;
    }
    if (!header.values.emplace(key, value).second) {
      throw Error(header.name + ": MetaImage header gives " + in_quotes(key) + " twice");
    }
    if (key == "ElementDataFile") return header;
  }
}

volume::VoxelType voxel_type(const Header& header) {
  using enum volume::VoxelType;
  static const std::map<std::string_view, volume::VoxelType> kTypes = {
      {"MET_CHAR", i8},  {"MET_UCHAR", u8}, {"MET_SHORT", i16}, {"MET_USHORT", u16}, {"MET_INT", i32},
      {"MET_UINT", u32}, {"MET_LONG", i32}, {"MET_ULONG", u32}, {"MET_FLOAT", f32},  {"MET_DOUBLE", f64}};
  const std::string& text = header.need("ElementType");
  const auto found = kTypes.find(text);
  if (found == kTypes.end())
    header.field("ElementType").refuse(text, "MET_CHAR, MET_UCHAR ... MET_UINT, MET_FLOAT or MET_DOUBLE");
  return found->second;
}

volume::GridGeometry parse_geometry(const Header& header) {
  const std::int64_t n = parse_integer(header.field("NDims"), header.need("NDims"));
  if (n < 1 || n > 4) header.field("NDims").refuse(header.need("NDims"), "3");
  const auto axes = static_cast<std::size_t>(n);
  const auto sizes = parse_integers(header.field("DimSize"), header.need("DimSize"), axes);
  if (n == 4 && sizes[3] != 1)
    header.field("DimSize").refuse(header.need("DimSize"), "one volume, a 4th size of 1");
  const std::size_t known = std::min<std::size_t>(axes, 3);

  volume::GridGeometry geometry;
  for (std::size_t a = 0; a < known; ++a) geometry.dims[a] = sizes[a];
  Mat3 steps = Mat3::Identity();
  if (const auto* text = header.find({"TransformMatrix", "Rotation", "Orientation"})) {
    // Row r of the n x n numbers is the world direction of axis r.
    const auto matrix = parse_numbers(header.field("TransformMatrix"), *text, axes * axes);
    for (std::size_t a = 0; a < known; ++a) {
      Vec3 axis = Vec3::Zero();
      for (std::size_t row = 0; row < known; ++row)
        axis[static_cast<Eigen::Index>(row)] = matrix[a * axes + row];
      steps.col(static_cast<Eigen::Index>(a)) = axis;
    }
  }
  set_axes(geometry, steps, static_cast<int>(known));
  for (int a = 0; a < 3; ++a) {  // unit directions to rounding stay as they are written
    if (std::abs(geometry.spacing[a] - 1.0) < 1e-6) {
      geometry.spacing[a] = 1.0;
      geometry.direction.col(a) =
          static_cast<std::size_t>(a) < known ? Vec3(steps.col(a)) : Vec3(geometry.direction.col(a));
    }
  }
  const auto* spacing = header.find({"ElementSpacing", "ElementSize"});
  if (spacing != nullptr) {
    const auto lengths = parse_numbers(header.field("ElementSpacing"), *spacing, axes);
    for (std::size_t a = 0; a < known; ++a) geometry.spacing[static_cast<Eigen::Index>(a)] *= lengths[a];
  }
  if (const auto* text = header.find({"Offset", "Position", "Origin"})) {
    const auto offset = parse_numbers(header.field("Offset"), *text, axes);
    for (std::size_t a = 0; a < known; ++a) geometry.origin[static_cast<Eigen::Index>(a)] = offset[a];
  }
  // The format's world is LPS; a file that names no orientation at all says nothing of anatomy.
  const auto* orientation = header.find({"AnatomicalOrientation"});
  if (orientation != nullptr && orientation->find('?') == std::string::npos && !orientation->empty()) {
    geometry.space = volume::Space::lps;
  }
  return geometry;
}

/// Names after ElementDataFile: one, `LIST` with the names on the lines that follow, or `pattern min max
/// step`.
std::vector<std::string> data_file_names(InputFile& file, const Header& header, const Dims& dims) {
  const std::string& text = header.need("ElementDataFile");
  const auto words = words_of(text);
  if (words.empty()) header.field("ElementDataFile").refuse(text, "LOCAL, LIST or a file name");
  if (words[0] == "LIST") {
    std::vector<std::string> names;
    while (!file.at_end()) {
      const std::string line = file.read_line();
      if (!trimmed(line).empty()) names.emplace_back(trimmed(line));
      if (file.position() > kLongestHeader) throw Error(header.name + ": MetaImage header is too long");
    }
    if (names.empty()) throw Error(header.name + ": 'ElementDataFile = LIST' is followed by no file name");
    return names;
  }
  const bool numbered = text.find('%') != std::string::npos && (words.size() == 3 || words.size() == 4);
  if (!numbered) return {text};
  const Field field = header.field("ElementDataFile");
  return numbered_files(field, words[0], parse_integer(field, words[1]), parse_integer(field, words[2]),
                        words.size() == 4 ? parse_integer(field, words[3]) : 1, dims[2]);
}

/// Voxels from binary data behind `source`, which may be one zlib stream.
volume::Volume read_stream(const Header& header, ByteSource& source, const VoxelLayout& layout,
                           bool compressed, const ReadOptions& options) {
  const std::int64_t bytes = checked_bytes(header.name, layout, options);
  volume::Volume volume;
  if (!compressed) {
    volume = read_binary(source, layout, options);
    expect_end(source, bytes);
    return volume;
  }
  std::int64_t packed = std::numeric_limits<std::int64_t>::max();
  if (const auto* text = header.find({"CompressedDataSize"})) {
    packed = parse_integer(header.field("CompressedDataSize"), *text);
    if (packed < 0) header.field("CompressedDataSize").refuse(*text, "0 or more");
    if (source.remaining() >= 0 && source.remaining() < packed) {
      throw Error(source.name() + ": compressed data end after " + std::to_string(source.remaining()) +
                  " of " + *text + " bytes");
    }
  }
  LimitedSource limited(source, packed);
  InflateSource inflated(limited);
  volume = read_binary(inflated, layout, options);
  expect_end(inflated, bytes);
  return volume;
}

}  // namespace

bool is_meta_image(std::string_view start) {
  const std::size_t equals = start.find('=');
  if (equals == std::string_view::npos || equals > 40) return false;
  const std::string_view key = trimmed(start.substr(0, equals));
  return is_structural(key) || key == "Comment";
}

volume::Volume read_meta_image(InputFile& file, const ReadOptions& options) {
  Header header = read_header(file);
  if (const auto* type = header.find({"ObjectType"}); type != nullptr && *type != "Image") {
    header.field("ObjectType").refuse(*type, "Image");
  }
  if (const auto* channels = header.find({"ElementNumberOfChannels"});
      channels != nullptr && *channels != "1") {
    header.field("ElementNumberOfChannels").refuse(*channels, "1, a scalar volume");
  }
  VoxelLayout layout;
  layout.type = voxel_type(header);
  layout.geometry = parse_geometry(header);
  layout.big_endian = header.flag({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}, false);
  const std::int64_t bytes = checked_bytes(header.name, layout, options);
  const bool compressed = header.flag({"CompressedData"}, false);
  const bool text = !header.flag({"BinaryData"}, true);
  std::int64_t skip = 0;
  if (const auto* size = header.find({"HeaderSize"})) {
    skip = parse_integer(header.field("HeaderSize"), *size);
    if (skip < -1 || (skip < 0 && compressed))
      header.field("HeaderSize").refuse(*size, "0 or more, or -1 for data that end the file");
  }
  if (text && compressed) throw Error(header.name + ": both BinaryData = False and CompressedData = True");

  volume::Volume volume;
  const std::string& data_file = header.need("ElementDataFile");
  if (data_file == "LOCAL" || data_file == "Local" || data_file == "local") {
    FileSource source(file);
    Scanner scanner(source);
    volume = text ? read_ascii(scanner, layout, options)
                  : read_stream(header, source, layout, compressed, options);
  } else {
    DataFiles files;
    for (const auto& name : data_file_names(file, header, layout.geometry.dims)) {
      files.paths.push_back(beside(file.path(), name));
    }
    const auto parts = static_cast<std::int64_t>(files.paths.size());
    if (layout.geometry.count() % parts != 0 || ((text || compressed) && parts != 1)) {
      throw Error(header.name + ": " + std::to_string(layout.geometry.count()) + " voxels do not fill " +
                  std::to_string(parts) + " data files evenly");
    }
    if (text || compressed) {
      const auto data = open_data_file(files.paths[0]);
      FileSource source(*data);
      source.skip(std::max<std::int64_t>(skip, 0));
      Scanner scanner(source);
      volume =
          text ? read_ascii(scanner, layout, options) : read_stream(header, source, layout, true, options);
    } else {
      files.byte_skip = skip;
      files.bytes_each = bytes / parts;
      DataFilesSource source(std::move(files));
      volume = read_stream(header, source, layout, false, options);
    }
  }
  volume.attributes = std::move(header.attributes);
  return volume;
}

namespace {

std::string_view type_name(volume::VoxelType type) {
  using enum volume::VoxelType;
  switch (type) {
    case i8:
      return "MET_CHAR";
    case u8:
      return "MET_UCHAR";
    case i16:
      return "MET_SHORT";
    case u16:
      return "MET_USHORT";
    case i32:
      return "MET_INT";
    case u32:
      return "MET_UINT";
    case f32:
      return "MET_FLOAT";
    case f64:
      return "MET_DOUBLE";
    case f16:
      break;
  }
  throw Error("MetaImage has no 16-bit float; convert the volume to f32");
}

/// "RAI" for the identity: the side from which each axis comes, LPS world.
std::string anatomical_orientation(const Mat3& direction) {
  std::string letters;
  for (int a = 0; a < 3; ++a) {
    Eigen::Index along = 0;
    direction.col(a).cwiseAbs().maxCoeff(&along);
    letters += direction(along, a) > 0 ? "RAI"[along] : "LPS"[along];
  }
  return letters;
}

std::string attribute_lines(const volume::Volume& volume, Warnings& warnings) {
  std::string lines;
  for (const auto& [key, value] : volume.attributes) {
    const bool holdable = !key.empty() && trimmed(key) == key && trimmed(value) == value &&
                          !is_structural(key) && key.find_first_of("=\n\r") == std::string::npos &&
                          value.find_first_of("\n\r") == std::string::npos;
    if (holdable) {
      lines += key + " = " + value + "\n";
    } else {
      warnings.push_back("MetaImage cannot hold the attribute " + in_quotes(key) + "; it is left out");
    }
  }
  return lines;
}

}  // namespace

Warnings write_meta_image(const std::filesystem::path& path, const volume::Volume& volume, bool detached,
                          bool compress) {
  Warnings warnings;
  volume::GridGeometry g = volume.geometry();
  if (g.space == volume::Space::ras) {  // MetaImage's world is LPS: the same points, other names of the axes
    flip_x_and_y(g);
    g.space = volume::Space::lps;
  }
  std::vector<unsigned char> packed;
  if (compress) {
    with_voxel_bytes(volume, [&](const void* data, std::size_t n) {
      deflate_to(data, n, false, [&](const void* part, std::size_t size) {
        const auto* bytes = static_cast<const unsigned char*>(part);
        packed.insert(packed.end(), bytes, bytes + size);
      });
    });
  }
  std::filesystem::path data_path = path;
  data_path.replace_extension(compress ? ".zraw" : ".raw");

  std::string text = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n";
  text += std::string("CompressedData = ") + (compress ? "True\n" : "False\n");
  if (compress) text += "CompressedDataSize = " + std::to_string(packed.size()) + "\n";
  text += "TransformMatrix = " + shortest(g.direction.col(0)) + " " + shortest(g.direction.col(1)) + " " +
          shortest(g.direction.col(2)) + "\n";
  text += "Offset = " + shortest(g.origin) + "\nCenterOfRotation = 0 0 0\n";
  text += "AnatomicalOrientation = " +
          (g.space == volume::Space::lps ? anatomical_orientation(g.direction) : "???") + "\n";
  text += "ElementSpacing = " + shortest(g.spacing) + "\n";
  text += "DimSize = " + std::to_string(g.dims[0]) + " " + std::to_string(g.dims[1]) + " " +
          std::to_string(g.dims[2]) + "\n";
  text += attribute_lines(volume, warnings);
  text += "ElementType = " + std::string(type_name(volume.voxel_type())) + "\n";
  text += "ElementDataFile = " + (detached ? data_path.filename().string() : "LOCAL") + "\n";

  const auto write_voxels = [&](OutputFile& out) {
    if (compress) {
      out.write(packed.data(), packed.size());
    } else {
      with_voxel_bytes(volume, [&](const void* data, std::size_t n) { out.write(data, n); });
    }
  };
  OutputFile header(path);
  header.write(text);
  if (detached) {
    OutputFile data(data_path);
    write_voxels(data);
    data.commit();
  } else {
    write_voxels(header);
  }
  header.commit();
  return warnings;
}

}  // namespace vol::io
