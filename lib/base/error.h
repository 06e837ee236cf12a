#pragma once
#include <stdexcept>
#include <string>

namespace vol {

/// Bad input or an unusable request: what was expected, what came, and, where possible, what to do.
/// One line, no full stop. Tools print it as `tool: message` and exit with 2.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(message) {}
  /// Adds context while unwinding: `context: cause`, what does not print as spaces.
  Error(const std::string& context, const std::exception& cause);
};

/// A device that the work needs is missing on this machine (no EGL): exit status 3.
class DeviceError : public Error {
 public:
  using Error::Error;
};

}  // namespace vol
