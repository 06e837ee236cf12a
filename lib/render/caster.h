#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "render/packet.h"
#include "render/surfaces.h"

namespace vol::render {

/// What is in a picture besides the volume and the scene, and by what it may be cast. All of it must live
/// longer than whoever casts.
struct CasterOptions {
  bool packets = true;  ///< cast by packets where these do what is asked; else the plain caster, their oracle
  const index::IndexVolume* index = nullptr;
  const Surfaces* surfaces = nullptr;
  const LabelledMedium* labels = nullptr;
};

/// Pictures of a volume by whichever caster does what is asked, prepared once: surfaces and labels by the
/// plain one, quadrature `reference` by its own, all else by packets unless these are not wanted. Refers to
/// the volume, which must live longer.
class Caster {
 public:
  /// \throws vol::Error as the caster chosen does
  Caster(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
         const CasterOptions& caster);
  Caster(const Caster&) = delete;
  Caster& operator=(const Caster&) = delete;

  /// Lays the voxels out in blocks (voxel_blocks.h), from which frames of volumes larger than the caches take
  /// less time: the pictures stay the same. Where packets do not draw, keep a bound on the error, or cannot have blocks (fits_blocks), nothing happens.
  /// \param volume  the one that the pictures are of; it is left with its geometry alone: no other caster may draw it any more
  /// \return whether the pictures are drawn from blocks now
  bool lay_out_in_blocks(volume::Volume& volume);

  /// \param spare  an image whose memory the picture may take, such as the last frame's
  [[nodiscard]] RenderResult cast(image::Image spare = {}) const;

 private:
  const volume::Volume& volume_;
  Scene scene_;
  RenderOptions options_;
  CasterOptions caster_;
  std::optional<PacketVolume> packet_volume_;
  std::optional<PacketScene> packet_scene_;
  std::optional<VoxelBlocks> blocks_;
};

/// The pictures of one caster a channel as one: an X-ray of red, green and blue weights, or of one for all
/// three. Its counts and `samples` are their sums, its estimate of the error the largest.
[[nodiscard]] RenderResult cast_channels(const std::vector<std::unique_ptr<const Caster>>& channels);

}  // namespace vol::render
