#include "base/error.h"

#include <algorithm>
#include <string_view>

namespace vol {
namespace {

/// A file is named once, however many of those who open, read and decode it add its name. Readers of other
/// projects quote what they met, line ends too: one line is kept.
std::string with_context(const std::string& context, std::string_view cause) {
  const std::string prefix = context + ": ";
  std::string message = cause.starts_with(prefix) ? std::string(cause) : prefix + std::string(cause);
  const auto unprinted = [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; };
  std::replace_if(message.begin(), message.end(), unprinted, ' ');
  return message;
}

}  // namespace

Error::Error(const std::string& context, const std::exception& cause)
    : std::runtime_error(with_context(context, cause.what())) {}

}  // namespace vol
