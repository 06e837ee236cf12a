// The split kernel whose pieces keep a bound on the error: as packet_split_kernel.cpp, apart from it so that
// both compile at once.
#include "render/packet_job.h"
// The targets come before Highway:
#include "render/packet_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/packet_adaptive_kernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file again:
#include <hwy/highway.h>

#include "render/packet_split-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

template <PacketVoxels kVoxels, int kChannels>
void adaptive_nodes(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  job.nodes == 2 ? Split<kVoxels, kChannels, 2, true>(job, rays).cast(pixels)
                 : Split<kVoxels, kChannels, 3, true>(job, rays).cast(pixels);
}

template <PacketVoxels kVoxels>
void adaptive_voxels(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  job.transfer.affine && !job.shaded ? adaptive_nodes<kVoxels, 1>(job, rays, pixels)
                                     : adaptive_nodes<kVoxels, 3>(job, rays, pixels);
}

void adaptive(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  switch (job.type) {
    case PacketVoxels::u8:
      return adaptive_voxels<PacketVoxels::u8>(job, rays, pixels);
    case PacketVoxels::two_bytes:
      return adaptive_voxels<PacketVoxels::two_bytes>(job, rays, pixels);
    case PacketVoxels::f32:
      return adaptive_voxels<PacketVoxels::f32>(job, rays, pixels);
  }
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::render {

HWY_EXPORT(adaptive);

void cast_adaptive(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  HWY_DYNAMIC_DISPATCH(adaptive)(job, rays, pixels);
}

}  // namespace vol::render
#endif
