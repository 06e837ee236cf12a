#pragma once
#include <cstdint>

#include "base/buffer.h"
#include "index/macrocells.h"
#include "render/extinction_pieces.h"
#include "render/voxel_blocks.h"
#include "volume/voxel_type.h"

namespace vol::render {

/// What the packet kernel works on: plain numbers, computed once a scene. Private to the packet caster.
inline constexpr int kMaxLanes = 16;

/// The transfer function on a table over the data's range: u = (value - lo) scale in [0, buckets). Bucket b
/// has two lines in w = u - b: line b, and line b + buckets for values at or above the bucket's split point.
struct PacketTransfer {
  float lo = 0, hi = 0;  ///< of the data
  float scale = 0;
  float last = 0;  ///< largest u that still floors to a bucket
  std::int32_t buckets = 0;
  bool split = false;      ///< some bucket has a transfer-function point inside
  bool logarithm = false;  ///< lines hold opacities, to be turned into extinctions
  bool affine = false;     ///< colour is one line in u over the whole range
  bool grey = false;       ///< its three channels are the same
  bool opaque = false;     ///< opacity 1 occurs
  bool dense = false;      ///< opacities above 0.9 occur
  float exponent =
      0;  ///< y of a whole step per log2(1 - opacity): step / reference length (half of it: trapezoid)
  float steepest = 0;    ///< smallest y of a whole segment (most negative)
  float densest = 0;     ///< preintegrated and split: no node's y is below (opacity 1 apart)
  Buffer<float> splits;  ///< value, +infinity where none; by bucket
  /// By line. {y, dy}: log2 of a node's share of a step's transmittance; or, with `logarithm`, {opacity,
  /// slope, 1 - opacity, slope}.
  Buffer<float> extinctions;
  Buffer<float> colours;  ///< by line: r, dr, g, dg, b, db; empty when affine
  // Extinction of few pieces, as tables that fit into registers: piece k begins at the value ramp_from[k] and
  // has y = ramp[0][k] + ramp[1][k] x + ..., x = (value - ramp_origin[k]) ramp_scale (extinction_pieces.h).
  int ramps = 0;         ///< 0: more than kMaxLanes, or not to be had
  float ramp_scale = 0;  ///< 1 / (hi - lo)
  alignas(64) float ramp_from[kMaxLanes]{};
  alignas(64) float ramp_origin[kMaxLanes]{}, ramp[ExtinctionPiece::kDegree + 1][kMaxLanes]{};
  // Colour of few pieces, the same: piece k begins at the value from[k] and has the colour
  // at[c][k] + slope[c][k] (value - from[k]).
  static constexpr int kFewPieces = 8;
  int pieces = 0;  ///< 0: more than kFewPieces, or one line in all (affine)
  alignas(64) float from[kMaxLanes]{};
  alignas(64) float at[3][kMaxLanes]{}, slope[3][kMaxLanes]{};
  float colour0[3]{}, colour1[3]{};  ///< affine: colour = colour0 + colour1 u
  // Preintegrated and split: the values at which a segment is cut; interval k lies between cuts k - 1 and k.
  Buffer<float> cuts;              ///< ascending, then +infinity
  Buffer<std::int32_t> first_cut;  ///< by bucket: an interval at or below that of the bucket's start
  // The same for few intervals, as tables that fit into registers: the cut beneath (-infinity where none),
  // the cut above, clarity.
  int intervals = 0;  ///< 0: more than kMaxLanes, or other rules
  alignas(64) float beneath[kMaxLanes]{};
  alignas(64) float above[kMaxLanes]{}, clear_for[kMaxLanes]{};
  Buffer<float> peaks;  ///< values at which the opacity touches 1 between lower ones
  Buffer<float>
      clarity;  ///< by interval: steps over which log2 T falls by at most 1; 1e30 where clear, 0 where opaque
};

enum class PacketVoxels { u8, two_bytes, f32 };
enum class PacketRule { rectangle, trapezoid, preintegrated, split };

struct PacketJob {
  // The volume. Strides in units of the gather: bytes for u8 and two_bytes, elements for f32; 0 for an axis
  // of one.
  const void* voxels = nullptr;
  PacketVoxels type = PacketVoxels::u8;
  bool is_signed = false;  ///< two_bytes: i16, else u16
  bool nearest = false;
  std::int32_t stride[3]{};     ///< between cells
  std::int32_t last_cell[3]{};  ///< number of the last cell per axis, 0 for an axis of one sample
  std::int32_t neighbour[3]{};  ///< to the cell's far corner: stride, or 0 for an axis of one sample
  bool in_blocks = false;       ///< voxels lie in blocks, not in rows: `stride` and `neighbour` do not count
  BlockStrides blocks;
  // The rule.
  PacketRule rule = PacketRule::rectangle;
  int nodes = 3;  ///< split: Gauss nodes a piece, 1 to 3
  float termination = 0;
  float step_tolerance = 0;  ///< trapezoid: of steps of adaptive length (step_control.h); 0: all the same
  int halvings = 0;          ///< of the longest of these, at most
  float shading_share = 0;   ///< times T |y|: g of the shortest step, in units of the tolerance
  // Split, adaptive: the error that a ray's pieces may make together (0: fixed pieces), and what errors of a
  // piece's emitted light and opacity count in a pixel.
  float budget = 0, error_emitted = 0, error_alpha = 0;
  float error_unseen = 0;  ///< what transmittance left over counts
  float error_light = 0;   ///< half of what a light's direction may change in a colour
  float steady = 1;        ///< least cosine between neighbouring normals that Gauss nodes see through
  float unseen = 0;        ///< error that no estimate sees: float arithmetic, at least
  PacketTransfer transfer;
  // Shading; `to_world` rows give the world gradient from the index gradient.
  bool shaded = false;
  float to_world[9]{};
  float ambient = 0, diffuse = 0, specular = 0, exponent = 0;
  bool headlight = true;
  float light[3]{};
  std::int32_t macro_stride[3]{};  ///< of the tables of distances to visible macrocells
  // The index: nibbles, padded.
  const std::uint8_t* nibbles = nullptr;
  std::int32_t row_bytes = 0, slice_bytes = 0;
  float inverse_reduction = 1;
  int reduction = 1;
  float longest_hop = 1;  ///< in steps: 2 to the index's highest level, or to `halvings`
};

/// Rays of one packet, by lane. Positions in index space are fixed-point: whole voxels and 31-bit fractions.
struct PacketRays {
  alignas(64) std::int32_t entry_whole[3][kMaxLanes];
  alignas(64) std::int32_t entry_part[3][kMaxLanes];
  alignas(64) std::int32_t exit_whole[3][kMaxLanes];
  alignas(64) std::int32_t exit_part[3][kMaxLanes];
  alignas(64) std::int32_t step_whole[3][kMaxLanes];
  alignas(64) std::int32_t step_part[3][kMaxLanes];
  alignas(64) std::int32_t segments[kMaxLanes];     ///< n: nodes 0 .. n; 0 for no ray
  alignas(64) float remainder[kMaxLanes];           ///< length of the last segment, in steps
  alignas(64) std::int32_t first_level[kMaxLanes];  ///< index entry of node 0
  alignas(64) float direction[3][kMaxLanes];        ///< world, for shading
  // Skipping: distances by macrocell (visibility.h) that hold for all of these rays. Null: all are visible.
  const std::uint8_t* distances = nullptr;
};

struct PacketPixels {
  alignas(64) float colour[3][kMaxLanes];
  alignas(64) float alpha[kMaxLanes];
  alignas(64) std::int32_t depth_node[kMaxLanes];  ///< -1: none
  alignas(64) float depth_part[kMaxLanes];         ///< steps behind that node
  alignas(64) std::int32_t samples[kMaxLanes];
  alignas(64) std::int32_t gradients[kMaxLanes];
  alignas(64) std::int32_t skipped[kMaxLanes];
  alignas(64) std::int32_t terminated[kMaxLanes];
  alignas(64) float error[kMaxLanes];  ///< estimate, split's alone
};

/// Lanes of a packet on this machine: 16, 8, 4 or 1.
[[nodiscard]] int packet_lanes();
[[nodiscard]] const char* packet_instruction_set();  // declared in packet.h too
/// The instruction sets that the kernels were compiled for, as Highway's bits.
[[nodiscard]] std::int64_t packet_targets();
void cast_composite(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels);
void cast_split(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels);
void cast_adaptive(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels);
void cast_steps(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels);
void cast_xray(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels);
void cast_mip(const PacketJob& job, const PacketRays& rays, PacketPixels& pixels);

}  // namespace vol::render
