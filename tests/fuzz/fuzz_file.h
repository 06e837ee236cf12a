#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/error.h"

namespace vol::io {

/// The bytes as a file in memory, by names of several extensions.
class FuzzFile {
 public:
  FuzzFile() : memory_(::memfd_create("fuzz", 0)) {
    std::string folder = (std::filesystem::temp_directory_path() / "fuzz.XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) std::abort();
    folder_ = folder;
  }
  ~FuzzFile() { std::filesystem::remove_all(folder_); }
  FuzzFile(const FuzzFile&) = delete;
  FuzzFile& operator=(const FuzzFile&) = delete;

  void fill(const std::uint8_t* data, std::size_t size) const {
    if (::ftruncate(memory_, 0) != 0 || ::pwrite(memory_, data, size, 0) != static_cast<ssize_t>(size))
      std::abort();
  }
  /// A name of the file with an extension, ".obj".
  [[nodiscard]] std::filesystem::path named(const char* extension) const {
    const auto path = folder_ / (std::string("fuzz") + extension);
    if (!std::filesystem::is_symlink(std::filesystem::symlink_status(path))) {
      std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(memory_), path);
    }
    return path;
  }

 private:
  int memory_;
  std::filesystem::path folder_;
};

/// Runs a reader, which may throw vol::Error with one line and nothing else.
template <class F>
void fuzz_read(const F& read) {
  try {
    read();
  } catch (const Error& e) {
    const std::string message = e.what();
    if (message.empty() || message.find('\n') != std::string::npos) std::abort();
  }
}

}  // namespace vol::io
