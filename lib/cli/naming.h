#pragma once
#include <filesystem>
#include <string>
#include <utility>

#include "base/error.h"
#include "io/file.h"

namespace vol::cli {

/// Runs f; an error of it that does not say so yet is said to be about this file.
template <class F>
decltype(auto) naming(const std::filesystem::path& path, F&& f) {
  const std::string name = io::display_name(path);
  try {
    return std::forward<F>(f)();
  } catch (const DeviceError&) {
    throw;
  } catch (const Error& error) {
    if (std::string(error.what()).find(name) != std::string::npos) throw;
    throw Error(name, error);
  }
}

}  // namespace vol::cli
