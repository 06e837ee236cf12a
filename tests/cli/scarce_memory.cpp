// The operators of the whole test program, so that a test can take the memory away. Apart from the tests: a
// compiler that sees both sides of an inlined delete warns of the free() within it.
#include "scarce_memory.h"

#include <cstdlib>
#include <new>

thread_local bool no_memory_is_left = false;

void* operator new(std::size_t n) {
  void* const memory = no_memory_is_left ? nullptr : std::malloc(n > 0 ? n : 1);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void operator delete(void* memory) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
