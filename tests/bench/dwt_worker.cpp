// Runs transforms on request, so that another program can time them between its own runs.
//   dwt_worker N    a cube of N^3 floats; then a line on standard input
//   WAVELET LEVELS THREADS analyze|synthesize
// is answered by the seconds that it took.
#include <iostream>
#include <string>

#include "base/parallel.h"
#include "base/rng.h"
#include "base/timer.h"
#include "wavelet/dwt.h"

int main(int argc, char** argv) {
  using namespace vol;
  const std::int64_t n = argc > 1 ? std::stoll(argv[1]) : 256;
  volume::GridGeometry geometry;
  geometry.dims = {n, n, n};
  volume::Volume volume = volume::allocate(volume::VoxelType::f32, geometry);
  Rng rng(1);
  for (float& v : std::get<volume::Grid<float>>(volume.grid).voxels) v = static_cast<float>(rng.uniform());
  wavelet::Decomposition<float> coefficients;
  std::string name, direction;
  int levels = 0, threads = 0;
  while (std::cin >> name >> levels >> threads >> direction) {
    set_thread_count(threads);
    const wavelet::DwtOptions options{.wavelet = name, .levels = levels};
    double seconds = 0;
    if (direction == "analyze") {
      coefficients = {};
      const Timer timer;
      coefficients = wavelet::analyze<float>(volume, options, {0, 1});
      seconds = timer.seconds();
    } else {
      if (coefficients.wavelet != name || coefficients.levels != levels) {
        coefficients = wavelet::analyze<float>(volume, options, {0, 1});
      }
      const Timer timer;
      const auto back = wavelet::synthesize(coefficients);
      seconds = back.voxels.empty() ? -1 : timer.seconds();
    }
    std::cout << seconds << std::endl;
  }
}
