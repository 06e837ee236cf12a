#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/volume.h"

// Private to lib/io: one reader and, where there is one, one writer a format, each in its own .cpp. Readers
// start at the file's first byte; is_*() judge the first bytes. Finiteness of the voxels is checked by
// read_volume().
namespace vol::io {

[[nodiscard]] bool is_nrrd(std::string_view start);
[[nodiscard]] bool is_meta_image(std::string_view start);
[[nodiscard]] bool is_vtk_xml(std::string_view start);
[[nodiscard]] bool is_vtk_legacy(std::string_view start);
[[nodiscard]] bool is_nifti(std::string_view start);  ///< plain, or gzip of whatever: the reader looks inside

[[nodiscard]] volume::Volume read_nrrd(InputFile& file, const ReadOptions& options);
[[nodiscard]] volume::Volume read_meta_image(InputFile& file, const ReadOptions& options);
[[nodiscard]] volume::Volume read_vti(InputFile& file, const ReadOptions& options);
[[nodiscard]] volume::Volume read_vtk_legacy(InputFile& file, const ReadOptions& options);
[[nodiscard]] volume::Volume read_nifti(InputFile& file, const ReadOptions& options);
[[nodiscard]] volume::Volume read_raw(InputFile& file, const ReadOptions& options);

using Warnings = std::vector<std::string>;

/// `detached`: header at `path`, data beside it.
Warnings write_nrrd(const std::filesystem::path& path, const volume::Volume& volume, bool detached,
                    bool compress);
Warnings write_meta_image(const std::filesystem::path& path, const volume::Volume& volume, bool detached,
                          bool compress);
Warnings write_vti(const std::filesystem::path& path, const volume::Volume& volume, bool compress);
Warnings write_raw(const std::filesystem::path& path, const volume::Volume& volume);

}  // namespace vol::io
