#pragma once
#include "image/image.h"
#include "render/options.h"
#include "render/packet_rays.h"
#include "render/visibility.h"

// Private to the packet caster: a job's rays, over the pixels of a picture.
namespace vol::render {

struct PacketPicture {
  const PacketJob& job;
  const Visibility* visible;     ///< null: all macrocells are
  const VisibilityAhead* ahead;  ///< of `visible`
  const PacketRayMaker& maker;
  const Scene& scene;
  const RenderOptions& options;
  image::Image& image;
};

/// Fills the picture's pixels, in tiles over threads, or those that refinement asks for; counts are folded in
/// a fixed order. Throws vol::Error where float cannot hold a pixel.
[[nodiscard]] RenderCounts cast_picture(const PacketPicture& picture);

}  // namespace vol::render
