// The split kernel, compiled once for each instruction set and chosen when the program runs; apart from
// packet_kernel.cpp so that both compile at once.
#include "render/packet_job.h"
// The targets come before Highway:
#include "render/packet_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/packet_split_kernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file again:
#include <hwy/highway.h>

#include "render/packet_split-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

template <PacketVoxels kVoxels, int kChannels>
void split_nodes(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  switch (job.nodes) {
    case 1:
      return Split<kVoxels, kChannels, 1, false>(job, rays).cast(pixels);
    case 2:
      return Split<kVoxels, kChannels, 2, false>(job, rays).cast(pixels);
    default:
      return Split<kVoxels, kChannels, 3, false>(job, rays).cast(pixels);
  }
}

template <PacketVoxels kVoxels>
void split_voxels(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  job.transfer.affine && !job.shaded ? split_nodes<kVoxels, 1>(job, rays, pixels)
                                     : split_nodes<kVoxels, 3>(job, rays, pixels);
}

void split(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  switch (job.type) {
    case PacketVoxels::u8:
      return split_voxels<PacketVoxels::u8>(job, rays, pixels);
    case PacketVoxels::two_bytes:
      return split_voxels<PacketVoxels::two_bytes>(job, rays, pixels);
    case PacketVoxels::f32:
      return split_voxels<PacketVoxels::f32>(job, rays, pixels);
  }
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::render {

HWY_EXPORT(split);

void cast_split(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  HWY_DYNAMIC_DISPATCH(split)(job, rays, pixels);
}

}  // namespace vol::render
#endif
