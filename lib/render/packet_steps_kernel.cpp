// The kernel of adaptive steps: as packet_kernel.cpp, apart from it so that both compile at once.
#include "render/packet_job.h"
#include "render/step_control.h"
// The targets come before Highway:
#include "render/packet_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/packet_steps_kernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file again:
#include <hwy/highway.h>

#include "render/packet_steps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

template <PacketVoxels kVoxels>
void steps_voxels(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  job.transfer.affine && !job.shaded ? AdaptiveSteps<kVoxels, 1>(job, rays).cast(pixels)
                                     : AdaptiveSteps<kVoxels, 3>(job, rays).cast(pixels);
}

void steps(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  switch (job.type) {
    case PacketVoxels::u8:
      return steps_voxels<PacketVoxels::u8>(job, rays, pixels);
    case PacketVoxels::two_bytes:
      return steps_voxels<PacketVoxels::two_bytes>(job, rays, pixels);
    case PacketVoxels::f32:
      return steps_voxels<PacketVoxels::f32>(job, rays, pixels);
  }
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::render {

HWY_EXPORT(steps);

void cast_steps(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  HWY_DYNAMIC_DISPATCH(steps)(job, rays, pixels);
}

}  // namespace vol::render
#endif
