// The instruction sets that the packet kernels are compiled for. Included first, and again with each of
// Highway's passes over a kernel's file: no include guard.

// Machines with SSSE3 but not SSE4.1 take the one-lane code. So does everything under the sanitizers: they
// see its loads one by one but not what a vector gathers, and a kernel for vectors takes them a quarter of an
// hour to compile.
#undef HWY_DISABLED_TARGETS
#ifdef PRECIS_ONE_LANE
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX2 | HWY_AVX3 | HWY_AVX3_DL)
#else
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif
