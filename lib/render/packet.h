#pragma once
#include "index/index_volume.h"
#include "index/macrocells.h"
#include "render/raycast.h"

namespace vol::render {

/// The fast ray caster: packets of rays in SIMD (AVX-512, AVX2, SSE4 or one lane, chosen when it runs), float
/// arithmetic, threads over tiles of the image. Same semantics as its oracle, raycast_plain: same nodes, same
/// rules, same channels.
///
/// What holds exactly:
///  - the picture and the counts do not depend on the number of threads, nor the counts on the instruction
///  set
///    (but for rounding at a border of visibility or at `termination`);
///  - skip_empty changes no bit of the picture: only segments that add exactly zero are dropped;
///  - an index of zeros gives the uniform picture bit for bit. Both hold because the position of node i is
///  one
///    fixed-point number, entry + i times the step, 31 binary digits behind the point, however i was reached.
///
/// What holds within a bound, for n nodes a ray: colour and alpha differ from the oracle's, and from one
/// instruction set to another, by at most 2e-6 + 1e-8 n times the largest colour where opacity and colour are
/// continuous functions of the value (kPacketTolerance, tested). Positions lag by at most n 2^-31 voxel. At a
/// jump of the transfer function, a kink of the gradient or a cell border of nearest, a node within rounding
/// of it may fall on the other side, and one sample's contribution with it. xray: relative to max |f| times
/// length.
///
/// Voxels of type u8, u16, i16 and f32 are read as they are; other types are converted to f32, once. What the
/// packets do not cover is passed to raycast_plain: Catmull-Rom and B-spline reconstruction, preintegrated
/// compositing, more than 32767 nodes on a ray, volumes of 2^31 samples (f32) or bytes or more, transfer
/// functions with more than one point in 1/65536 of the data's range.
///
/// \param macrocells  of this volume, if the caller keeps them; else computed here (composite only)
/// \throws vol::Error as raycast_plain does
[[nodiscard]] RenderResult raycast_packet(const volume::Volume& volume, const Scene& scene,
                                          const RenderOptions& options,
                                          const index::IndexVolume* index = nullptr,
                                          const index::Macrocells* macrocells = nullptr);

/// Bound of the difference from the oracle for n nodes a ray, on the colour scale (colours up to 1).
[[nodiscard]] constexpr double packet_tolerance(double nodes) {
  return 2e-6 + 1e-8 * nodes;
}

/// Name of the instruction set that raycast_packet uses here: AVX3, AVX2, SSE4, SCALAR ...
[[nodiscard]] const char* packet_instruction_set();

}  // namespace vol::render
