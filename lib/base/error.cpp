#include "base/error.h"

#include <string_view>

namespace vol {
namespace {

/// A file is named once, however many of those who open, read and decode it add its name.
std::string with_context(const std::string& context, std::string_view cause) {
  const std::string prefix = context + ": ";
  return cause.starts_with(prefix) ? std::string(cause) : prefix + std::string(cause);
}

}  // namespace

Error::Error(const std::string& context, const std::exception& cause)
    : std::runtime_error(with_context(context, cause.what())) {}

}  // namespace vol
