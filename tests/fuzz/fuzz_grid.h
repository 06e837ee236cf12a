#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/error.h"
#include "io/grid.h"

namespace vol::io {

/// A file in memory that holds some bytes.
inline std::string memory_file(int& descriptor, const std::uint8_t* data, std::size_t size) {
  if (descriptor < 0) descriptor = ::memfd_create("fuzz", 0);
  if (::ftruncate(descriptor, 0) != 0 || ::pwrite(descriptor, data, size, 0) != static_cast<ssize_t>(size))
    std::abort();
  return "/proc/self/fd/" + std::to_string(descriptor);
}

/// Reads a grid. The reader may throw vol::Error with one line and nothing else; what it returns must be a
/// valid grid.
inline void fuzz_grid(const std::string& path, const GridOptions& options) {
  try {
    curvilinear::require_valid(read_grid(path, options));
  } catch (const Error& e) {
    const std::string message = e.what();
    if (message.empty() || message.find('\n') != std::string::npos) std::abort();
  }
}

}  // namespace vol::io
