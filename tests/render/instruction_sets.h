#pragma once
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstdint>

#include "render/packet_job.h"

namespace vol::render {

/// Runs `work` with the packets of each instruction set that was compiled and that this machine has. \returns
/// how many those are: 1 under the sanitizers (render/packet_targets.h), which compare nothing then.
template <class Work>
int on_every_instruction_set(Work&& work) {
  struct Restored {
    ~Restored() {
      hwy::SetSupportedTargetsForTest(0);
      hwy::GetChosenTarget().DeInit();
    }
  };
  int count = 0;
  for (std::int64_t left = packet_targets() & hwy::SupportedTargets(); left != 0; left &= left - 1) {
    const std::int64_t target = left & -left;
    const Restored restored;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    SCOPED_TRACE(packet_instruction_set());
    work();
    ++count;
  }
  return count;
}

}  // namespace vol::render
