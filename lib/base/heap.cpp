#include "base/heap.h"

#include <cstdint>
#include <cstdlib>

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#endif

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace vol {

void return_freed_memory() {
#if defined(__GLIBC__)
  (void)malloc_trim(0);
#endif
}

#if defined(__linux__)
namespace {

/// Calls work(first, bytes) for what lies whole in [data, data + bytes) of pages of a size.
template <class Work>
void for_whole_pages(void* data, std::size_t bytes, std::uintptr_t page, const Work& work) {
  const auto begin = (reinterpret_cast<std::uintptr_t>(data) + page - 1) / page * page;
  const auto end = (reinterpret_cast<std::uintptr_t>(data) + bytes) / page * page;
  if (begin < end) work(reinterpret_cast<void*>(begin), end - begin);
}

}  // namespace
#endif

void prefer_large_pages([[maybe_unused]] void* data, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  constexpr std::uintptr_t kLarge = std::uintptr_t{1} << 21;
  for_whole_pages(data, bytes, kLarge,
                  [](void* first, std::size_t size) { (void)madvise(first, size, MADV_HUGEPAGE); });
#endif
}

void give_back_pages([[maybe_unused]] void* data, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  for_whole_pages(data, bytes, static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE)),
                  [](void* first, std::size_t size) { (void)madvise(first, size, MADV_DONTNEED); });
#endif
}

}  // namespace vol
