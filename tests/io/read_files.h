#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "files.h"

// What the readers' tests of hand-made files have in common.
namespace vol::io {

/// Six voxels, both signs, more than a byte.
inline const std::vector<double> kSix = {1, -2, 300, 4, 5, -600};
inline const std::vector<std::int16_t> kShorts = {1, -2, 300, 4, 5, -600};

/// What reading says where it fails.
inline std::string message_of(const std::filesystem::path& path, const ReadOptions& options = {}) {
  try {
    (void)read_volume(path, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

}  // namespace vol::io
