#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <variant>

#include "io/file.h"
#include "volume/volume.h"
#include "wavelet/decomposition.h"

// OpenVDB files: volumes and wavelet coefficients. The geometry stands in the metadata (exact, and the
// authority for files of ours) and, for other programs, in the grid's transform. Output is content alone: the
// id that OpenVDB draws at random for every file is replaced by a hash of the content, so that equal content
// gives equal bytes.
namespace vol::io {

using Attributes = std::map<std::string, std::string>;

struct VdbOptions {
  std::string array;              ///< which grid of a foreign file; empty: the first scalar one
  std::int64_t memory_limit = 0;  ///< bytes the dense result may take; 0: the machine's memory
};

/// True for the first bytes (8 or more) of an OpenVDB file.
[[nodiscard]] bool is_vdb(std::string_view first_bytes);
/// True where the file holds wavelet coefficients written by write_coefficients(); consumes nothing. It looks
/// at the first 4096 bytes, where the metadata stand.
[[nodiscard]] bool is_coefficients(InputFile& file);

/// Reads a volume, dense. Types narrower than f32 were stored as f32, i32 and u32 as f64, and come back as
/// they were. A file without metadata of ours (a fog volume, a level set) becomes the dense box of its active
/// voxels, inactive ones holding what the tree holds there (the background), placed by the grid's linear
/// transform. Throws vol::Error for coefficients (naming vol-dwt --inverse), for damaged files, active voxels
/// outside the stated dims, a non-linear transform, and a box that needs more than the memory limit.
[[nodiscard]] volume::Volume read_vdb_volume(InputFile& file, const VdbOptions& options = {});

/// Writes a volume as one grid named "density": f32 and f64 as they are, i8 to u16 and f16 as f32, i32 and
/// u32 as f64, all exactly, with a voxel_type note. Voxels equal to 0 are neither stored nor active. Refuses
/// NaN and infinity.
void write_vdb_volume(const std::filesystem::path& path, const volume::Volume& volume);

/// A wavelet transform as a file holds it, with the attributes that came with it.
struct Coefficients {
  std::variant<wavelet::Decomposition<float>, wavelet::Decomposition<double>> decomposition;
  Attributes attributes;
};

/// One sparse grid per subband, "level1.LLH", the approximation "levelM.LLL"; grid coordinate = coefficient
/// index (lower + ijk). Zeros are neither stored nor active. "-" is standard output.
void write_coefficients(const std::filesystem::path& path, const wavelet::Decomposition<float>& decomposition,
                        const Attributes& attributes);
void write_coefficients(const std::filesystem::path& path,
                        const wavelet::Decomposition<double>& decomposition, const Attributes& attributes);

/// Inverse of write_coefficients(). Subbands come in the order that Decomposition states; a subband with no
/// grid is zero. Throws vol::Error where the dense subbands would take more than `memory_limit` bytes (0: the
/// machine's memory), before any is allocated, and where a grid reaches outside its subband.
[[nodiscard]] Coefficients read_coefficients(const std::filesystem::path& path,
                                             std::int64_t memory_limit = 0);
[[nodiscard]] Coefficients read_coefficients(InputFile& file, std::int64_t memory_limit = 0);

}  // namespace vol::io
