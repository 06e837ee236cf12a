#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "render/options.h"
#include "volume/volume.h"

// What the benchmarks of ray casting draw.
namespace vol::bench {

/// A ball of concentric ripples with a blob beside it, 0 outside: something to skip, something to see.
inline volume::Volume ball(std::int64_t n) {
  volume::GridGeometry geometry;
  geometry.dims = {n, n, n};
  volume::Volume volume = volume::allocate(volume::VoxelType::u8, geometry);
  auto& grid = std::get<volume::Grid<std::uint8_t>>(volume.grid);
  parallel_for(0, n, 4, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) {
      for (std::int64_t j = 0; j < n; ++j) {
        for (std::int64_t i = 0; i < n; ++i) {
          const auto at = [&](std::int64_t v) {
            return 2 * static_cast<double>(v) / static_cast<double>(n - 1) - 1;
          };
          const double r = std::hypot(at(i), at(j), at(k));
          const double ripple = 0.35 + 0.25 * std::cos(20 * r);
          const double blob =
              0.7 * std::exp(-25 * (std::pow(at(i) - 0.3, 2) + std::pow(at(j), 2) + std::pow(at(k), 2)));
          const double v = std::clamp((0.9 - r) * 10, 0.0, 1.0) * std::min(1.0, ripple + blob);
          grid(i, j, k) = static_cast<std::uint8_t>(std::lround(255 * v));
        }
      }
    }
  });
  return volume;
}

inline render::Scene scene(bool sharp, double longest) {
  render::Scene s;
  s.view.azimuth = 30;
  s.view.elevation = 20;
  s.view.width = 1.6 * longest;
  const std::vector<transfer::OpacityPoint> soft{{0, 0}, {255, 0.05}};
  const std::vector<transfer::OpacityPoint> steep{{0, 0}, {0.4 * 255, 0}, {0.6 * 255, 0.5}, {255, 0.5}};
  s.transfer = transfer::TransferFunction({{0, {0, 0, 0}}, {255, {1, 1, 1}}}, sharp ? steep : soft);
  return s;
}

}  // namespace vol::bench
