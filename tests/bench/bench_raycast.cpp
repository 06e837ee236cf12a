// Kernel timings of the ray casters; run alone on the machine:
//   bench_raycast --benchmark_repetitions=9 --benchmark_report_aggregates_only=true
// Items a second are samples taken. The floor of trilinear u8 sampling is four 32-bit gathers a sample, each
// of the two voxels along x.
#include <benchmark/benchmark.h>

#include <string>

#include "base/parallel.h"
#include "bench_scene.h"
#include "render/names.h"
#include "render/packet.h"
#include "render/visibility.h"

namespace {

using namespace vol;

render::RenderOptions options(render::Quadrature quadrature, bool skip) {
  render::RenderOptions o;
  o.quadrature = quadrature;
  o.skip_empty = skip;
  return o;
}

void cast(benchmark::State& state, bool sharp, render::Quadrature quadrature, bool skip, bool shaded) {
  static const volume::Volume volume = bench::ball(256);
  render::Scene s = bench::scene(sharp, 255);
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
  const volume::Volume volume = bench::ball(256);
  for (auto _ : state) benchmark::DoNotOptimize(index::macrocells(volume).ranges.data());
  state.SetBytesProcessed(state.iterations() * 256 * 256 * 256);
}

/// What a scene costs before its first frame, beside its tables.
void visible(benchmark::State& state, bool sharp) {
  const index::Macrocells cells = index::macrocells(bench::ball(256));
  const render::Scene s = bench::scene(sharp, 255);
  for (auto _ : state) benchmark::DoNotOptimize(render::visibility(cells, s.transfer).distance.data());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(cells.ranges.size()));
}

}  // namespace

int main(int argc, char** argv) {
  using render::Quadrature;
  for (const bool sharp : {false, true}) {
    for (const Quadrature q :
         {Quadrature::rectangle, Quadrature::trapezoid, Quadrature::preintegrated, Quadrature::split}) {
      for (const bool skip : {false, true}) {
        for (const bool shaded : {false, true}) {
          const std::string name = std::string(sharp ? "sharp" : "soft") + "/" +
                                   std::string(render::name(q)) + (skip ? "/skipping" : "/all") +
                                   (shaded ? "/shaded" : "/flat");
          benchmark::RegisterBenchmark(name.c_str(), cast, sharp, q, skip, shaded)
              ->Unit(benchmark::kMillisecond)
              ->UseRealTime();
        }
      }
    }
    benchmark::RegisterBenchmark(sharp ? "visibility/sharp" : "visibility/soft", visible, sharp)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
  benchmark::RegisterBenchmark("macrocells", macrocells)->Unit(benchmark::kMillisecond)->UseRealTime();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
