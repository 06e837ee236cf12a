#pragma once
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstdint>

#include "render/packet_job.h"

namespace vol::render {

/// Runs `work` with the packets of each instruction set that was compiled and that this machine has.
template <class Work>
void on_every_instruction_set(Work&& work) {
  for (std::int64_t left = packet_targets() & hwy::SupportedTargets(); left != 0; left &= left - 1) {
    const std::int64_t target = left & -left;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    SCOPED_TRACE(packet_instruction_set());
    work();
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
}

}  // namespace vol::render
