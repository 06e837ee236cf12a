#include "base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <memory>

namespace vol {
namespace {

std::unique_ptr<tbb::global_control>& control() {
  static std::unique_ptr<tbb::global_control> limit;
  return limit;
}

// The outermost loop. Every thread counts its chunks here, so they share a cache line with nothing else.
struct alignas(64) Chunks {
  std::atomic<std::int64_t> total{0};
  std::atomic<std::int64_t> done{0};
};
Chunks chunks_of_loop;

/// Counts the chunks of a loop, if it is the outermost.
class CountedLoop {
 public:
  explicit CountedLoop(std::int64_t total) {
    std::int64_t none = 0;
    is_outermost_ = chunks_of_loop.total.compare_exchange_strong(none, total);
  }
  ~CountedLoop() {
    if (!is_outermost_) return;
    chunks_of_loop.done.store(0);
    chunks_of_loop.total.store(0);
  }
  CountedLoop(const CountedLoop&) = delete;
  CountedLoop& operator=(const CountedLoop&) = delete;
  void chunk_done() const {
    if (is_outermost_) chunks_of_loop.done.fetch_add(1, std::memory_order_relaxed);
  }

 private:
  bool is_outermost_;
};

}  // namespace

void set_thread_count(int threads) {
  control().reset();
  if (threads > 0) {
    control() = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                      static_cast<std::size_t>(threads));
  }
}

int thread_count() {
  return static_cast<int>(
      std::min<std::size_t>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism),
                            static_cast<std::size_t>(std::max(1, tbb::info::default_concurrency()))));
}

void parallel_for(std::int64_t begin, std::int64_t end, std::int64_t grain,
                  const std::function<void(std::int64_t, std::int64_t)>& work) {
  if (end <= begin) return;
  grain = std::max<std::int64_t>(1, grain);
  const std::int64_t chunks = (end - begin + grain - 1) / grain;
  const CountedLoop loop(chunks);
  tbb::parallel_for(
      std::int64_t{0}, chunks,
      [&](std::int64_t c) {
        work(begin + c * grain, std::min(end, begin + (c + 1) * grain));
        loop.chunk_done();
      },
      tbb::simple_partitioner());
}

LoopProgress loop_progress() noexcept {
  const std::int64_t total = chunks_of_loop.total.load();
  return {std::min(total, chunks_of_loop.done.load()), total};
}

}  // namespace vol
