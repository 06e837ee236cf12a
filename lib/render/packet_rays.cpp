#include "render/packet_rays.h"

#include <algorithm>
#include <cmath>

namespace vol::render {
namespace {

constexpr std::int64_t kLongestAxis = std::int64_t{1} << 21;

void split(std::int64_t fixed, std::int32_t& whole, std::int32_t& part) {
  whole = static_cast<std::int32_t>(fixed >> 31);
  part = static_cast<std::int32_t>(fixed & 0x7fffffff);
}

void clear(int lane, PacketRays& rays) {
  for (int a = 0; a < 3; ++a) {
    for (auto* v : {&rays.entry_whole, &rays.entry_part, &rays.exit_whole, &rays.exit_part, &rays.step_whole,
                    &rays.step_part}) {
      (*v)[a][lane] = 0;
    }
    rays.direction[a][lane] = 0;
  }
  rays.segments[lane] = 0;
  rays.remainder[lane] = 0;
  rays.first_level[lane] = 0;
}

void copy(const Vec3& from, double (&to)[3]) {
  std::copy(from.data(), from.data() + 3, to);
}
void copy(const Mat3& from, double (&to)[9]) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) to[3 * row + column] = from(row, column);
  }
}

}  // namespace

PacketRayMaker::PacketRayMaker(const volume::GridGeometry& geometry, const RayBox& box,
                               const camera::Camera& camera, double step, const index::IndexVolume* index)
    : box_(box),
      camera_(camera),
      step_(step),
      index_(index),
      dims_(geometry.dims),
      to_index_(geometry.world_to_index_matrix()),
      origin_(geometry.origin),
      short_axes_(*std::max_element(dims_.begin(), dims_.end()) <= kLongestAxis) {
  view_.perspective = camera.projection() == camera::Projection::perspective;
  copy(camera.eye(), view_.eye);
  copy(camera.right(), view_.right);
  copy(camera.up(), view_.up);
  copy(camera.direction(), view_.direction);
  view_.width = camera.width();
  view_.distance = camera.distance();
  view_.t_min = camera.t_min();
  view_.image_width = camera.image_width();
  view_.image_height = camera.image_height();
  copy(box.corner(), view_.corner);
  copy(box.to_box(), view_.to_box);
  copy(origin_, view_.origin);
  copy(to_index_, view_.to_index);
  for (int a = 0; a < 3; ++a) view_.last[a] = static_cast<double>(dims_[a] - 1);
  view_.step = step;
}

/// Node 0 lies on a face, where rounding decides about the cell: the oracle's own formula, for a point that
/// is the oracle's to the last bit.
int PacketRayMaker::first_level(const Vec3& p_world) const {
  const Vec3 u = box_.coordinates(p_world);
  std::int64_t entry[3];
  for (int a = 0; a < 3; ++a) {
    const double cell = u[a] * static_cast<double>(dims_[a] - 1);
    entry[a] =
        (!(cell > 0) ? 0 : std::min(static_cast<std::int64_t>(cell), dims_[a] - 1)) / index_->reduction();
  }
  return index_->entry(entry[0], entry[1], entry[2]);
}

void PacketRayMaker::make(std::span<const PixelPosition> pixels, PacketRays& rays,
                          PacketChords& chords) const {
  if (!short_axes_) return make_plain(pixels, rays, chords);
  alignas(64) std::int32_t x[kMaxLanes], y[kMaxLanes];
  const int lanes = packet_lanes(), count = static_cast<int>(pixels.size());
  for (int lane = 0; lane < lanes; ++lane) {
    const PixelPosition& pixel = pixels[static_cast<std::size_t>(std::min(lane, count - 1))];
    x[lane] = pixel.x;
    y[lane] = pixel.y;
  }
  make_rays(view_, x, y, rays, chords);
  for (int lane = count; lane < lanes; ++lane) clear(lane, rays);
  if (index_ == nullptr) return;
  for (int lane = 0; lane < count; ++lane) {
    if (rays.segments[lane] == 0) continue;
    const camera::Ray ray = camera_.ray(x[lane] + 0.5, y[lane] + 0.5);
    const auto chord = box_.chord(ray, camera_.t_min());
    const double entry = chord ? chord->entry : chords.entry[lane];
    rays.first_level[lane] = first_level(ray.origin + entry * ray.direction);
  }
}

void PacketRayMaker::make_plain(std::span<const PixelPosition> pixels, PacketRays& rays,
                                PacketChords& chords) const {
  const int lanes = packet_lanes(), count = static_cast<int>(pixels.size());
  for (int lane = 0; lane < lanes; ++lane) {
    clear(lane, rays);
    if (lane < count) make_plain(pixels[static_cast<std::size_t>(lane)], lane, rays, chords);
  }
}

void PacketRayMaker::make_plain(const PixelPosition& pixel, int lane, PacketRays& rays,
                                PacketChords& chords) const {
  const camera::Ray ray = camera_.ray(pixel.x + 0.5, pixel.y + 0.5);
  const auto chord = box_.chord(ray, camera_.t_min());
  if (!chord) return;
  const double steps = chord->length() / step_;
  std::int64_t segments =
      std::clamp<std::int64_t>(static_cast<std::int64_t>(std::ceil(steps - 1e-9)), 1, kMostSegments);
  const Vec3 start = to_index_ * (ray.origin - origin_);
  const Vec3 along = to_index_ * ray.direction;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t top = std::max<std::int64_t>(0, (dims_[a] - 1) * (std::int64_t{1} << 31) - 1);
    const auto fixed = [&](double t) {
      const double p = std::clamp((start[a] + t * along[a]) * kOne, 0.0, static_cast<double>(top));
      return std::min(top, static_cast<std::int64_t>(p));
    };
    const bool flat = dims_[a] == 1;
    const std::int64_t entry = flat ? 0 : fixed(chord->entry);
    const std::int64_t exit = flat ? 0 : fixed(chord->exit);
    const std::int64_t step =
        flat ? 0 : static_cast<std::int64_t>(std::clamp(along[a] * step_ * kOne, -kFar, kFar));
    // The last lattice node is inside up to rounding; should that carry it across the face, it is left out,
    // and the last segment is longer by that rounding.
    while (segments > 1 && (entry + (segments - 1) * step < 0 || entry + (segments - 1) * step > top))
      --segments;
    split(entry, rays.entry_whole[a][lane], rays.entry_part[a][lane]);
    split(exit, rays.exit_whole[a][lane], rays.exit_part[a][lane]);
    split(step, rays.step_whole[a][lane], rays.step_part[a][lane]);
    rays.direction[a][lane] = static_cast<float>(ray.direction[a]);
  }
  rays.segments[lane] = static_cast<std::int32_t>(segments);
  rays.remainder[lane] = static_cast<float>(steps - static_cast<double>(segments - 1));
  chords.entry[lane] = chord->entry;
  chords.exit[lane] = chord->exit;
  if (index_) rays.first_level[lane] = first_level(ray.origin + chord->entry * ray.direction);
}

}  // namespace vol::render
