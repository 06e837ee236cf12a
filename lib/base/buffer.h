#pragma once
#include <memory>
#include <new>
#include <vector>

namespace vol {

/// Allocator that leaves trivially constructible elements uninitialised and aligns to a cache line: a volume
/// that is about to be overwritten is not written twice, and pages are touched by the thread that fills them.
/// Behind the last element lie kReadable bytes that may be read (not written): a vector load or gather of an
/// element's word may run over the end.
template <class T>
struct UninitializedAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  static constexpr std::size_t kReadable = 64;

  UninitializedAllocator() = default;
  template <class U>
  UninitializedAllocator(const UninitializedAllocator<U>&) {}

  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T) + kReadable, kAlignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kAlignment); }

  template <class U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;
  }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  friend bool operator==(const UninitializedAllocator&, const UninitializedAllocator&) { return true; }
};

/// Contiguous samples. `Buffer<T>(n)` is NOT zeroed; `Buffer<T>(n, T{})` is.
template <class T>
using Buffer = std::vector<T, UninitializedAllocator<T>>;

}  // namespace vol
