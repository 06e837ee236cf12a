#include "fuzz_reader.h"
#include "io/vdb.h"

namespace {

vol::volume::Volume read(vol::io::InputFile& file, const vol::io::ReadOptions& options) {
  if (!vol::io::is_vdb(file.peek(8))) throw vol::Error("no OpenVDB file");
  if (!vol::io::is_coefficients(file))
    return vol::io::read_vdb_volume(file, {.memory_limit = options.memory_limit});
  (void)vol::io::read_coefficients(file, options.memory_limit);
  throw vol::Error("coefficients");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  vol::io::fuzz_reader(data, size, read);
  return 0;
}
