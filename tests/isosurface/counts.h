#pragma once
#include <cstdint>
#include <cstdlib>

namespace vol::isosurface {

/// How many trials a random test makes: the variable's value, or so many as keep the tests short.
inline std::int64_t count_from_environment(const char* variable, std::int64_t otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoll(text) : otherwise;
}

}  // namespace vol::isosurface
