#include "io/any_volume.h"

#include "base/error.h"
#include "io/header_text.h"

namespace vol::io {

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
  static const std::string known = "nrrd, nhdr, mha, mhd, vti, vdb, raw";
  const bool to_stream = is_standard_stream(path);
  std::string name = lower_case(format);
  if (name.empty() && !to_stream) name = lower_case(path.extension().string()).erase(0, 1);
  if (name.empty() && !to_stream) throw Error(path.string() + ": has no extension; give --format: " + known);
  if (!name.empty() && (", " + known + ",").find(", " + name + ",") == std::string::npos) {
    throw Error((to_stream ? "standard output" : path.string()) + ": cannot write the format '" + name +
                "', expected one of " + known);
  }
  require_writable(path);
}

std::vector<std::string> write_any_volume(const std::filesystem::path& path, const volume::Volume& volume,
                                          const WriteOptions& options) {
  if (options.format != "vdb" && !(options.format.empty() && path.extension() == ".vdb")) {
    return write_volume(path, volume, options);
  }
  write_vdb_volume(path, volume);
  return {};
}

}  // namespace vol::io
