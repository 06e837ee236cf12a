#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/file.h"
#include "volume/volume.h"

namespace vol::io {

/// What a headerless file holds: nothing in it can be checked but its size.
struct RawLayout {
  Dims dims{0, 0, 0};  ///< x fastest
  volume::VoxelType type = volume::VoxelType::u8;
  bool big_endian = false;
  std::int64_t skip = 0;  ///< bytes before the first voxel
  Vec3 spacing{1, 1, 1};  ///< world distance between samples
};

struct ReadOptions {
  std::string array;                ///< name of the array (VTK, OpenVDB); empty: the first scalar one
  std::optional<RawLayout> raw{};   ///< read the file as headerless data
  std::optional<int> volume{};      ///< which volume of a 4-D NIfTI file, from 0
  std::optional<double> missing{};  ///< replaces NaN and infinities, which are refused otherwise
  std::int64_t memory_limit = physical_memory();  ///< bytes the voxels may take

  /// Bytes of memory in this machine.
  [[nodiscard]] static std::int64_t physical_memory();
};

/// Reads a volume: NRRD (attached, detached; raw, gzip, ascii), MetaImage (.mha, .mhd), VTK XML image data
/// (.vti), legacy VTK structured points (.vtk), NIfTI-1 (.nii, .nii.gz, .hdr/.img) or raw. The format is told
/// by the first bytes; "-" is standard input. Voxels keep their type, save that a NIfTI scaling gives f32 or
/// f64. Key/value pairs come as attributes.
///
/// Memory taken grows with the data that come, not with a header's promise. Throws vol::Error, one line that
/// names the file at fault (of detached data, the data file): too few or too many data, unusable geometry, a
/// type no volume has, an `array` or `volume` it has none of, NaN or infinity (`missing`), over memory_limit.
[[nodiscard]] volume::Volume read_volume(const std::filesystem::path& path, const ReadOptions& options = {});
/// The same from a file that is open, so that a caller can look at its first bytes before.
[[nodiscard]] volume::Volume read_volume(InputFile& file, const ReadOptions& options = {});

/// The attribute that says what a file holds where that is no scalar field.
inline constexpr const char* kKindKey = "precis.kind";
inline constexpr const char* kIndexKind = "index";

/// Whether a volume that was read is an index volume (index.h), whose voxels are packed entries.
[[nodiscard]] bool is_index(const volume::Volume& volume);

/// Name of the format that the first bytes tell ("NRRD", "MetaImage", ...), or "" where none is known.
[[nodiscard]] std::string_view volume_format(InputFile& file);

struct WriteOptions {
  std::string format{};   ///< an extension without its dot; empty: that of the path, nrrd for "-"
  bool compress = false;  ///< zlib; raw cannot
};

/// One of the formats in which volumes are written.
struct VolumeWriter {
  std::string_view name;  ///< the extension without its dot
  bool is_two_files;      ///< header and data apart: nothing for standard output
  bool takes_f16;         ///< else such volumes come widened, see write_volume()
  std::vector<std::string> (*write)(const std::filesystem::path& path, const volume::Volume& volume,
                                    const WriteOptions& options);
};

/// Those of write_volume().
[[nodiscard]] std::span<const VolumeWriter> volume_writers();

/// The one of `writers` that `format` names or, where that is empty, the path's extension; capitals do not
/// count; nrrd for "-". Throws vol::Error that lists what there is.
[[nodiscard]] const VolumeWriter& writer_for(const std::filesystem::path& path, const std::string& format,
                                             std::span<const VolumeWriter> writers);

/// Writes by that one; the rest is as write_volume() has it.
std::vector<std::string> write_by(const VolumeWriter& writer, const std::filesystem::path& path,
                                  const volume::Volume& volume, const WriteOptions& options);

/// Writes a volume: nrrd, nhdr (header and data apart), mha, mhd (header and data apart), vti or raw. The
/// same volume gives the same bytes. f16 is a type that none of these but raw has: it goes in as f32 with a
/// `precis.voxel_type` attribute and comes back as f16. Files appear whole or not at all.
///
/// \return what the format could not hold (space, attributes ...), one sentence each; empty for a faithful
/// copy \throws vol::Error for an unknown format or a file that cannot be written
std::vector<std::string> write_volume(const std::filesystem::path& path, const volume::Volume& volume,
                                      const WriteOptions& options = {});

}  // namespace vol::io
