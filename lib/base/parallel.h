#pragma once
#include <cstdint>
#include <functional>
#include <vector>

namespace vol {

/// Number of threads that parallel_for may use in this process; 0 asks for one a core. Call once, at the start.
void set_thread_count(int threads);
[[nodiscard]] int thread_count();

/// Calls work(begin, end) for disjoint chunks of [begin, end) of at most `grain` items, on the process's
/// threads, in no order. Exceptions reach the caller. The cut into chunks depends on `grain` alone, never on
/// the number of threads: a result that is combined per chunk, in chunk order, is the same on every machine.
void parallel_for(std::int64_t begin, std::int64_t end, std::int64_t grain,
                  const std::function<void(std::int64_t, std::int64_t)>& work);

/// How far the outermost parallel_for of this process has come, in chunks; both 0 where none runs. Loops inside
/// its chunks do not count, nor do those that other threads start meanwhile. For whoever watches from another
/// thread, such as a progress bar.
struct LoopProgress {
  std::int64_t done = 0;
  std::int64_t total = 0;
};
[[nodiscard]] LoopProgress loop_progress() noexcept;

/// Maps chunks to partial results and folds them in chunk order: independent of the thread count.
template <class Partial, class Map, class Fold>
Partial parallel_reduce(std::int64_t begin, std::int64_t end, std::int64_t grain, const Map& map, const Fold& fold) {
  const std::int64_t chunks = end > begin ? (end - begin + grain - 1) / grain : 0;
  std::vector<Partial> partials(static_cast<std::size_t>(chunks));
  parallel_for(0, chunks, 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t c = first; c < last; ++c) {
      const std::int64_t from = begin + c * grain;
      partials[static_cast<std::size_t>(c)] = map(from, from + grain < end ? from + grain : end);
    }
  });
  Partial total{};
  for (const auto& partial : partials) fold(total, partial);
  return total;
}

}  // namespace vol
