#include "render/packet_set_up.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/packet.h"
#include "render/shading.h"

namespace vol::render {
namespace {

using volume::VoxelType;

constexpr double kThreeNodesBelow =
    3e-3;  // below this error a rule of order 6 takes fewer pieces than one of order 4

/// Of max_error: for the pieces of a ray; for the light behind where it ends early, a sure bound; for what no
/// estimate sees. Where light comes from the side, its kinks can hide between the places that are looked at.
struct ErrorShares {
  double pieces = 0.375, termination = 0.625, unseen = 0;
};
ErrorShares error_shares(const Scene& scene) {
  return scene.shading && scene.shading->light ? ErrorShares{0.375, 0.325, 0.3} : ErrorShares{};
}

}  // namespace

bool are_read_as_they_are(VoxelType type) {
  return type == VoxelType::u8 || type == VoxelType::u16 || type == VoxelType::i16 || type == VoxelType::f32;
}

void set_volume(const volume::Volume& volume, PacketJob& job) {
  const Dims& dims = volume.geometry().dims;
  std::int32_t unit = 1;
  switch (volume.voxel_type()) {
    case VoxelType::u8:
      job.type = PacketVoxels::u8;
      break;
    case VoxelType::u16:
      job.type = PacketVoxels::two_bytes;
      unit = 2;
      break;
    case VoxelType::i16:
      job.type = PacketVoxels::two_bytes;
      unit = 2;
      break;
    default:
      job.type = PacketVoxels::f32;
      break;
  }
  job.is_signed = volume.voxel_type() == VoxelType::i16;
  job.voxels =
      volume::visit(volume, [](const auto& grid) { return static_cast<const void*>(grid.voxels.data()); });
  std::int64_t stride = unit;
  for (int a = 0; a < 3; ++a) {
    job.stride[a] = dims[a] > 1 ? static_cast<std::int32_t>(stride) : 0;
    job.neighbour[a] = job.stride[a];
    job.last_cell[a] = static_cast<std::int32_t>(std::max<std::int64_t>(0, dims[a] - 2));
    stride *= dims[a];
  }
}

void set_shading(const volume::GridGeometry& geometry, const Shading& shading, PacketJob& job) {
  (void)BlinnPhong(shading);  // its checks
  job.shaded = true;
  const Mat3 to_world = geometry.world_to_index_matrix().transpose();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      job.to_world[3 * r + c] = geometry.dims[c] > 1 ? static_cast<float>(to_world(r, c)) : 0.0F;
    }
  }
  job.ambient = static_cast<float>(shading.ambient);
  job.diffuse = static_cast<float>(shading.diffuse);
  job.specular = static_cast<float>(shading.specular);
  job.exponent = static_cast<float>(shading.exponent);
  job.headlight = !shading.light;
  if (shading.light) {
    const Vec3 light = shading.light->stableNormalized();
    for (int a = 0; a < 3; ++a) job.light[a] = static_cast<float>(light[a]);
  }
}

double brightest(const Scene& scene) {
  double most = 0;
  for (const auto& p : scene.transfer.colours()) most = std::max(most, p.rgb.maxCoeff());
  if (scene.shading) most = BlinnPhong(*scene.shading).brightest()(Vec3::Constant(most)).maxCoeff();
  return std::max({1.0, most, scene.background.maxCoeff()});
}

double shortest_piece(const PacketTransfer& transfer) {
  double least = std::numeric_limits<double>::infinity();
  for (const float clarity : transfer.clarity) {
    if (clarity > 0) least = std::min(least, double(clarity));
  }
  return least;
}

void set_budget(const Scene& scene, const RenderOptions& options, PacketJob& job) {
  const double bright = brightest(scene);
  const ErrorShares shares = error_shares(scene);
  job.nodes = options.max_error < kThreeNodesBelow ? 3 : 2;
  job.budget = static_cast<float>(shares.pieces * options.max_error - kPacketRounding * bright);
  job.termination =
      static_cast<float>(std::max(options.termination, shares.termination * options.max_error / bright));
  const bool one_channel = job.transfer.affine && !job.shaded;
  double offset = 0, slope = 0;
  for (int c = 0; c < 3; ++c) {
    offset = std::max(offset, double(std::abs(job.transfer.colour0[c])));
    slope = std::max(slope, double(std::abs(job.transfer.colour1[c])));
  }
  // The difference of two rules is the error of the lower order. The higher one's is a small part of it where
  // all is smooth, but as large at a kink, of which lighting has some inside pieces.
  const double share = scene.shading ? 1 : 0.25;
  job.error_emitted = static_cast<float>(share * (one_channel ? slope : 1));
  job.error_alpha = static_cast<float>(share * (one_channel ? bright + offset : bright));
  job.error_unseen = static_cast<float>(bright);
  if (scene.shading) {
    double colour = 0;
    for (const auto& p : scene.transfer.colours()) colour = std::max(colour, p.rgb.maxCoeff());
    job.error_light = static_cast<float>(0.5 * (scene.shading->diffuse * colour + scene.shading->specular));
    // A highlight is as narrow as its exponent makes it: cos^m falls to e^-1/8 at this cosine.
    job.steady = static_cast<float>(1 - 0.125 / std::max(1.0, scene.shading->exponent));
  }
  job.unseen = static_cast<float>(kPacketRounding * bright + (shares.unseen) * options.max_error);
}

void set_index(const index::IndexVolume& index, PacketJob& job) {
  job.nibbles = index.nibbles().data();
  int level = 0;
  for (const std::uint8_t byte : index.nibbles()) level = std::max({level, byte & 15, byte >> 4});
  job.longest_hop = static_cast<float>(1 << level);
  job.row_bytes = static_cast<std::int32_t>(index.row_bytes());
  job.slice_bytes = static_cast<std::int32_t>(index.row_bytes() * index.dims()[1]);
  job.reduction = index.reduction();
  job.inverse_reduction = 1.0F / static_cast<float>(index.reduction());
}

}  // namespace vol::render
