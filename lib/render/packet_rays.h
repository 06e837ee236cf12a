#pragma once
#include <span>

#include "camera/camera.h"
#include "index/index_volume.h"
#include "render/packet_job.h"
#include "render/ray_box.h"
#include "render/refinement.h"
#include "volume/grid_geometry.h"

namespace vol::render {

/// Most segments on a ray that a packet can hold: counts of nodes fit 15 bits.
inline constexpr int kMostSegments = 32767;

/// Positions are counted in 1 / kOne voxel, steps go up to kFar, which no ray takes.
inline constexpr double kOne = 2147483648.0;  // 2^31
inline constexpr double kFar = kOne * kOne / 2;

/// Where the rays of a packet meet the box, by lane, for the depth channel.
struct PacketChords {
  alignas(64) double entry[kMaxLanes];
  alignas(64) double exit[kMaxLanes];
};

/// Camera, box and grid as plain numbers. Matrices by rows.
struct PacketView {
  bool perspective = false;
  double eye[3]{}, right[3]{}, up[3]{}, direction[3]{};
  double width = 0, distance = 0, t_min = 0;
  double image_width = 0, image_height = 0;
  double corner[3]{}, to_box[9]{};
  double origin[3]{}, to_index[9]{};
  double last[3]{};  ///< number of the last sample per axis
  double step = 0;
};

/// Makes the rays of packets: the oracle's nodes in fixed-point index coordinates.
///
/// The entry is rounded down and kept below the last sample, the step is rounded towards 0: a node lags
/// behind its exact place by at most (number + 1) 2^-31 voxel and never leaves the box, so that sampling
/// needs no clamping.
class PacketRayMaker {
 public:
  PacketRayMaker(const volume::GridGeometry& geometry, const RayBox& box, const camera::Camera& camera,
                 double step, const index::IndexVolume* index);

  /// Rays through the centres of 1 to packet_lanes() pixels, lane by lane; the other lanes, and those that
  /// miss the box, have no segments.
  void make(std::span<const PixelPosition> pixels, PacketRays& rays, PacketChords& chords) const;
  /// The same one after the other: what make() is checked against, and used for axes too long for it.
  void make_plain(std::span<const PixelPosition> pixels, PacketRays& rays, PacketChords& chords) const;

 private:
  [[nodiscard]] int first_level(const Vec3& p_world) const;
  void make_plain(const PixelPosition& pixel, int lane, PacketRays& rays, PacketChords& chords) const;

  const RayBox& box_;
  const camera::Camera& camera_;
  double step_;
  const index::IndexVolume* index_;
  Dims dims_;
  Mat3 to_index_;
  Vec3 origin_;
  PacketView view_;
  bool short_axes_;
};

/// The kernel of PacketRayMaker::make(): as many rays as a packet has lanes, through the centres of pixels
/// (x, y). Axes have at most 2^21 samples, so that doubles hold all sums exactly.
void make_rays(const PacketView& view, const std::int32_t* x, const std::int32_t* y, PacketRays& rays,
               PacketChords& chords);

}  // namespace vol::render
