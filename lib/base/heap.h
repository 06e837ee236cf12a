#pragma once
#include <cstddef>

namespace vol {

/// Gives freed memory back to the system that the C library would keep for later (glibc: in a heap for each
/// thread). For the end of a stage that worked in many small buffers, before one that takes large ones.
void return_freed_memory();

/// Asks for large pages where [data, data + bytes) holds any: for memory about to be written for the first
/// time (the kernel's work for 16384 first touches of 64 MiB takes longer than a transform of it), or read
/// here and there (most walks of the page table are saved). A hint, no more; smaller memory is left as it is.
void prefer_large_pages(void* data, std::size_t bytes);

/// Gives the pages that lie whole in [data, data + bytes) back to the system: what they held is lost, and
/// reads as anything until it is written again. For large memory that is freed only later.
void give_back_pages(void* data, std::size_t bytes);

}  // namespace vol
