#include <algorithm>

#include "fuzz_grid.h"

// The first two bytes say how many of the others are the grid; what follows is the solution.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static int grid = -1, solution = -1;
  if (size < 2) return 0;
  const std::size_t length = std::min<std::size_t>(data[0] + 256U * data[1], size - 2);
  vol::io::GridOptions options;
  options.memory_limit = std::int64_t{64} << 20;
  const std::string path = vol::io::memory_file(grid, data + 2, length);
  if (length + 2 < size)
    options.solution = vol::io::memory_file(solution, data + 2 + length, size - 2 - length);
  vol::io::fuzz_grid(path, options);
  return 0;
}
