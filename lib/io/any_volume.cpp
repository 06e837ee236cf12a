#include "io/any_volume.h"

#include "base/error.h"

namespace vol::io {
namespace {

/// Those of write_volume(), and OpenVDB.
std::span<const VolumeWriter> all_writers() {
  static const std::vector<VolumeWriter> writers = [] {
    const auto others = volume_writers();
    std::vector<VolumeWriter> all(others.begin(), others.end());
    all.push_back({"vdb", false, true,  // it widens f16 itself
                   [](const std::filesystem::path& path, const volume::Volume& volume, const WriteOptions&) {
                     write_vdb_volume(path, volume);
                     return std::vector<std::string>();
                   }});
    return all;
  }();
  return writers;
}

}  // namespace

volume::Volume read_any_volume(const std::filesystem::path& path, const ReadOptions& options) {
  InputFile file(path);
  return read_any_volume(file, options);
}

volume::Volume read_any_volume(InputFile& file, const ReadOptions& options) {
  const std::filesystem::path& path = file.path();
  if (options.raw || !is_vdb(file.peek(8))) return read_volume(file, options);
  if (options.volume)
    throw Error(display_name(path) + ": OpenVDB files have no numbered volumes; name one by --array");
  auto volume = read_vdb_volume(file, {.array = options.array, .memory_limit = options.memory_limit});
  try {
    volume::require_finite(volume, options.missing ? &*options.missing : nullptr);
  } catch (const Error& e) {
    throw Error(display_name(path), e);
  }
  return volume;
}

void require_volume_output(const std::filesystem::path& path, const std::string& format) {
  (void)writer_for(path, format, all_writers());
  require_writable(path);
}

std::vector<std::string> write_any_volume(const std::filesystem::path& path, const volume::Volume& volume,
                                          const WriteOptions& options) {
  return write_by(writer_for(path, options.format, all_writers()), path, volume, options);
}

}  // namespace vol::io
