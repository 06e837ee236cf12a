// What a cache line costs that lies in memory of so many megabytes, on one thread, alone on the machine:
//   bench_memory
// Large pages, one read a line. `latency`: each read tells the place of the next. `apart`: places in random
// order, known beforehand (from a list that is read as well, 4 bytes a line). `in_order`: one after the
// other, as hardware fetches ahead. A volume of 256^3 bytes has 16 MB, one of 512^3 128 MB: what frames of
// the two can differ by, sample for sample.
#include <benchmark/benchmark.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

namespace {

constexpr std::size_t kLine = 64, kLargePage = std::size_t{2} << 20;

/// Pages of their own, large where the kernel has them.
class Memory {
 public:
  explicit Memory(std::size_t bytes) : bytes_(bytes + kLargePage) {
    mapped_ = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped_ == MAP_FAILED) throw std::runtime_error("no memory");
    const auto address = reinterpret_cast<std::uintptr_t>(mapped_);
    data_ = static_cast<char*>(mapped_) + (kLargePage - address % kLargePage) % kLargePage;
    (void)madvise(data_, bytes, MADV_HUGEPAGE);
    std::memset(data_, 0, bytes);
  }
  ~Memory() { munmap(mapped_, bytes_); }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  [[nodiscard]] char* line(std::size_t i) const { return data_ + i * kLine; }

 private:
  std::size_t bytes_;
  void* mapped_;
  char* data_;
};

enum class Order { latency, apart, in_order };

void lines(benchmark::State& state, Order order) {
  const std::size_t bytes = static_cast<std::size_t>(state.range(0)) << 20, count = bytes / kLine;
  const Memory memory(bytes);
  std::vector<std::uint32_t> places(count);
  std::iota(places.begin(), places.end(), 0U);
  if (order != Order::in_order) std::shuffle(places.begin(), places.end(), std::mt19937(1));
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(memory.line(places[i]), &places[(i + 1) % count], sizeof(std::uint32_t));
  }
  const auto read = [&](std::size_t place) {
    std::uint32_t next = 0;
    std::memcpy(&next, memory.line(place), sizeof next);
    return next;
  };
  std::uint32_t at = 0;
  for (auto _ : state) {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (order == Order::latency) {
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

}  // namespace

BENCHMARK_MAIN();
