#pragma once
#include "io/vdb.h"
#include "io/volume.h"

namespace vol::io {

/// read_volume() that knows OpenVDB too, told by its first bytes; for tools that may link it.
[[nodiscard]] volume::Volume read_any_volume(const std::filesystem::path& path,
                                             const ReadOptions& options = {});
/// The same from a file that is open, so that a caller can look at its first bytes before.
[[nodiscard]] volume::Volume read_any_volume(InputFile& file, const ReadOptions& options = {});

/// Throws vol::Error where write_any_volume() would, as far as path and format tell: for tools to ask before
/// long work.
void require_volume_output(const std::filesystem::path& path, const std::string& format = "");

/// write_volume() that knows OpenVDB too: format "vdb", or a path that ends in .vdb or .VDB.
std::vector<std::string> write_any_volume(const std::filesystem::path& path, const volume::Volume& volume,
                                          const WriteOptions& options = {});

}  // namespace vol::io
