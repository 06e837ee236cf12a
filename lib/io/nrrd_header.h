#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "io/file.h"
#include "io/header_text.h"
#include "volume/volume.h"

// Private to lib/io: the header of NRRD, after the format's definition
// (teem.sourceforge.net/nrrd/format.html, "Definition of NRRD File Format").
namespace vol::io::nrrd {

inline constexpr std::size_t kLongestHeader = 1 << 24;  // bytes

/// The fields and key/value pairs as they stand.
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

/// Reads to the blank line, or to the end of a header whose data are elsewhere.
[[nodiscard]] Header read_header(InputFile& file);

/// A key or value as key/value lines have it: a backslash before each backslash, and \n for a line's end.
[[nodiscard]] std::string escaped(std::string_view text);

[[nodiscard]] volume::VoxelType voxel_type(const Header& header);

/// Where the samples lie: the axes that become x, y, z, their steps and the origin. `sizes`: samples of each
/// axis of the file. A spacing of `nan` is one that is not known. Where no axis of several samples has a
/// known one it is 1, as in a file without spacings; where some have and others have not, the volume's
/// proportions would be made up: vol::Error.
[[nodiscard]] volume::GridGeometry parse_geometry(const Header& header,
                                                  const std::vector<std::int64_t>& sizes);

}  // namespace vol::io::nrrd
