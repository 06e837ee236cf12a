// Kernel timings of the ray casters; run alone on the machine:
//   bench_raycast --benchmark_repetitions=9 --benchmark_report_aggregates_only=true
// Items a second are samples taken. The floor of trilinear u8 sampling is four 32-bit gathers a sample, each
// of the two voxels along x.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/parallel.h"
#include "render/packet.h"

namespace {

using namespace vol;

/// A ball of concentric ripples with a blob beside it, 0 outside: something to skip, something to see.
volume::Volume ball(std::int64_t n) {
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

render::Scene scene(bool sharp, double longest) {
  render::Scene s;
  s.view.azimuth = 30;
  s.view.elevation = 20;
  s.view.width = 1.6 * longest;
  const std::vector<transfer::OpacityPoint> soft{{0, 0}, {255, 0.05}};
  const std::vector<transfer::OpacityPoint> steep{{0, 0}, {0.4 * 255, 0}, {0.6 * 255, 0.5}, {255, 0.5}};
  s.transfer = transfer::TransferFunction({{0, {0, 0, 0}}, {255, {1, 1, 1}}}, sharp ? steep : soft);
  return s;
}

render::RenderOptions options(render::Quadrature quadrature, bool skip) {
  render::RenderOptions o;
  o.quadrature = quadrature;
  o.skip_empty = skip;
  return o;
}

void cast(benchmark::State& state, bool sharp, render::Quadrature quadrature, bool skip, bool shaded) {
  static const volume::Volume volume = ball(256);
  render::Scene s = scene(sharp, 255);
  if (shaded) s.shading = render::Shading{};
  const auto o = options(quadrature, skip);
  std::int64_t samples = 0;
  const render::PacketVolume prepared(volume);
  const render::PacketScene ready(prepared, s, o);
  for (auto _ : state) {
    const auto result = ready.cast(s.view);
    samples += result.counts.samples;
    benchmark::DoNotOptimize(result.image.pixels.data());
  }
  state.SetItemsProcessed(samples);
  state.SetLabel(std::string(render::packet_instruction_set()) + ", " + std::to_string(thread_count()) +
                 " threads");
}

void macrocells(benchmark::State& state) {
  const volume::Volume volume = ball(256);
  for (auto _ : state) benchmark::DoNotOptimize(index::macrocells(volume).ranges.data());
  state.SetBytesProcessed(state.iterations() * 256 * 256 * 256);
}

}  // namespace

int main(int argc, char** argv) {
  using render::Quadrature;
  for (const bool sharp : {false, true}) {
    for (const Quadrature q : {Quadrature::rectangle, Quadrature::trapezoid}) {
      for (const bool skip : {false, true}) {
        for (const bool shaded : {false, true}) {
          const std::string name = std::string(sharp ? "sharp" : "soft") +
                                   (q == Quadrature::rectangle ? "/rectangle" : "/trapezoid") +
                                   (skip ? "/skipping" : "/all") + (shaded ? "/shaded" : "/flat");
          benchmark::RegisterBenchmark(name.c_str(), cast, sharp, q, skip, shaded)
              ->Unit(benchmark::kMillisecond)
              ->UseRealTime();
        }
      }
    }
  }
  benchmark::RegisterBenchmark("macrocells", macrocells)->Unit(benchmark::kMillisecond)->UseRealTime();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
