// make_vdb_seeds FOLDER: small good OpenVDB files, volumes and coefficients, for the fuzzer to start from.
#include <filesystem>

#include "io/vdb.h"

int main(int argc, char** argv) {
  using namespace vol;
  const std::filesystem::path folder = std::filesystem::path(argc > 1 ? argv[1] : "seeds") / "vdb";
  std::filesystem::create_directories(folder);
  volume::GridGeometry g;
  g.dims = {9, 3, 2};
  for (const auto type : {volume::VoxelType::u8, volume::VoxelType::f32, volume::VoxelType::f64}) {
    volume::Volume v = volume::allocate(type, g);
    volume::visit(v, [](auto& grid) {
      using T = typename std::decay_t<decltype(grid)>::value_type;
      for (std::size_t n = 0; n < grid.voxels.size(); ++n)
        grid.voxels[n] = static_cast<T>(static_cast<float>(n));
    });
    io::write_vdb_volume(folder / (std::string(volume::name(type)) + ".vdb"), v);
  }
  wavelet::Decomposition<float> d;
  d.wavelet = "haar";
  d.geometry.dims = {1, 1, 2};
  d.extended_dims = {1, 1, 2};
  d.levels = 1;
  d.range = {0, 1};
  for (const int orientation : {0, 4}) {
    wavelet::Subband<float> band;
    band.orientation = orientation;
    band.dims = {1, 1, 1};
    band.coefficients = Buffer<float>(1, 0.5f);
    d.subbands.push_back(band);
  }
  io::write_coefficients(folder / "coefficients.vdb", d, {});
}
