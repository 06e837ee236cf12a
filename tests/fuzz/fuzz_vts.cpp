#include "fuzz_grid.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static int file = -1;
  vol::io::GridOptions options;
  options.memory_limit = std::int64_t{64} << 20;
  vol::io::fuzz_grid(vol::io::memory_file(file, data, size), options);
  return 0;
}
