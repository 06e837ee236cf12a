#include <cmath>

#include "fuzz_file.h"
#include "io/mesh.h"

// The same bytes by the names of every format; PLY is told by its first bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const vol::io::FuzzFile file;
  file.fill(data, size);
  for (const char* extension : {".obj", ".stl"}) {
    const auto path = file.named(extension);
    vol::io::fuzz_read([&] {
      const vol::mesh::TriangleMesh mesh = vol::io::read_mesh(path);
      for (const auto& triangle : mesh.triangles) {
        for (const auto corner : triangle) {
          if (corner >= mesh.positions.size()) std::abort();
        }
      }
      for (const auto& p : mesh.positions) {
        for (const auto x : p) {
          if (!std::isfinite(x)) std::abort();
        }
      }
      if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size()) std::abort();
    });
  }
  return 0;
}
