#include "io/nrrd_header.h"

#include <algorithm>

namespace vol::io::nrrd {
namespace {

constexpr std::size_t kLongestLine = 1 << 20;  // a key's value may be a page of JSON

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

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\' || c == '\n') result += '\\';
    result += c == '\n' ? 'n' : c;
  }
  return result;
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

}  // namespace vol::io::nrrd
