#include "fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  vol::io::fuzz_reader(data, size, vol::io::read_meta_image);
  return 0;
}
