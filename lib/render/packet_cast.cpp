#include "render/packet_cast.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/error.h"
#include "base/parallel.h"
#include "render/picture.h"

namespace vol::render {
namespace {

void add_counts(RenderCounts& sum, const RenderCounts& counts) {
  sum += counts;
}

/// What a thread casts its packets with.
struct Workplace {
  PacketRays rays{};
  PacketPixels pixels{};
  PacketChords chords{};
};

using Cast = void (*)(const PacketJob&, const PacketRays&, PacketPixels&);

Cast cast_of(const PacketPicture& picture) {
  switch (picture.scene.model) {
    case Model::xray:
      return cast_xray;
    case Model::mip:
      return cast_mip;
    default:
      break;
  }
  if (picture.job.step_tolerance > 0) return cast_steps;
  if (picture.job.rule != PacketRule::split) return cast_composite;
  return picture.job.budget > 0 ? cast_adaptive : cast_split;
}

void store_pixel(const PacketPicture& picture, const Workplace& at, int lane, const PixelPosition& pixel,
                 double scale) {
  image::Image& image = picture.image;
  float* const to =
      image.pixels.data() + (static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(image.width) +
                             static_cast<std::size_t>(pixel.x)) *
                                image.channels.size();
  const PacketPixels& from = at.pixels;
  for (int c = 0; c < 3; ++c) {
    const auto colour = static_cast<float>(double(from.colour[c][lane]) * scale);
    if (!std::isfinite(colour)) {
      throw Error("a pixel reaches a value that float cannot hold; scale the volume");
    }
    to[c] = colour;
  }
  to[3] = from.alpha[lane];
  to[4] = static_cast<float>(from.samples[lane]);
  if (picture.options.max_error > 0) to[kErrorChannel] = from.error[lane] + picture.job.unseen;
  if (from.depth_node[lane] >= 0) {
    const double t = at.chords.entry[lane] +
                     (from.depth_node[lane] + double(from.depth_part[lane])) * picture.options.step;
    to[5] = static_cast<float>(std::min(t, at.chords.exit[lane]));
  }
}

/// Distances to what is visible that hold for a packet's rays: of their octant, or of all where they go to
/// several.
const std::uint8_t* distances_of(const PacketPicture& picture, const PacketRays& rays, int count) {
  if (picture.visible == nullptr) return nullptr;
  int octant = 0;
  for (int a = 0; a < 3; ++a) {
    bool up = false, down = false;
    for (int lane = 0; lane < count; ++lane) {
      up |= (rays.step_whole[a][lane] | rays.step_part[a][lane]) > 0;
      down |= rays.step_whole[a][lane] < 0;
    }
    if (up && down) return picture.visible->distance.data();
    octant |= int{down} << a;
  }
  return picture.ahead->distance(octant).data();
}

/// One packet: a ray for each of at most packet_lanes() pixels.
void cast_packet(const PacketPicture& picture, Cast cast, std::span<const PixelPosition> positions,
                 Workplace& at, RenderCounts& counts) {
  picture.maker.make(positions, at.rays, at.chords);
  const int count = static_cast<int>(positions.size());
  const std::int32_t* const segments = at.rays.segments;
  if (std::none_of(segments, segments + count, [](std::int32_t n) { return n > 0; })) return;
  at.rays.distances = distances_of(picture, at.rays, count);
  cast(picture.job, at.rays, at.pixels);
  const double scale = picture.scene.model == Model::xray ? picture.options.step : 1;
  for (int lane = 0; lane < count; ++lane) {
    if (segments[lane] == 0) continue;
    store_pixel(picture, at, lane, positions[static_cast<std::size_t>(lane)], scale);
    ++counts.rays;
    counts.samples += at.pixels.samples[lane];
    counts.gradients += at.pixels.gradients[lane];
    counts.skipped += at.pixels.skipped[lane];
    counts.terminated += at.pixels.terminated[lane];
  }
}

/// Tiles of 32 x 32 pixels, one task each; packets of nearly square footprint, so that rays share cache
/// lines.
RenderCounts cast_tiles(const PacketPicture& picture) {
  constexpr int kTile = 32;
  const int lanes = packet_lanes();
  const Cast cast = cast_of(picture);
  const int w = lanes >= 8 ? 4 : lanes >= 4 ? 2 : 1, h = lanes / w;
  const int across = (picture.options.width + kTile - 1) / kTile,
            down = (picture.options.height + kTile - 1) / kTile;
  const auto tile = [&](std::int64_t first, std::int64_t) {
    RenderCounts counts;
    Workplace at;
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
        cast_packet(picture, cast, {positions, count}, at, counts);
      }
    }
    return counts;
  };
  return parallel_reduce<RenderCounts>(0, std::int64_t{across} * down, 1, tile, add_counts);
}

/// Pixels of a list, in its order.
RenderCounts cast_list(const PacketPicture& picture, std::span<const PixelPosition> positions) {
  const auto lanes = static_cast<std::size_t>(packet_lanes());
  const Cast cast = cast_of(picture);
  const auto packets = static_cast<std::int64_t>((positions.size() + lanes - 1) / lanes);
  const auto some = [&](std::int64_t begin, std::int64_t end) {
    RenderCounts counts;
    Workplace at;
    for (std::int64_t p = begin; p < end; ++p) {
      const std::size_t first = static_cast<std::size_t>(p) * lanes;
      cast_packet(picture, cast, positions.subspan(first, std::min(lanes, positions.size() - first)), at,
                  counts);
    }
    return counts;
  };
  constexpr std::int64_t kTogether = 4;  // more would leave a thread waiting at the end of short lists
  return parallel_reduce<RenderCounts>(0, packets, kTogether, some, add_counts);
}

}  // namespace

RenderCounts cast_picture(const PacketPicture& picture) {
  if (picture.options.image_step == 1) return cast_tiles(picture);
  RenderCounts counts;
  cast_refined(picture.image, picture.options.image_step, picture.options.image_tolerance,
               [&](std::span<const PixelPosition> positions) { counts += cast_list(picture, positions); });
  return counts;
}

}  // namespace vol::render
