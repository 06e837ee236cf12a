#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/error.h"
#include "io/volume_formats.h"

namespace vol::io {

/// Gives the bytes to a reader as a file. A reader may throw vol::Error with one line and nothing else; what
/// it returns must have as many voxels as its geometry says.
inline void fuzz_reader(const std::uint8_t* data, std::size_t size,
                        volume::Volume (*read)(InputFile& file, const ReadOptions& options)) {
  static const int memory = ::memfd_create("fuzz", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(memory);
  if (::ftruncate(memory, 0) != 0 || ::pwrite(memory, data, size, 0) != static_cast<ssize_t>(size))
    std::abort();
  ReadOptions options;
  options.memory_limit = std::int64_t{64} << 20;
  options.missing = 0.0;
  try {
    InputFile file(path);
    const volume::Volume volume = read(file, options);
    volume.geometry().validate();
    const auto voxels = volume::visit(volume, [](const auto& grid) { return grid.voxels.size(); });
    if (voxels != static_cast<std::size_t>(volume.geometry().count())) std::abort();
  } catch (const Error& e) {
    const std::string message = e.what();
    if (message.empty() || message.find('\n') != std::string::npos) std::abort();
  }
}

}  // namespace vol::io
