#pragma once
#include "camera/camera.h"
#include "index/index_volume.h"
#include "render/packet_job.h"
#include "render/ray_box.h"
#include "volume/grid_geometry.h"

namespace vol::render {

/// Most segments on a ray that a packet can hold: counts of nodes fit 15 bits.
inline constexpr int kMostSegments = 32767;

/// Makes the rays of packets: the oracle's nodes in fixed-point index coordinates.
///
/// The entry is rounded down and kept below the last sample, the step is rounded towards 0: a node lags
/// behind its exact place by at most (number + 1) 2^-31 voxel and never leaves the box, so that sampling
/// needs no clamping.
class PacketRayMaker {
 public:
  PacketRayMaker(const volume::GridGeometry& geometry, const RayBox& box, const camera::Camera& camera,
                 double step, const index::IndexVolume* index);

  /// Where a ray's lane meets the box, for the depth channel.
  struct Lane {
    bool hit = false;
    Chord chord{0, 0};
  };

  /// The ray through the centre of pixel (x, y), as lane `lane`.
  Lane make(int x, int y, int lane, PacketRays& rays) const;
  /// A lane without a ray.
  static void clear(int lane, PacketRays& rays);

 private:
  [[nodiscard]] int first_level(const Vec3& p_world) const;

  const RayBox& box_;
  const camera::Camera& camera_;
  double step_;
  const index::IndexVolume* index_;
  Dims dims_;
  Mat3 to_index_;
  Vec3 origin_;
};

}  // namespace vol::render
