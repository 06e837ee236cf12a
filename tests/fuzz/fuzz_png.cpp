// libFuzzer target: any bytes are an image or a vol::Error.
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/error.h"
#include "io/png.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // A few kilobytes can rightly hold a large white picture, which would only cost time and memory here.
  const auto side = [&](std::size_t at) {
    return data[at] * 256u * 65536u + data[at + 1] * 65536u + data[at + 2] * 256u + data[at + 3];
  };
  if (size >= 24 && std::uint64_t{side(16)} * side(20) > 1000000) return 0;
  try {
    (void)vol::io::decode_png(std::as_bytes(std::span(data, size)), "fuzz");
  } catch (const vol::Error&) {
  }
  return 0;
}
