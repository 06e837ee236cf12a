#pragma once

namespace vol {

/// Gives freed memory back to the system that the C library would keep for later (glibc: in a heap for each
/// thread). For the end of a stage that worked in many small buffers, before one that takes large ones.
void return_freed_memory();

}  // namespace vol
