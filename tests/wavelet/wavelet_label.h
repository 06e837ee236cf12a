#pragma once
#include <gtest/gtest.h>

#include <string>

namespace vol::wavelet {

/// A wavelet's name as part of a test's.
inline std::string wavelet_label(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  for (char& c : name) {
    if (c == '-' || c == ':') c = '_';
  }
  return name;
}

}  // namespace vol::wavelet
