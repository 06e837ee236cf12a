// For compare_with_pywavelets.py: one level of the transform of doubles on standard input.
//   dwt_dump WAVELET NX NY NZ < volume > subbands LLL, HLL, LHL, HHL, LLH, ... (x, y, z letters), one after
//   another
#include <cstdio>
#include <string>

#include "wavelet/dwt.h"

int main(int argc, char** argv) {
  using namespace vol;
  if (argc != 5) return 2;
  volume::GridGeometry geometry;
  geometry.dims = {std::stoll(argv[2]), std::stoll(argv[3]), std::stoll(argv[4])};
  volume::Volume volume = volume::allocate(volume::VoxelType::f64, geometry);
  auto& voxels = std::get<volume::Grid<double>>(volume.grid).voxels;
  if (std::fread(voxels.data(), sizeof(double), voxels.size(), stdin) != voxels.size()) return 2;
  const auto d =
      wavelet::analyze<double>(volume, {.wavelet = argv[1], .levels = 1}, volume::value_range(volume));
  for (const auto& band : d.subbands) {
    std::fwrite(band.coefficients.data(), sizeof(double), band.coefficients.size(), stdout);
  }
  return std::fflush(stdout) == 0 ? 0 : 2;
}
