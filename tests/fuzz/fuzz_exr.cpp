// libFuzzer target: any bytes are an image or a vol::Error.
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/error.h"
#include "io/exr.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    (void)vol::io::decode_exr(std::as_bytes(std::span(data, size)), "fuzz");
  } catch (const vol::Error&) {
  }
  return 0;
}
