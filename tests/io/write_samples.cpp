// write_samples FOLDER: one volume in each format that VTK reads, for open_in_vtk.py.
// write_samples --check FILE: says whether a file holds that volume.
#include <cstdio>
#include <exception>
#include <filesystem>

#include "io/volume.h"

namespace {

int check(const std::filesystem::path& path) {
  using namespace vol;
  try {
    const auto v = io::read_volume(path);
    const auto& g = v.geometry();
    bool same = g.dims == Dims{5, 4, 3} && (g.spacing - Vec3(0.5, 2, 1.25)).norm() < 1e-12 &&
                v.voxel_type() == volume::VoxelType::f32;
    // Legacy files have no direction; VTK's MetaImage writer leaves it out too.
    if (path.extension() == ".vti") same = same && g.index_to_world({1, 1, 1}).isApprox(Vec3(-9, 4, 12.25));
    volume::visit(v, [&](const auto& grid) {
      for (std::size_t n = 0; n < grid.voxels.size(); ++n) {
        same = same && static_cast<double>(grid.voxels[n]) == 3.0 * static_cast<double>(n) + 1;
      }
    });
    std::puts(same ? "as written" : "something else");
  } catch (const std::exception& e) {
    std::puts(e.what());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace vol;
  if (argc > 2) return check(argv[2]);
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
  volume::GridGeometry g;
  g.dims = {5, 4, 3};
  g.spacing = {0.5, 2, 1.25};
  g.origin = {-7, 3.5, 11};
  g.direction << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  g.space = volume::Space::lps;
  for (const auto type :
       {volume::VoxelType::u8, volume::VoxelType::i16, volume::VoxelType::f32, volume::VoxelType::f64}) {
    volume::Volume v = volume::allocate(type, g);
    volume::visit(v, [](auto& grid) {
      using T = typename std::decay_t<decltype(grid)>::value_type;
      for (std::size_t n = 0; n < grid.voxels.size(); ++n)
        grid.voxels[n] = static_cast<T>(static_cast<float>(3 * n + 1));
    });
    v.attributes["precis.tool"] = "write_samples <&>";
    const std::string name = std::string(volume::name(type));
    for (const bool compress : {false, true}) {
      for (const char* format : {"vti", "mha", "mhd"}) {
        io::write_volume(folder / (name + (compress ? "z." : ".") + format), v,
                         {.format = {}, .compress = compress});
      }
    }
  }
}
