// The instruction sets that the packet kernels are compiled for. Included first, and again with each of
// Highway's passes over a kernel's file: no include guard.

// Machines with SSSE3 but not SSE4.1 take the one-lane code. A kernel under the sanitizers takes five minutes
// to compile for each instruction set: there one of vectors and the one-lane code have to do.
#undef HWY_DISABLED_TARGETS
#ifdef PRECIS_FEW_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3 | HWY_AVX3_DL)
#else
#define HWY_DISABLED_TARGETS HWY_SSSE3
#endif
