#pragma once
#include "table.h"

// One function a kernel, in the file of its name; CMakeLists.txt lists them.
namespace vol::stability {
#define KERNEL(name) void name(Table& table);
#include "kernels.inc"
#undef KERNEL
}  // namespace vol::stability
