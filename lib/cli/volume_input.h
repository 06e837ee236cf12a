#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/record.h"
#include "io/file.h"
#include "volume/volume.h"

// How every tool is told which volume to read: a path, and what a headerless or many-headed file leaves open.
// Target vol_cli_volume.
namespace vol::cli {

/// The option group of what add_volume_options() declares.
inline constexpr const char* kVolumeInputGroup = "Volume input";

struct VolumeInput {
  std::filesystem::path path;         ///< "-" is standard input
  std::string array;                  ///< --array
  std::optional<int> volume;          ///< --volume, of a 4-D file
  std::optional<double> missing;      ///< --missing, in place of NaN and infinity
  std::string raw_dims;               ///< --raw-dims; empty: the file has a header
  std::string raw_type = "u8";        ///< --raw-type
  std::string raw_endian = "little";  ///< --raw-endian
  std::int64_t raw_skip = 0;          ///< --raw-skip, bytes
  std::string raw_spacing = "1";      ///< --raw-spacing
  bool index_volumes = false;         ///< are read too, packed as they are; else they are refused
};

/// Declares the positional input and the options above.
void add_volume_input(CLI::App& app, VolumeInput& input,
                      const std::string& description =
                          "Volume (.nrrd .nhdr .mha .mhd .vti .vtk .nii .vdb or raw); - is "
                          "standard input");
/// Declares the options without the path, for tools whose inputs are not one volume.
void add_volume_options(CLI::App& app, VolumeInput& input);

/// Reads the volume (phase "read") and notes it among the record's inputs. Throws vol::Error, besides what
/// reading throws, on an index volume where none is wanted: its bytes are no field's values.
[[nodiscard]] volume::Volume load(const VolumeInput& input, Record& record);
/// The same options applied to another file.
[[nodiscard]] volume::Volume load(const std::filesystem::path& path, const VolumeInput& input,
                                  Record& record);
/// The same from a file that is open, for tools that look at its first bytes.
[[nodiscard]] volume::Volume load(io::InputFile& file, const VolumeInput& input, Record& record);

/// Writes a volume (phase "write") with the record's provenance added to its attributes; notes it among the
/// outputs and warns of what the format cannot hold. `format` empty: by extension, nrrd for "-".
void save(const std::filesystem::path& path, volume::Volume& volume, Record& record,
          const std::string& format = "", bool compress = false);

}  // namespace vol::cli
