// NRRD, after the format's definition (teem.sourceforge.net/nrrd/format.html, "Definition of NRRD File
// Format").
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "base/checked.h"
#include "base/error.h"
#include "io/header_text.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"

namespace vol::io {
namespace {

constexpr std::size_t kLongestLine = 1 << 20;    // a key's value may be a page of JSON
constexpr std::size_t kLongestHeader = 1 << 24;  // bytes

struct Header {
  std::string name;                           ///< of the file, for messages
  std::map<std::string, std::string> fields;  ///< by name in lower case, without spaces
  std::map<std::string, std::string> attributes;
  std::vector<std::string> listed_files;  ///< after `data file: LIST`

  [[nodiscard]] const std::string* find(std::string_view field) const {
    const auto found = fields.find(std::string(field));
    return found == fields.end() ? nullptr : &found->second;
  }
  [[nodiscard]] const std::string& need(std::string_view field) const {
    const std::string* value = find(field);
    if (value == nullptr) throw Error(name + ": NRRD header has no '" + std::string(field) + "' field");
    return *value;
  }
  [[nodiscard]] Field field(std::string_view which) const { return {name, which}; }
};

std::string canonical(std::string_view field) {
  std::string key = lower_case(field);
  key.erase(std::remove(key.begin(), key.end(), ' '), key.end());
  return key == "centers" ? "centerings" : key;
}

std::string unescaped(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == 'n' || text[i + 1] == '\\');
    plain += !escape ? text[i] : text[i + 1] == 'n' ? '\n' : '\\';
    i += escape ? 1 : 0;
  }
  return plain;
}

void parse_line(Header& header, const std::string& line) {
  const std::size_t field_end = line.find(": ");
  const std::size_t key_end = line.find(":=");
  if (key_end != std::string::npos && (field_end == std::string::npos || key_end < field_end)) {
    header.attributes[unescaped(std::string_view(line).substr(0, key_end))] =
        unescaped(std::string_view(line).substr(key_end + 2));
    return;
  }
  const std::size_t colon = field_end != std::string::npos ? field_end : line.find(':');
  if (colon == std::string::npos) {
    throw Error(header.name + ": NRRD header line " + in_quotes(line) +
                " is neither 'field: value' nor 'key:=value'");
  }
  const std::string key = canonical(std::string_view(line).substr(0, colon));
  const bool fresh =
      header.fields.emplace(key, std::string(trimmed(std::string_view(line).substr(colon + 1)))).second;
  if (!fresh) throw Error(header.name + ": NRRD header gives " + in_quotes(key) + " twice");
}

Header read_header(InputFile& file) {
  Header header;
  header.name = display_name(file.path());
  const std::string magic = file.read_line(kLongestLine);
  if (magic.size() != 8 || magic < "NRRD0001" || magic > "NRRD0005") {
    throw Error(header.name + ": NRRD version is " + in_quotes(magic) + ", expected NRRD0001 to NRRD0005");
  }
  const std::int64_t start = file.position();
  bool blank = false;
  while (!blank && !file.at_end()) {
    const std::string line = file.read_line(kLongestLine);
    if (file.position() - start > static_cast<std::int64_t>(kLongestHeader)) {
      throw Error(header.name + ": NRRD header is longer than " + std::to_string(kLongestHeader) + " bytes");
    }
    const std::string* data = header.find("datafile");
    if (line.empty()) {
      blank = true;
    } else if (data != nullptr && data->compare(0, 4, "LIST") == 0) {
      header.listed_files.push_back(line);
    } else if (line[0] != '#') {
      parse_line(header, line);
    }
  }
  if (!blank && header.find("datafile") == nullptr) {
    throw Error(header.name + ": NRRD header ends without the blank line that data follow");
  }
  return header;
}

volume::VoxelType voxel_type(const Header& header) {
  using enum volume::VoxelType;
  static const std::map<std::string_view, volume::VoxelType> kTypes = {{"signed char", i8},
                                                                       {"int8", i8},
                                                                       {"int8_t", i8},
                                                                       {"uchar", u8},
                                                                       {"uint8", u8},
                                                                       {"uint8_t", u8},
                                                                       {"unsigned char", u8},
                                                                       {"short", i16},
                                                                       {"short int", i16},
                                                                       {"signed short", i16},
                                                                       {"int16", i16},
                                                                       {"int16_t", i16},
                                                                       {"signed short int", i16},
                                                                       {"ushort", u16},
                                                                       {"unsigned short", u16},
                                                                       {"uint16", u16},
                                                                       {"uint16_t", u16},
                                                                       {"unsigned short int", u16},
                                                                       {"int", i32},
                                                                       {"signed int", i32},
                                                                       {"int32", i32},
                                                                       {"int32_t", i32},
                                                                       {"uint", u32},
                                                                       {"unsigned int", u32},
                                                                       {"uint32", u32},
                                                                       {"uint32_t", u32},
                                                                       {"float", f32},
                                                                       {"double", f64},
                                                                       {"float16", f16},
                                                                       {"half", f16}};
  const std::string& text = header.need("type");
  const auto found = kTypes.find(lower_case(text));
  if (found == kTypes.end()) {
    header.field("type").refuse(text,
                                "a scalar of at most 32 bits an integer (int8 ... uint32, float, double)");
  }
  return found->second;
}

/// A step between samples for each axis, where `space directions` gives one.
std::vector<std::optional<Vec3>> parse_directions(const Header& header, const std::string& text,
                                                  std::size_t axes) {
  const Field field = header.field("space directions");
  std::vector<std::optional<Vec3>> directions;
  std::string_view rest = trimmed(text);
  while (!rest.empty()) {
    if (lower_case(rest.substr(0, 4)) == "none") {
      directions.emplace_back();
      rest = trimmed(rest.substr(4));
      continue;
    }
    const std::size_t close = rest.find(')');
    if (rest[0] != '(' || close == std::string_view::npos)
      field.refuse(text, "(x,y,z) or none for each axis");
    std::string inside(rest.substr(1, close - 1));
    std::replace(inside.begin(), inside.end(), ',', ' ');
    directions.emplace_back(parse_vector(field, inside));
    rest = trimmed(rest.substr(close + 1));
  }
  if (directions.size() != axes)
    field.refuse(text, "one vector or none for each of " + std::to_string(axes) + " axes");
  return directions;
}

/// The axes that become x, y, z: all of up to three; of more, those left when axes of one sample are dropped,
/// such without a direction first, then the outermost.
std::vector<std::size_t> spatial_axes(const Header& header, const std::vector<std::int64_t>& sizes,
                                      const std::vector<std::optional<Vec3>>& directions) {
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    const bool none = !directions.empty() && !directions[a];
    if (none && sizes[a] != 1) {
      throw Error(header.name + ": axis " + std::to_string(a) + " holds " + std::to_string(sizes[a]) +
                  " values a voxel (its space direction is none), expected a scalar volume");
    }
    if (!none) axes.push_back(a);
  }
  while (axes.size() > 3) {
    if (sizes[axes.front()] == 1) {
      axes.erase(axes.begin());
    } else if (sizes[axes.back()] == 1) {
      axes.pop_back();
    } else {
      const auto one = std::find_if(axes.begin(), axes.end(), [&](std::size_t a) { return sizes[a] == 1; });
      if (one == axes.end()) {
        header.field("dimension")
            .refuse(std::to_string(sizes.size()), "a scalar volume of 3 axes longer than 1");
      }
      axes.erase(one);
    }
  }
  return axes;
}

void refuse_vector_kinds(const Header& header, const std::vector<std::int64_t>& sizes) {
  const std::string* text = header.find("kinds");
  if (text == nullptr) return;
  const auto kinds = words_of(*text);
  if (kinds.size() != sizes.size()) header.field("kinds").refuse(*text, "one word for each axis");
  for (std::size_t a = 0; a < kinds.size(); ++a) {
    const std::string kind = lower_case(kinds[a]);
    if (sizes[a] == 1 || kind == "domain" || kind == "space" || kind == "time" || kind == "none" ||
        kind == "???" || kind == "list") {
      continue;
    }
    throw Error(header.name + ": axis " + std::to_string(a) + " is of kind " + in_quotes(kinds[a]) +
                ", expected a scalar volume");
  }
}

/// `spacings`, or what `axis mins` and `axis maxs` say; `nan` stands for not known.
std::vector<double> parse_per_axis(const Header& header, std::string_view field, std::size_t axes) {
  const std::string* text = header.find(field);
  if (text == nullptr) return {};
  const auto words = words_of(*text);
  if (words.size() != axes)
    header.field(field).refuse(*text, "one number for each of " + std::to_string(axes) + " axes");
  std::vector<double> values;
  for (const auto& word : words) {
    values.push_back(lower_case(word) == "nan" ? std::nan("") : parse_number(header.field(field), word));
  }
  return values;
}

/// World axes of the file: LPS, RAS, or LAS, which becomes RAS by the sign of x.
struct WorldAxes {
  volume::Space space = volume::Space::none;
  bool flip_x = false;
};

WorldAxes parse_space(const Header& header) {
  if (const std::string* dimension = header.find("spacedimension");
      dimension != nullptr && *dimension != "3") {
    header.field("space dimension").refuse(*dimension, "3");
  }
  const std::string* text = header.find("space");
  if (text == nullptr) return {};
  const std::string space = lower_case(*text);
  if (space == "left-posterior-superior" || space == "lps") return {volume::Space::lps, false};
  if (space == "right-anterior-superior" || space == "ras") return {volume::Space::ras, false};
  if (space == "left-anterior-superior" || space == "las") return {volume::Space::ras, true};
  if (space == "scanner-xyz" || space == "3d-right-handed" || space == "3d-left-handed") return {};
  header.field("space").refuse(*text, "a space of 3 dimensions");
}

volume::GridGeometry parse_geometry(const Header& header, const std::vector<std::int64_t>& sizes) {
  const std::size_t n = sizes.size();
  const WorldAxes world = parse_space(header);
  std::vector<std::optional<Vec3>> directions;
  if (const auto* text = header.find("spacedirections")) directions = parse_directions(header, *text, n);
  refuse_vector_kinds(header, sizes);
  const auto spacings = parse_per_axis(header, "spacings", n);
  const auto mins = parse_per_axis(header, "axismins", n);
  const auto maxs = parse_per_axis(header, "axismaxs", n);
  std::vector<std::string> centerings(n);
  if (const auto* text = header.find("centerings")) {
    centerings = words_of(*text);
    if (centerings.size() != n) header.field("centerings").refuse(*text, "one word for each axis");
  }

  volume::GridGeometry geometry;
  geometry.space = world.space;
  const auto axes = spatial_axes(header, sizes, directions);
  Mat3 steps = Mat3::Identity();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::size_t a = axes[i];
    const auto column = static_cast<Eigen::Index>(i);
    geometry.dims[i] = sizes[a];
    if (!directions.empty()) {
      steps.col(column) = directions[a].value_or(Vec3::Zero());
      continue;
    }
    // Axis minimum and maximum are the outer faces of cells, but the outermost samples where centering is
    // node.
    const bool node = lower_case(centerings[a]) == "node";
    double spacing = !spacings.empty() && !std::isnan(spacings[a]) ? spacings[a] : 1.0;
    const bool has_min = !mins.empty() && !std::isnan(mins[a]);
    if (spacings.empty() && has_min && !maxs.empty() && !std::isnan(maxs[a]) && (!node || sizes[a] > 1)) {
      spacing = (maxs[a] - mins[a]) / static_cast<double>(node ? sizes[a] - 1 : sizes[a]);
    }
    if (!(spacing > 0)) {
      throw Error(header.name + ": spacing " + shortest(spacing) + " along " + std::string(1, "xyz"[i]) +
                  " is not positive; an axis that runs backwards needs 'space directions'");
    }
    steps(column, column) = spacing;
    if (has_min) geometry.origin[column] = mins[a] + (node ? 0.0 : 0.5 * spacing);
  }
  if (const auto* text = header.find("spaceorigin")) {
    std::string inside = *text;
    std::replace_if(
        inside.begin(), inside.end(), [](char c) { return c == '(' || c == ',' || c == ')'; }, ' ');
    geometry.origin = parse_vector(header.field("space origin"), inside);
  }
  if (world.flip_x) {
    steps.row(0) *= -1;
    geometry.origin.x() *= -1;
  }
  set_axes(geometry, steps, directions.empty() ? 3 : static_cast<int>(axes.size()));
  return geometry;
}

/// `data file`: a name, `pattern min max step [subdim]`, or LIST. The data are cut into equal parts.
std::vector<std::string> data_file_names(const Header& header, const std::vector<std::int64_t>& sizes) {
  const std::string& text = header.need("datafile");
  if (text.compare(0, 4, "LIST") == 0) {
    if (header.listed_files.empty())
      throw Error(header.name + ": 'data file: LIST' is followed by no file name");
    return header.listed_files;
  }
  const auto words = words_of(text);
  if (words.size() < 4 || text.find('%') == std::string::npos) return {text};
  const Field field = header.field("data file");
  std::vector<std::int64_t> numbers;
  for (std::size_t i = 1; i < words.size(); ++i) numbers.push_back(parse_integer(field, words[i]));
  if (numbers.size() > 4) field.refuse(text, "pattern, minimum, maximum, step and dimension of a file");
  const std::int64_t dimension = static_cast<std::int64_t>(sizes.size());
  const std::int64_t in_file = numbers.size() == 4 ? numbers[3] : dimension - 1;
  if (in_file < 1 || in_file > dimension)
    field.refuse(text, "files of 1 to " + std::to_string(dimension) + " axes");
  std::int64_t count = 1;
  for (std::int64_t a = in_file; a < dimension; ++a)
    count = checked_product(count, sizes[static_cast<std::size_t>(a)]);
  if (in_file == dimension && numbers[2] != 0) count = (numbers[1] - numbers[0]) / numbers[2] + 1;  // slabs
  return numbered_files(field, words[0], numbers[0], numbers[1], numbers[2], count);
}

std::int64_t parse_skip(const Header& header, std::string_view field, std::int64_t least) {
  const std::string* text = header.find(field);
  if (text == nullptr) return 0;
  const std::int64_t skip = parse_integer(header.field(field), *text);
  if (skip < least) header.field(field).refuse(*text, "at least " + std::to_string(least));
  return skip;
}

}  // namespace

bool is_nrrd(std::string_view start) {
  return start.compare(0, 4, "NRRD") == 0;
}

volume::Volume read_nrrd(InputFile& file, const ReadOptions& options) {
  Header header = read_header(file);
  const std::int64_t dimension = parse_integer(header.field("dimension"), header.need("dimension"));
  if (dimension < 1 || dimension > 16) {
    header.field("dimension").refuse(header.need("dimension"), "1 to 16");
  }
  const auto sizes =
      parse_integers(header.field("sizes"), header.need("sizes"), static_cast<std::size_t>(dimension));
  for (const auto size : sizes) {
    if (size < 1) header.field("sizes").refuse(header.need("sizes"), "at least 1 for each axis");
  }
  VoxelLayout layout;
  layout.type = voxel_type(header);
  layout.geometry = parse_geometry(header, sizes);
  const std::int64_t bytes = checked_bytes(header.name, layout, options);

  const std::string encoding = lower_case(header.need("encoding"));
  const bool text = encoding == "ascii" || encoding == "text" || encoding == "txt";
  const bool gzip = encoding == "gzip" || encoding == "gz";
  if (!text && !gzip && encoding != "raw") {
    header.field("encoding").refuse(header.need("encoding"), "raw, gzip or ascii");
  }
  if (!text && volume::size_in_bytes(layout.type) > 1) {
    const std::string endian = lower_case(header.need("endian"));
    if (endian != "little" && endian != "big") header.field("endian").refuse(endian, "little or big");
    layout.big_endian = endian == "big";
  }
  const std::int64_t line_skip = parse_skip(header, "lineskip", 0);
  const std::int64_t byte_skip = parse_skip(header, "byteskip", encoding == "raw" ? -1 : 0);

  std::unique_ptr<ByteSource> whole, inflated;
  std::int64_t in_source = bytes;
  if (header.find("datafile") != nullptr) {
    DataFiles files;
    for (const auto& name : data_file_names(header, sizes)) files.paths.push_back(beside(file.path(), name));
    const auto parts = static_cast<std::int64_t>(files.paths.size());
    if (layout.geometry.count() % parts != 0 || (text && parts != 1)) {
      throw Error(header.name + ": " + std::to_string(layout.geometry.count()) + " voxels do not fill " +
                  std::to_string(parts) + " data files evenly");
    }
    files.line_skip = line_skip;
    files.byte_skip = byte_skip;
    files.inflate = gzip;
    files.bytes_each = in_source / parts;
    if (text) {
      const auto data = open_data_file(files.paths[0]);
      FileSource source(*data);
      Scanner scanner(source);
      for (std::int64_t n = 0; n < line_skip; ++n) {
        if (scanner.at_end()) throw Error(scanner.name() + ": ends within the lines to skip");
        (void)scanner.line();
      }
      scanner.skip(byte_skip);
      volume::Volume volume = read_ascii(scanner, layout, options);
      volume.attributes = std::move(header.attributes);
      return volume;
    }
    whole = std::make_unique<DataFilesSource>(std::move(files));
  } else {
    for (std::int64_t n = 0; n < line_skip; ++n) (void)file.read_line(kLongestHeader);
    whole = std::make_unique<FileSource>(file);
    if (byte_skip < 0) {
      if (whole->remaining() < bytes && whole->remaining() >= 0) (void)read_binary(*whole, layout, options);
      if (whole->remaining() < 0) throw Error(header.name + ": byte skip -1 needs a file, not a pipe");
      whole->skip(whole->remaining() - bytes);
    } else if (!gzip) {
      whole->skip(byte_skip);
    }
    if (gzip) {
      inflated = std::make_unique<InflateSource>(*whole);
      inflated->skip(byte_skip);
    }
  }
  ByteSource& source = inflated ? *inflated : *whole;
  volume::Volume volume;
  if (text) {
    Scanner scanner(source);
    volume = read_ascii(scanner, layout, options);
  } else {
    volume = read_binary(source, layout, options);
    expect_end(source, bytes);
  }
  volume.attributes = std::move(header.attributes);
  if (const auto* content = header.find("content")) volume.attributes["content"] = *content;
  return volume;
}

}  // namespace vol::io
