// The bare interpolation of the packet caster, in its own order of rays and samples, without transfer
// function and compositing: what uniform casting is held against. One thread, alone on the machine:
//   bench_interpolation --benchmark_repetitions=9 --benchmark_report_aggregates_only=true
// Items a second are samples. `gathers` loads the words that trilinear interpolation needs, at the same
// places, and does nothing with them: the load ports' bound (u8 and u16: four 32-bit words a sample, each of
// the two voxels along x; f32: eight). `frame` is uniform composite casting, rectangle, unshaded, nothing
// skipped.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "base/parallel.h"
#include "bench_scene.h"
#include "render/packet.h"
#include "render/packet_rays.h"
#include "render/packet_set_up.h"
#include "volume/grid_sampler.h"

// The targets come before Highway:
#include "render/packet_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench_interpolation.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file again:
#include <hwy/highway.h>

#include "render/packet_sampling-inl.h"

#ifndef VOL_BENCH_INTERPOLATION_ONCE
#define VOL_BENCH_INTERPOLATION_ONCE
namespace vol::render {
enum class Work { gathers, nearest, trilinear, gradient };
}
#endif

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

template <PacketVoxels kVoxels, Work kWork>
void walk(const PacketJob& job, const PacketRays& rays, float* sums) {
  const I segments = hn::Load(DI(), rays.segments);
  const Position step = load(rays.step_whole, rays.step_part);
  Position position = load(rays.entry_whole, rays.entry_part);
  F sum = constant(0.0F);
  I node = hn::Zero(DI());
  Sampler<kVoxels> sampler;
  for (;;) {
    const MI active = hn::Lt(node, segments);
    if (hn::AllFalse(DI(), active)) break;
    if constexpr (kWork == Work::gathers) {
      sampler.load_corners(job, position);
      const Corners& c = sampler.c;
      // Sums keep the loads alive at a third of interpolation's arithmetic.
      sum = hn::Add(sum, hn::Add(hn::Add(c.v000, c.v010), hn::Add(c.v001, c.v011)));
    } else if constexpr (kWork == Work::nearest) {
      sum = hn::Add(sum, sampler.nearest(job, position));
    } else {
      sum = hn::Add(sum, sampler.value(job, position));
      if constexpr (kWork == Work::gradient) {
        F x, y, z;
        sampler.gradient(x, y, z);
        sum = hn::MulAdd(x, y, hn::Add(sum, z));
      }
    }
    node = hn::Add(node, constant_i(1));
    advance(position, masked(step, hn::Lt(node, segments)));  // rays that have ended wait at their last node
  }
  hn::StoreU(sum, DF(), sums);
}

template <PacketVoxels kVoxels>
void walk_by_work(Work work, const PacketJob& job, const PacketRays& rays, float* sums) {
  switch (work) {
    case Work::gathers:
      return walk<kVoxels, Work::gathers>(job, rays, sums);
    case Work::nearest:
      return walk<kVoxels, Work::nearest>(job, rays, sums);
    case Work::trilinear:
      return walk<kVoxels, Work::trilinear>(job, rays, sums);
    case Work::gradient:
      return walk<kVoxels, Work::gradient>(job, rays, sums);
  }
}

void walk_any(Work work, const PacketJob& job, const PacketRays& rays, float* sums) {
  switch (job.type) {
    case PacketVoxels::u8:
      return walk_by_work<PacketVoxels::u8>(work, job, rays, sums);
    case PacketVoxels::two_bytes:
      return walk_by_work<PacketVoxels::two_bytes>(work, job, rays, sums);
    case PacketVoxels::f32:
      return walk_by_work<PacketVoxels::f32>(work, job, rays, sums);
  }
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::render {
HWY_EXPORT(walk_any);
}
namespace {

using namespace vol;

constexpr int kSide = 512;

template <class T>
const volume::Volume& ball() {
  static const volume::Volume volume = [] {
    volume::Volume result;
    result.grid = volume::converted<T>(bench::ball(256));
    return result;
  }();
  return volume;
}

render::RenderOptions uniform() {
  render::RenderOptions o;
  o.quadrature = render::Quadrature::rectangle;
  o.width = o.height = kSide;
  o.skip_empty = false;
  return o;
}

/// All rays of the picture, made beforehand.
template <class T>
void interpolate(benchmark::State& state, render::Work work) {
  const volume::Volume& volume = ball<T>();
  render::PacketJob job;
  render::set_volume(volume, job);
  const volume::FieldBounds bounds = volume::field_bounds(volume.geometry());
  const render::RayBox box(bounds);
  const camera::Camera camera(bench::scene(false, 255).view, bounds.centre(), bounds.longest_edge(), kSide,
                              kSide);
  const render::PacketRayMaker maker(volume.geometry(), box, camera, uniform().step, nullptr);
  std::vector<render::PacketRays> packets;
  std::int64_t samples = 0;
  const int lanes = render::packet_lanes(), w = lanes >= 8 ? 4 : lanes >= 4 ? 2 : 1, h = lanes / w;
  for (int y = 0; y < kSide; y += h) {
    for (int x = 0; x < kSide; x += w) {
      std::vector<render::PixelPosition> pixels;
      for (int j = 0; j < h; ++j) {
        for (int i = 0; i < w; ++i) pixels.push_back({x + i, y + j});
      }
      render::PacketRays rays{};
      render::PacketChords chords{};
      maker.make(pixels, rays, chords);
      std::int64_t here = 0;
      for (int lane = 0; lane < lanes; ++lane) here += rays.segments[lane];
      if (here > 0) packets.push_back(rays);
      samples += here;
    }
  }
  float sums[render::kMaxLanes];
  for (auto _ : state) {
    for (const render::PacketRays& rays : packets) {
      HWY_DYNAMIC_DISPATCH(render::walk_any)(work, job, rays, sums);
      benchmark::DoNotOptimize(sums);
    }
  }
  state.SetItemsProcessed(state.iterations() * samples);
  state.SetLabel(render::packet_instruction_set());
}

template <class T>
void frame(benchmark::State& state) {
  set_thread_count(1);
  const render::PacketVolume prepared(ball<T>());
  const render::Scene scene = bench::scene(false, 255);
  const render::PacketScene ready(prepared, scene, uniform());
  std::int64_t samples = 0;
  for (auto _ : state) samples += ready.cast(scene.view).counts.samples;
  state.SetItemsProcessed(samples);
}

template <class T>
void add(const std::string& type) {
  const auto named = [&](const char* name, render::Work work) {
    benchmark::RegisterBenchmark((type + "/" + name).c_str(), interpolate<T>, work)
        ->Unit(benchmark::kMillisecond);
  };
  named("gathers", render::Work::gathers);
  named("nearest", render::Work::nearest);
  named("trilinear", render::Work::trilinear);
  named("trilinear+gradient", render::Work::gradient);
  benchmark::RegisterBenchmark((type + "/frame").c_str(), frame<T>)->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int argc, char** argv) {
  add<std::uint8_t>("u8");
  add<std::uint16_t>("u16");
  add<float>("f32");
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
#endif
