#pragma once
#include <limits>

namespace vol::curvilinear {

/// The larger of two errors; infinite where either is NaN, since what cannot be told is not small.
template <class T>
[[nodiscard]] T larger_error(T a, T b) {
  if (a <= b) return b;
  return a > b ? a : std::numeric_limits<T>::infinity();
}

}  // namespace vol::curvilinear
