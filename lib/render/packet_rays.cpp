#include "render/packet_rays.h"

#include <algorithm>
#include <cmath>

namespace vol::render {
namespace {

constexpr double kOne = 2147483648.0;  // 2^31
constexpr double kFar = kOne * kOne;   // a step that no ray takes

void split(std::int64_t fixed, std::int32_t& whole, std::int32_t& part) {
  whole = static_cast<std::int32_t>(fixed >> 31);
  part = static_cast<std::int32_t>(fixed & 0x7fffffff);
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
      origin_(geometry.origin) {}

void PacketRayMaker::clear(int lane, PacketRays& rays) {
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

/// Node 0 lies on a face, where rounding decides about the cell: the oracle's own formula.
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

PacketRayMaker::Lane PacketRayMaker::make(int x, int y, int lane, PacketRays& rays) const {
  const camera::Ray ray = camera_.ray(x + 0.5, y + 0.5);
  const auto chord = box_.chord(ray, camera_.t_min());
  if (!chord) {
    clear(lane, rays);
    return {};
  }
  const double steps = chord->length() / step_;
  std::int64_t segments =
      std::clamp<std::int64_t>(static_cast<std::int64_t>(std::ceil(steps - 1e-9)), 1, kMostSegments);
  const Vec3 start = to_index_ * (ray.origin - origin_);
  const Vec3 along = to_index_ * ray.direction;
  std::int64_t entry[3], exit[3], step[3];
  for (int a = 0; a < 3; ++a) {
    const std::int64_t top = std::max<std::int64_t>(0, (dims_[a] - 1) * (std::int64_t{1} << 31) - 1);
    const auto fixed = [&](double t) {
      const double p = std::clamp((start[a] + t * along[a]) * kOne, 0.0, static_cast<double>(top));
      return std::min(top, static_cast<std::int64_t>(p));
    };
    entry[a] = dims_[a] > 1 ? fixed(chord->entry) : 0;
    exit[a] = dims_[a] > 1 ? fixed(chord->exit) : 0;
    step[a] = dims_[a] > 1 ? static_cast<std::int64_t>(std::clamp(along[a] * step_ * kOne, -kFar, kFar)) : 0;
    // The last lattice node is inside up to rounding; should that carry it across the face, it is left out,
    // and the last segment is longer by that rounding.
    while (segments > 1 &&
           (entry[a] + (segments - 1) * step[a] < 0 || entry[a] + (segments - 1) * step[a] > top)) {
      --segments;
    }
  }
  for (int a = 0; a < 3; ++a) {
    split(entry[a], rays.entry_whole[a][lane], rays.entry_part[a][lane]);
    split(exit[a], rays.exit_whole[a][lane], rays.exit_part[a][lane]);
    split(step[a], rays.step_whole[a][lane], rays.step_part[a][lane]);
    rays.direction[a][lane] = static_cast<float>(ray.direction[a]);
  }
  rays.segments[lane] = static_cast<std::int32_t>(segments);
  rays.remainder[lane] = static_cast<float>(steps - static_cast<double>(segments - 1));
  rays.first_level[lane] = index_ ? first_level(ray.origin + chord->entry * ray.direction) : 0;
  return {true, *chord};
}

}  // namespace vol::render
