#pragma once
#include <algorithm>
#include <cstdint>

#include "camera/camera.h"
#include "index/index_volume.h"
#include "render/ray_box.h"

namespace vol::render {

/// The ray's nodes that are visited, in order: every one, or those an index leaves.
class NodeWalk {
 public:
  /// \param index  of the volume that `box` is of, or null; all but `step` must live longer
  /// \throws vol::Error where there would be more than 1e9 nodes
  NodeWalk(const camera::Ray& ray, const Chord& chord, double step, const RayBox& box,
           const index::IndexVolume* index);

  [[nodiscard]] std::int64_t last() const { return last_; }
  [[nodiscard]] double t(std::int64_t node) const {
    return node == last_ ? chord_.exit : chord_.entry + static_cast<double>(node) * step_;
  }
  [[nodiscard]] Vec3 position(std::int64_t node) const { return ray_.origin + t(node) * ray_.direction; }
  [[nodiscard]] Vec3 coordinates(std::int64_t node) const { return box_.coordinates(position(node)); }
  [[nodiscard]] std::int64_t after(std::int64_t node) const {
    if (!index_) return node + 1;
    return std::min(last_, node + (std::int64_t{1} << entry_at(coordinates(node))));
  }

 private:
  [[nodiscard]] int entry_at(const Vec3& u) const;

  const camera::Ray& ray_;
  const Chord& chord_;
  double step_;
  const RayBox& box_;
  const index::IndexVolume* index_;
  std::int64_t last_ = 1;
};

}  // namespace vol::render
