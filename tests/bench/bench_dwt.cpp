// The wavelet transform of a cube of floats, and the roofline beside it: `roofline` is the share of the time
// that the bytes which must move (the volume read, the coefficients written, each once) take at the copy
// bandwidth that this program measures on this machine with the same number of threads.
//   bench_dwt --benchmark_filter=coiflet --benchmark_repetitions=9
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/parallel.h"
#include "base/timer.h"
#include "noise_cube.h"
#include "wavelet/dwt.h"
#include "wavelet/significance.h"

namespace {

using namespace vol;

/// Bytes a second, read and written, of the fastest of nine copies of 64 MiB into memory that is mapped
/// already.
double copy_bandwidth() {
  constexpr std::int64_t kFloats = 1 << 24;
  Buffer<float> from(kFloats, 1), to(kFloats, 0);
  double best = 0;
  for (int run = 0; run < 9; ++run) {
    const Timer timer;
    parallel_for(0, kFloats, kFloats / 16, [&](std::int64_t a, std::int64_t b) {
      std::memcpy(to.data() + a, from.data() + a, static_cast<std::size_t>(b - a) * sizeof(float));
    });
    benchmark::DoNotOptimize(to.data());
    best = std::max(best, 2.0 * kFloats * sizeof(float) / timer.seconds());
  }
  return best;
}

void report(benchmark::State& state, std::int64_t n, int levels) {
  // A pass over each level's approximation: 1 + 1/8 + 1/64 ... volumes read, as many written.
  double passes = 0;
  for (int m = 0; m < levels; ++m) passes += std::pow(0.125, m);
  const double bytes = 2 * passes * static_cast<double>(n * n * n) * sizeof(float);
  static std::map<int, double> bandwidth;
  auto& speed = bandwidth[thread_count()];
  if (speed == 0) speed = copy_bandwidth();
  const auto runs = static_cast<double>(state.iterations());
  state.counters["voxels/s"] =
      benchmark::Counter(static_cast<double>(n * n * n) * runs, benchmark::Counter::kIsRate);
  state.counters["GB/s"] = benchmark::Counter(bytes * runs / 1e9, benchmark::Counter::kIsRate);
  state.counters["copy_GB/s"] = speed / 1e9;
  state.counters["roofline"] = benchmark::Counter(bytes / speed * runs, benchmark::Counter::kIsRate);
}

void analysis(benchmark::State& state, const std::string& name) {
  const std::int64_t n = state.range(0);
  set_thread_count(static_cast<int>(state.range(1)));
  const auto& volume = noise_cube(n);
  for (auto _ : state) benchmark::DoNotOptimize(wavelet::analyze<float>(volume, {.wavelet = name}, {0, 1}));
  report(state, n, 3);
}

void synthesis(benchmark::State& state, const std::string& name) {
  const std::int64_t n = state.range(0);
  set_thread_count(static_cast<int>(state.range(1)));
  const auto d = wavelet::analyze<float>(noise_cube(n), {.wavelet = name}, {0, 1});
  for (auto _ : state) benchmark::DoNotOptimize(wavelet::synthesize(d));
  report(state, n, 3);
}

void rejection(benchmark::State& state) {
  const std::int64_t n = state.range(0);
  set_thread_count(static_cast<int>(state.range(1)));
  const auto d = wavelet::analyze<float>(noise_cube(n), {}, {0, 1});
  for (auto _ : state) {
    state.PauseTiming();
    auto copy = d;
    state.ResumeTiming();
    benchmark::DoNotOptimize(wavelet::reject(copy, {.keep = n * n * n / 20}));
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* name : {"haar", "daubechies-4", "coiflet-6", "daubechies-20", "battle-lemarie"}) {
    for (const auto& [label, run] :
         {std::pair{"analyze/", &analysis}, std::pair{"synthesize/", &synthesis}}) {
      benchmark::RegisterBenchmark((label + std::string(name)).c_str(), run, std::string(name))
          ->ArgNames({"n", "threads"})
          ->ArgsProduct({{256}, {1, 2}})
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  }
  benchmark::RegisterBenchmark("reject/keep", rejection)
      ->ArgNames({"n", "threads"})
      ->ArgsProduct({{256}, {1, 2}})
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
