#pragma once
#include "index/index_volume.h"
#include "render/options.h"
#include "render/packet_job.h"
#include "volume/volume.h"

// The parts of a packet job, from what the caller gave: once a picture.
namespace vol::render {

/// Whether packets read voxels of a type as they are: u8, u16, i16, f32.
[[nodiscard]] bool are_read_as_they_are(volume::VoxelType type);

/// Voxels and strides; the volume must be of a type that packets read, and live longer.
void set_volume(const volume::Volume& volume, PacketJob& job);

/// \throws vol::Error as BlinnPhong does
void set_shading(const volume::GridGeometry& geometry, const Shading& shading, PacketJob& job);

/// Entries of the index, which must outlive the job
void set_index(const index::IndexVolume& index, PacketJob& job);

/// Adaptive pieces: what a ray may err by in all (options.max_error) is shared between them and the light
/// behind where it ends early. Needs the job's transfer function and shading.
void set_budget(const Scene& scene, const RenderOptions& options, PacketJob& job);

/// Largest component of any colour once it is lit, of the background, and of alpha.
[[nodiscard]] double brightest(const Scene& scene);

/// Length of the shortest piece that light may need, in steps; opaque stretches are none.
[[nodiscard]] double shortest_piece(const PacketTransfer& transfer);

}  // namespace vol::render
