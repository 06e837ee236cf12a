// Fourier volume rendering by its parts, for a cube of n: a view's slice by each filter, the inverse
// transform of a picture of n^2, and the transform of the volume, beside FFTW's own of three dimensions
// (`fftw`) by the same kind of plan, in place, padded by the same.
//   bench_fourier --benchmark_filter=slice --benchmark_repetitions=9
#include <benchmark/benchmark.h>
#include <fftw3.h>

#include <map>
#include <tuple>

#include "base/parallel.h"
#include "camera/camera.h"
#include "fourier/models.h"
#include "fourier/projection.h"
#include "noise_cube.h"

namespace {

using namespace vol;

fourier::SpectrumInfo info_of(std::int64_t n, int pad) {
  fourier::SpectrumInfo info;
  info.geometry = noise_cube(n).geometry();
  info.padding = pad;
  for (auto& m : info.padded) m = fourier::padded_size(n, pad);
  return info;
}

/// One at a time: two of 512^3 would not fit beside each other everywhere.
const fourier::SliceSource<float>& source(std::int64_t n, int pad) {
  static std::map<std::tuple<std::int64_t, int>, fourier::SliceSource<float>> kept;
  if (!kept.contains({n, pad})) {
    kept.clear();
    const auto spectrum =
        fourier::transform<float>(info_of(n, pad), fourier::plain_model(noise_cube(n)).sources);
    kept.emplace(std::tuple{n, pad}, fourier::slice_source(spectrum, 16));
  }
  return kept.at({n, pad});
}

/// Views all around, of the volume's own size and pitch; at the picture's own frequencies, as programs of
/// cryo-microscopy take them.
std::vector<fourier::SliceView> views(const fourier::SpectrumInfo& info) {
  std::vector<fourier::SliceView> all;
  const auto n = static_cast<int>(info.geometry.dims[0]);
  for (int i = 0; i < 16; ++i) {
    camera::View view;
    view.width = n;
    view.azimuth = 22.5 * i + 3;
    view.elevation = 11.0 * (i % 8) - 40;
    all.push_back(fourier::slice_view(
        info, camera::Camera(view, info.geometry.centre(), static_cast<double>(n - 1), n, n), n, n, true));
  }
  return all;
}

void views_a_second(benchmark::State& state, const char* filter_name, bool inverse_too) {
  const std::int64_t n = state.range(0);
  const int pad = static_cast<int>(state.range(1));
  set_thread_count(static_cast<int>(state.range(2)));
  const auto& spectrum = source(n, pad);
  const fourier::Filter filter(filter_name, pad);
  fourier::Projector<float> projector(spectrum, filter);
  const auto all = views(spectrum.info());
  std::vector<Buffer<float>> pictures;
  std::size_t next = 0;
  for (auto _ : state) {
    const auto before = projector.times();
    projector.project(all[next++ % all.size()], {{1.0}}, pictures);
    const auto& after = projector.times();
    state.SetIterationTime(inverse_too ? after.inverse - before.inverse : after.slice - before.slice);
    benchmark::DoNotOptimize(pictures.data());
  }
}

void transform(benchmark::State& state) {
  const std::int64_t n = state.range(0);
  const int pad = static_cast<int>(state.range(1));
  set_thread_count(static_cast<int>(state.range(2)));
  const auto info = info_of(n, pad);
  const auto model = fourier::plain_model(noise_cube(n));
  for (auto _ : state) benchmark::DoNotOptimize(fourier::transform<float>(info, model.sources));
}

/// The data are laid into the padded box each time, as transform() does; the plan is made beforehand.
void fftw(benchmark::State& state) {
  const std::int64_t n = state.range(0), m = n * state.range(1), row = 2 * (m / 2 + 1);
  const auto threads = static_cast<int>(state.range(2));
  if (threads > 1 && fftwf_init_threads() == 0) return state.SkipWithError("no threads in FFTW");
  fftwf_plan_with_nthreads(threads);
  Buffer<float> data(static_cast<std::size_t>(row * m * m));
  const auto size = static_cast<int>(m);
  const auto plan = fftwf_plan_dft_r2c_3d(size, size, size, data.data(),
                                          reinterpret_cast<fftwf_complex*>(data.data()), FFTW_ESTIMATE);
  const auto& voxels = std::get<volume::Grid<float>>(noise_cube(n).grid).voxels;
  for (auto _ : state) {
    state.PauseTiming();
    std::fill(data.begin(), data.end(), 0.0f);
    for (std::int64_t k = 0; k < n; ++k) {
      for (std::int64_t j = 0; j < n; ++j)
        std::copy_n(voxels.begin() + (k * n + j) * n, n, data.begin() + (k * m + j) * row);
    }
    state.ResumeTiming();
    fftwf_execute(plan);
    benchmark::DoNotOptimize(data.data());
  }
  fftwf_destroy_plan(plan);
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* filter :
       {"nearest", "trilinear", "catmull-rom", "catmull-rom-fast", "sinc:5", "es:4", "es:6", "es:8"}) {
    benchmark::RegisterBenchmark((std::string("slice/") + filter).c_str(), views_a_second, filter, false)
        ->ArgNames({"n", "pad", "threads"})
        ->ArgsProduct({{256}, {1, 2}, {1, 2}})
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime();
  }
  benchmark::RegisterBenchmark("inverse", views_a_second, "nearest", true)
      ->ArgNames({"n", "pad", "threads"})
      ->ArgsProduct({{64, 128, 256, 512}, {1}, {1, 2}})
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime();
  for (const auto& [name, run] : {std::pair{"transform", &transform}, std::pair{"fftw", &fftw}}) {
    benchmark::RegisterBenchmark(name, run)
        ->ArgNames({"n", "pad", "threads"})
        ->ArgsProduct({{256}, {1, 2}, {1, 2}})
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
