#include "fuzz_file.h"
#include "io/codebook.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const vol::io::FuzzFile file;
  file.fill(data, size);
  const auto path = file.named(".yaml");
  vol::io::fuzz_read([&] { vol::io::read_codebook(path).validate(); });
  return 0;
}
