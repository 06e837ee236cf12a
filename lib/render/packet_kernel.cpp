// The packet kernels, compiled once for each instruction set and chosen when the program runs.
#include "render/packet_job.h"
// The targets come before Highway:
#include "render/packet_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/packet_kernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file again:
#include <hwy/highway.h>

#include "render/packet_composite-inl.h"
#include "render/packet_preintegrated-inl.h"
#include "render/packet_project-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

int lanes() {
  return static_cast<int>(hn::Lanes(DF()));
}
const char* target_name() {
  return hwy::TargetName(HWY_TARGET);
}

template <PacketVoxels kVoxels, bool kTrapezoid>
void composite_channels(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  if (job.transfer.affine && !job.shaded) {
    Composite<kVoxels, kTrapezoid, 1>(job, rays).cast(pixels);
  } else {
    Composite<kVoxels, kTrapezoid, 3>(job, rays).cast(pixels);
  }
}

template <PacketVoxels kVoxels>
void preintegrated_channels(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  if (job.transfer.affine && !job.shaded) {
    Preintegrated<kVoxels, 1>(job, rays).cast(pixels);
  } else {
    Preintegrated<kVoxels, 3>(job, rays).cast(pixels);
  }
}

template <PacketVoxels kVoxels>
void composite_voxels(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  switch (job.rule) {
    case PacketRule::rectangle:
      return composite_channels<kVoxels, false>(job, rays, pixels);
    case PacketRule::trapezoid:
      return composite_channels<kVoxels, true>(job, rays, pixels);
    case PacketRule::preintegrated:
      return preintegrated_channels<kVoxels>(job, rays, pixels);
    case PacketRule::split:
      return;  // packet_split_kernel.cpp
  }
}

void composite(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  switch (job.type) {
    case PacketVoxels::u8:
      return composite_voxels<PacketVoxels::u8>(job, rays, pixels);
    case PacketVoxels::two_bytes:
      return composite_voxels<PacketVoxels::two_bytes>(job, rays, pixels);
    case PacketVoxels::f32:
      return composite_voxels<PacketVoxels::f32>(job, rays, pixels);
  }
}

template <PacketVoxels kVoxels>
void xray_voxels(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  job.rule == PacketRule::rectangle ? xray<kVoxels, false>(job, rays, pixels)
                                    : xray<kVoxels, true>(job, rays, pixels);
}

void xray_any(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  switch (job.type) {
    case PacketVoxels::u8:
      return xray_voxels<PacketVoxels::u8>(job, rays, pixels);
    case PacketVoxels::two_bytes:
      return xray_voxels<PacketVoxels::two_bytes>(job, rays, pixels);
    case PacketVoxels::f32:
      return xray_voxels<PacketVoxels::f32>(job, rays, pixels);
  }
}

void mip_any(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  switch (job.type) {
    case PacketVoxels::u8:
      return mip<PacketVoxels::u8>(job, rays, pixels);
    case PacketVoxels::two_bytes:
      return mip<PacketVoxels::two_bytes>(job, rays, pixels);
    case PacketVoxels::f32:
      return mip<PacketVoxels::f32>(job, rays, pixels);
  }
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::render {

HWY_EXPORT(lanes);
HWY_EXPORT(target_name);
HWY_EXPORT(composite);
HWY_EXPORT(xray_any);
HWY_EXPORT(mip_any);

int packet_lanes() {
  return HWY_DYNAMIC_DISPATCH(lanes)();
}
std::int64_t packet_targets() {
  return HWY_TARGETS;
}
const char* packet_instruction_set() {
  return HWY_DYNAMIC_DISPATCH(target_name)();
}
void cast_composite(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  HWY_DYNAMIC_DISPATCH(composite)(job, rays, pixels);
}
void cast_xray(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  HWY_DYNAMIC_DISPATCH(xray_any)(job, rays, pixels);
}
void cast_mip(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels) {
  HWY_DYNAMIC_DISPATCH(mip_any)(job, rays, pixels);
}

}  // namespace vol::render
#endif
