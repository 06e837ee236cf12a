// What a cache line costs that lies in memory of so many megabytes, on one thread, alone on the machine:
//   bench_memory
// Large pages, one read a line. `latency`: each read tells the place of the next. `apart`: places in random
// order, known beforehand (from a list that is read as well, 4 bytes a line). `in_order`: one after the
// other, as hardware fetches ahead. `pages`: as `latency`, of one line in each page of 4 KB, 256 lines a
// megabyte: what finding pages costs beside what `latency` of as many lines shows. A volume of 256^3 bytes
// has 16 MB, one of 512^3 128 MB: what frames of the two can differ by, sample for sample.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <random>
#include <vector>

#include "base/buffer.h"
#include "base/heap.h"

namespace {

constexpr std::size_t kLine = 64;

constexpr std::size_t kPage = 4096;

enum class Order { latency, apart, in_order, pages };

void lines(benchmark::State& state, Order order) {
  const std::size_t bytes = static_cast<std::size_t>(state.range(0)) << 20,
                    count = bytes / (order == Order::pages ? kPage : kLine);
  // In pages, each line elsewhere, so that they do not fall into few sets of a cache.
  const auto offset = [&](std::size_t place) {
    return order == Order::pages ? place * kPage + place % (kPage / kLine) * kLine : place * kLine;
  };
  vol::Buffer<char> memory;
  memory.reserve(bytes);
  vol::prefer_large_pages(memory.data(), bytes);
  memory.resize(bytes);
  std::vector<std::uint32_t> places(count);
  std::iota(places.begin(), places.end(), 0U);
  if (order != Order::in_order) std::shuffle(places.begin(), places.end(), std::mt19937(1));
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(memory.data() + offset(places[i]), &places[(i + 1) % count], sizeof(std::uint32_t));
  }
  const auto read = [&](std::size_t place) {
    std::uint32_t next = 0;
    std::memcpy(&next, memory.data() + offset(place), sizeof next);
    return next;
  };
  std::uint32_t at = 0;
  for (auto _ : state) {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (order == Order::latency || order == Order::pages) {
        at = read(at);
      } else {
        sum += read(places[i]);
      }
    }
    benchmark::DoNotOptimize(sum);
    benchmark::DoNotOptimize(at);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
  state.counters["a_line"] =
      benchmark::Counter(static_cast<double>(count),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

BENCHMARK_CAPTURE(lines, latency, Order::latency)->RangeMultiplier(2)->Range(1, 256);
BENCHMARK_CAPTURE(lines, apart, Order::apart)->RangeMultiplier(2)->Range(1, 256);
BENCHMARK_CAPTURE(lines, in_order, Order::in_order)->RangeMultiplier(2)->Range(1, 256);
BENCHMARK_CAPTURE(lines, pages, Order::pages)->RangeMultiplier(2)->Range(1, 256);

}  // namespace

BENCHMARK_MAIN();
