#pragma once
#include <string_view>

namespace vol {

/// Keeps the kernels from instruction sets above `most`: "portable" (no SIMD instructions), "SSE4", "AVX2" or
/// "AVX-512"; empty leaves them all. Of what is left the best that the machine has is taken. Not while a
/// kernel runs. Libraries of others (FFTW, the C library) choose for themselves.
///
/// \throws Error for other words
void limit_simd(std::string_view most);

/// What the kernels run on: one of the words of limit_simd(), or "SSSE3", which some of them use and the
/// others take for "portable".
[[nodiscard]] const char* simd_name();

}  // namespace vol
