#include <nlohmann/json.hpp>

#include "fuzz_file.h"
#include "io/scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const vol::io::FuzzFile file;
  file.fill(data, size);
  const auto path = file.named(".yaml");
  vol::io::fuzz_read([&] { (void)vol::io::to_json(vol::io::read_scene(path).scene).dump(); });
  return 0;
}
