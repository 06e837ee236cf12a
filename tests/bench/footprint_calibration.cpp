// footprint_calibration [PICTURES [SEED [WAVELET...]]]: whether footprints keep the error asked for, as a
// table (CSV): for every wavelet and error that many pictures of noise, at random views, against exact
// integrals at every pixel. Shares of the error asked for: the largest error of a pixel, the estimate; and
// how many pictures exceed it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "../render/noise_volume.h"
#include "render/wavelet_footprints.h"
#include "render/wavelet_xray.h"
#include "wavelet/dwt.h"

using namespace vol;
using namespace vol::render;

int main(int argc, char** argv) {
  const int pictures = argc > 1 ? std::atoi(argv[1]) : 18;
  Rng rng(argc > 2 ? static_cast<std::uint64_t>(std::atoll(argv[2])) : 1);
  std::puts("wavelet,error,pictures,exceeded,largest,largest_estimate,terms_by_tables");
  std::vector<const char*> wavelets(argv + std::min(argc, 3), argv + argc);
  if (wavelets.empty()) wavelets = {"daubechies-4", "daubechies-8", "coiflet-6"};
  for (const char* wavelet : wavelets) {
    for (const double error : {1e-2, 1e-3, 1e-4}) {
      int exceeded = 0;
      double largest = 0, estimate = 0;
      std::int64_t by_tables = 0;
      for (int n = 0; n < pictures; ++n) {
        const Dims dims{16 + static_cast<std::int64_t>(rng.below(9)),
                        16 + static_cast<std::int64_t>(rng.below(9)),
                        16 + static_cast<std::int64_t>(rng.below(9))};
        const auto volume = noise(dims, rng.below(1U << 30), -0.5, 0.5);
        auto coefficients =
            wavelet::analyze<double>(volume, {.wavelet = wavelet, .levels = 1}, volume::value_range(volume));
        const wavelet::Expansion field(std::move(coefficients), {.depth = 3});
        Scene scene;
        scene.model = Model::xray;
        scene.view.azimuth = rng.uniform(0, 360);
        scene.view.elevation = std::asin(rng.uniform(-1, 1)) * 180 / M_PI;
        const RenderOptions options{.width = 41, .height = 37};
        WaveletFootprints footprints(field, scene, options, error);
        const auto drawn = footprints.draw().image, exact = WaveletXray(field).draw(scene, options).image;
        double off = 0, least = HUGE_VAL, most = -HUGE_VAL;
        for (int y = 0; y < options.height; ++y) {
          for (int x = 0; x < options.width; ++x) {
            const double truth = exact.at(x, y, 0);
            off = std::max(off, std::abs(drawn.at(x, y, 0) - truth));
            least = std::min(least, truth);
            most = std::max(most, truth);
          }
        }
        const auto& report = footprints.report();
        const double share = off / (error * (most - least));
        exceeded += share > 1;
        largest = std::max(largest, share);
        estimate = std::max(estimate, report.estimate / report.allowed);
        by_tables += report.terms_tables;
      }
      std::printf("%s,%g,%d,%d,%.2f,%.2f,%lld\n", wavelet, error, pictures, exceeded, largest, estimate,
                  static_cast<long long>(by_tables));
      std::fflush(stdout);
    }
  }
}
