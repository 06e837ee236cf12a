#include "render/packet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "render/packet_rays.h"
#include "render/packet_set_up.h"
#include "render/packet_transfer.h"
#include "render/picture.h"
#include "render/refinement.h"
#include "render/shading.h"
#include "render/visibility.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

using volume::VoxelType;

constexpr double kMostPieces = 64;
constexpr double kLeastPiece = 1.0 / 1024;  // of the longest way through a cell
constexpr double kTouching = index::Macrocells::kEdge;

bool is_native(VoxelType type) {
  return type == VoxelType::u8 || type == VoxelType::u16 || type == VoxelType::i16 || type == VoxelType::f32;
}

bool is_covered(const volume::Volume& volume, const Scene& scene, const RenderOptions& options) {
  using volume::Reconstruction;
  if (options.quadrature == Quadrature::reference) return false;
  // Below this, rounding would take most of what errors are allowed.
  if (options.max_error > 0 && options.max_error < 4 * kPacketRounding * brightest(scene)) return false;
  if (options.reconstruction != Reconstruction::nearest &&
      options.reconstruction != Reconstruction::trilinear) {
    return false;
  }
  if (options.quadrature == Quadrature::split) {
    // An axis of one sample has no cells to go through.
    const Dims& dims = volume.geometry().dims;
    const bool flat = std::any_of(dims.begin(), dims.end(), [](std::int64_t n) { return n == 1; });
    if (flat || scene.model != Model::composite || options.reconstruction == Reconstruction::nearest)
      return false;
  }
  const volume::FieldBounds bounds = volume::field_bounds(volume.geometry());
  double diagonal = 0;  // of the box, at most
  for (int a = 0; a < 3; ++a) diagonal += bounds.edges.col(a).norm();
  if (!(diagonal / options.step < kMostSegments - 1)) return false;
  constexpr double kAddressable = 2147483647.0;
  const auto count = static_cast<double>(volume.geometry().count());
  switch (volume.voxel_type()) {
    case VoxelType::u8:
      return count < kAddressable;
    case VoxelType::u16:
    case VoxelType::i16:
      return 2 * count < kAddressable;
    default:
      return count < kAddressable;
  }
}

struct Picture {
  const PacketJob& job;
  const PacketRayMaker& maker;
  const Scene& scene;
  const RenderOptions& options;
  image::Image& image;
};

void add_counts(RenderCounts& sum, const RenderCounts& counts) {
  sum += counts;
}

/// One packet: a ray for each of at most packet_lanes() pixels.
void cast_packet(const Picture& picture, std::span<const PixelPosition> positions, PacketRays& rays,
                 PacketPixels& pixels, RenderCounts& counts) {
  PacketRayMaker::Lane lanes[kMaxLanes];
  const int count = static_cast<int>(positions.size());
  bool any = false;
  for (int lane = 0; lane < packet_lanes(); ++lane) {
    lanes[lane] = {};
    if (lane < count) {
      const PixelPosition& p = positions[static_cast<std::size_t>(lane)];
      lanes[lane] = picture.maker.make(p.x, p.y, lane, rays);
    } else {
      PacketRayMaker::clear(lane, rays);
    }
    any = any || lanes[lane].hit;
  }
  if (!any) return;
  const Model model = picture.scene.model;
  const auto split = picture.job.budget > 0 ? cast_adaptive : cast_split;
  const auto composite = picture.job.rule == PacketRule::split ? split : cast_composite;
  const auto cast = model == Model::composite ? composite : model == Model::xray ? cast_xray : cast_mip;
  cast(picture.job, rays, pixels);
  const double scale = model == Model::xray ? picture.options.step : 1;
  for (int lane = 0; lane < count; ++lane) {
    if (!lanes[lane].hit) continue;
    const auto [x, y] = positions[static_cast<std::size_t>(lane)];
    for (int c = 0; c < 3; ++c) {
      const auto colour = static_cast<float>(double(pixels.colour[c][lane]) * scale);
      if (!std::isfinite(colour)) {
        throw Error("a pixel reaches a value that float cannot hold; scale the volume");
      }
      picture.image.at(x, y, c) = colour;
    }
    picture.image.at(x, y, 3) = pixels.alpha[lane];
    picture.image.at(x, y, 4) = static_cast<float>(pixels.samples[lane]);
    const Chord& chord = lanes[lane].chord;
    if (picture.options.max_error > 0) {
      picture.image.at(x, y, kErrorChannel) = pixels.error[lane] + picture.job.unseen;
    }
    if (pixels.depth_node[lane] >= 0) {
      const double t =
          chord.entry + (pixels.depth_node[lane] + double(pixels.depth_part[lane])) * picture.options.step;
      picture.image.at(x, y, 5) = static_cast<float>(std::min(t, chord.exit));
    }
    ++counts.rays;
    counts.samples += pixels.samples[lane];
    counts.gradients += pixels.gradients[lane];
    counts.skipped += pixels.skipped[lane];
    counts.terminated += pixels.terminated[lane];
  }
}

/// Tiles of 32 x 32 pixels, one task each; packets of nearly square footprint, so that rays share cache
/// lines.
RenderCounts cast_tiles(const Picture& picture) {
  constexpr int kTile = 32;
  const int lanes = packet_lanes();
  const int w = lanes >= 8 ? 4 : lanes >= 4 ? 2 : 1, h = lanes / w;
  const int across = (picture.options.width + kTile - 1) / kTile,
            down = (picture.options.height + kTile - 1) / kTile;
  const auto tile = [&](std::int64_t first, std::int64_t) {
    RenderCounts counts;
    PacketRays rays{};
    PacketPixels pixels{};
    const int left = static_cast<int>(first) % across * kTile, top = static_cast<int>(first) / across * kTile;
    const int right = std::min(left + kTile, picture.options.width);
    const int bottom = std::min(top + kTile, picture.options.height);
    PixelPosition positions[kMaxLanes];
    for (int y = top; y < bottom; y += h) {
      for (int x = left; x < right; x += w) {
        std::size_t count = 0;
        for (int j = y; j < std::min(y + h, bottom); ++j) {
          for (int i = x; i < std::min(x + w, right); ++i) positions[count++] = {i, j};
        }
        cast_packet(picture, {positions, count}, rays, pixels, counts);
      }
    }
    return counts;
  };
  return parallel_reduce<RenderCounts>(0, std::int64_t{across} * down, 1, tile, add_counts);
}

/// Pixels of a list, in its order.
RenderCounts cast_list(const Picture& picture, std::span<const PixelPosition> positions) {
  const auto lanes = static_cast<std::size_t>(packet_lanes());
  const auto packets = static_cast<std::int64_t>((positions.size() + lanes - 1) / lanes);
  const auto some = [&](std::int64_t begin, std::int64_t end) {
    RenderCounts counts;
    PacketRays rays{};
    PacketPixels pixels{};
    for (std::int64_t p = begin; p < end; ++p) {
      const std::size_t first = static_cast<std::size_t>(p) * lanes;
      cast_packet(picture, positions.subspan(first, std::min(lanes, positions.size() - first)), rays, pixels,
                  counts);
    }
    return counts;
  };
  return parallel_reduce<RenderCounts>(0, packets, 16, some, add_counts);
}

RenderCounts cast_picture(const Picture& picture) {
  if (picture.options.image_step == 1) return cast_tiles(picture);
  RenderCounts counts;
  cast_refined(picture.image, picture.options.image_step, picture.options.image_tolerance,
               [&](std::span<const PixelPosition> positions) { counts += cast_list(picture, positions); });
  return counts;
}

/// What the packets' tables do not hold.
RenderResult otherwise(const volume::Volume& volume, const Scene& scene, RenderOptions options,
                       const index::IndexVolume* index) {
  if (options.max_error > 0) {
    options.tolerance = kReferenceShare * options.max_error;
    return raycast_reference(volume, scene, options);
  }
  return options.quadrature == Quadrature::split ? raycast_split_plain(volume, scene, options)
                                                 : raycast_plain(volume, scene, options, index);
}

/// `options`, with the step that the packets take: split goes from cell to cell and measures lengths in
/// voxels.
RenderOptions packet_steps(RenderOptions options, const volume::GridGeometry& geometry) {
  if (options.quadrature == Quadrature::split) options.step = geometry.spacing.minCoeff();
  return options;
}

RenderResult cast_covered(const PacketVolume& prepared, const Scene& scene, const RenderOptions& options,
                          const index::IndexVolume* index) {
  const volume::Volume& volume = prepared.native();
  const volume::GridGeometry& geometry = volume.geometry();
  if (index && index->volume_dims() != geometry.dims) {
    throw Error("index volume was built for other dims than the volume's");
  }

  PacketJob job;
  set_volume(volume, job);
  job.nearest = options.reconstruction == volume::Reconstruction::nearest;
  job.rule = options.quadrature == Quadrature::rectangle   ? PacketRule::rectangle
             : options.quadrature == Quadrature::trapezoid ? PacketRule::trapezoid
             : options.quadrature == Quadrature::split     ? PacketRule::split
                                                           : PacketRule::preintegrated;
  job.nodes = options.nodes;
  job.termination = static_cast<float>(options.termination);
  Buffer<std::uint8_t> nibbles;
  if (index) nibbles = set_index(*index, job);
  Visibility visible;
  if (scene.model == Model::composite) {
    const index::Macrocells& macrocells = prepared.macrocells();
    const double reference_length = resolved_reference_length(scene, geometry.spacing.minCoeff());
    const bool integral = job.type != PacketVoxels::f32;
    if (!tabulate(Optics(scene.transfer, reference_length), macrocells.all, integral,
                  options.step / reference_length, job.rule, job.transfer)) {
      return otherwise(prepared.original(), scene, options, index);
    }
    // A piece halves the light at most: so many are the pieces of a segment.
    const auto longest = double(job.longest_hop);
    if (job.rule == PacketRule::preintegrated && job.transfer.steepest * longest < -kMostPieces) {
      return otherwise(prepared.original(), scene, options, index);
    }
    // A piece halves the light at most: where that takes less than a small part of a cell, the rays do not
    // get on.
    if (job.rule == PacketRule::split &&
        shortest_piece(job.transfer) < kLeastPiece * geometry.spacing.norm() / options.step) {
      return otherwise(prepared.original(), scene, options, index);
    }
    if (scene.shading) set_shading(geometry, *scene.shading, job);
    if (options.max_error > 0) set_budget(scene, options, job);
    // Preintegrated segments are left out between macrocells that touch: no step may pass over one.
    const bool touching =
        job.rule != PacketRule::preintegrated || options.step <= kTouching * geometry.spacing.minCoeff();
    if (!touching && index && options.skip_empty)
      return otherwise(prepared.original(), scene, options, index);
    if (options.skip_empty && touching) visible = visibility(macrocells, scene.transfer);
    if (!visible.all_visible) job.distances = visible.distance.data();
    job.macro_stride[1] = static_cast<std::int32_t>(macrocells.dims[0]);
    job.macro_stride[2] = static_cast<std::int32_t>(macrocells.dims[0] * macrocells.dims[1]);
  }

  const volume::FieldBounds bounds = volume::field_bounds(geometry);
  const RayBox box(bounds);
  const camera::Camera camera(scene.view, bounds.centre(), bounds.longest_edge(), options.width,
                              options.height);
  const PacketRayMaker maker(geometry, box, camera, options.step, index);
  RenderResult result{blank_image(options), {}, std::numeric_limits<double>::quiet_NaN(), "packets"};
  result.counts = cast_picture({job, maker, scene, options, result.image});
  return result;
}

}  // namespace

PacketVolume::PacketVolume(const volume::Volume& volume, bool macrocells) : volume_(volume) {
  const bool native = is_native(volume.voxel_type());
  const bool floating = volume::is_floating_point(volume.voxel_type());
  if (!native || floating) {  // small integers hold neither NaN nor infinity, and float holds them
    const volume::Range range = volume::value_range(volume);
    const double magnitude = std::max(std::abs(range.min), std::abs(range.max));
    // Sums of differences of values must stay within float, and float must hold what differs: it loses 6e-8.
    const bool exact = native || (!floating && magnitude <= 16777216);
    fits_ = magnitude < double(std::numeric_limits<float>::max()) / 64 &&
            (exact || magnitude * 6e-8 <= 1e-6 * (range.max - range.min));
    if (!fits_) return;
  }
  if (!native) converted_.emplace(volume::Volume{volume::converted<float>(volume), {}});
  if (macrocells) macrocells_.emplace(index::macrocells(this->native()));
}

const index::Macrocells& PacketVolume::macrocells() const {
  if (!macrocells_) throw Error("a composite picture needs the volume's macrocells");
  return *macrocells_;
}

RenderResult raycast_packet(const PacketVolume& volume, const Scene& scene, const RenderOptions& options,
                            const index::IndexVolume* index) {
  require_valid(options);
  if (index && options.quadrature == Quadrature::split) {
    throw Error("quadrature split goes from cell to cell and takes no index");
  }
  const RenderOptions stepped = packet_steps(options, volume.original().geometry());
  if (!volume.fits() || !is_covered(volume.original(), scene, stepped))
    return otherwise(volume.original(), scene, options, index);
  return cast_covered(volume, scene, stepped, index);
}

RenderResult raycast_packet(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                            const index::IndexVolume* index) {
  return raycast_packet(PacketVolume(volume, scene.model == Model::composite), scene, options, index);
}

}  // namespace vol::render
