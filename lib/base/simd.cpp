#include "base/simd.h"

#include <hwy/highway.h>

#include <cstdint>
#include <string>

#include "base/error.h"

namespace vol {
namespace {

constexpr std::int64_t kPortable = HWY_SCALAR | HWY_EMU128;

struct Limit {
  const char* name;
  std::int64_t disabled;
};

#if HWY_ARCH_X86
constexpr std::int64_t kAvx512 = HWY_AVX3 | HWY_AVX3_DL;
constexpr Limit kLimits[] = {
    {"portable", ~kPortable}, {"SSE4", kAvx512 | HWY_AVX2}, {"AVX2", kAvx512}, {"AVX-512", 0}};
#else
constexpr Limit kLimits[] = {{"portable", ~kPortable}};
#endif

}  // namespace

void limit_simd(std::string_view most) {
  if (most.empty()) return;
  std::string names;
  for (const Limit& limit : kLimits) {
    if (most == limit.name) {
      hwy::DisableTargets(limit.disabled);
      return;
    }
    names += (names.empty() ? "" : ", ") + std::string(limit.name);
  }
  throw Error("PRECIS_SIMD=" + std::string(most) + ": expected one of " + names);
}

const char* simd_name() {
  const std::int64_t targets = hwy::SupportedTargets();
  hwy::GetChosenTarget().Update(targets);  // Highway 1.0's question chooses anew, disabled targets among them
#if HWY_ARCH_X86
  if ((targets & kAvx512) != 0) return "AVX-512";
  if ((targets & HWY_AVX2) != 0) return "AVX2";
  if ((targets & HWY_SSE4) != 0) return "SSE4";
  if ((targets & HWY_SSSE3) != 0) return "SSSE3";
  return "portable";
#else
  return (targets & ~kPortable) == 0 ? "portable" : hwy::TargetName(targets & -targets);
#endif
}

}  // namespace vol
