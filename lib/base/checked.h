#pragma once
#include <cstdint>
#include <limits>
#include <string>

#include "base/error.h"
#include "base/vec.h"

namespace vol {

/// Product of non-negative sizes; throws vol::Error when it does not fit 63 bits.
/// Sizes come from hostile headers: 1291^3 overflows int, 2^21 cubed overflows this.
[[nodiscard]] inline std::int64_t checked_product(std::int64_t a, std::int64_t b) {
  if (a < 0 || b < 0 || (a != 0 && b > std::numeric_limits<std::int64_t>::max() / a)) {
    throw Error("size " + std::to_string(a) + " x " + std::to_string(b) + " is negative or overflows");
  }
  return a * b;
}

/// Number of samples of a grid; throws vol::Error on a dimension below 1 or on overflow.
[[nodiscard]] inline std::int64_t checked_count(const Dims& dims) {
  for (const auto n : dims) {
    if (n < 1) {
      throw Error("dimensions " + std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " +
                  std::to_string(dims[2]) + ": each must be at least 1");
    }
  }
  return checked_product(checked_product(dims[0], dims[1]), dims[2]);
}

}  // namespace vol
