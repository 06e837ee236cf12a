#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cstdint>

namespace vol {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Axis-aligned box, closed: { p : min <= p <= max }.
struct Box3 {
  Vec3 min = Vec3::Zero();
  Vec3 max = Vec3::Zero();

  [[nodiscard]] Vec3 centre() const { return 0.5 * (min + max); }
  [[nodiscard]] Vec3 size() const { return max - min; }
  [[nodiscard]] bool contains(const Vec3& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
};

/// Number of samples along x, y, z; x is the fastest in memory everywhere.
using Dims = std::array<std::int64_t, 3>;

}  // namespace vol
