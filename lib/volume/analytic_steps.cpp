// voxel-object, impulse, checkerboard: constant in boxes, gradient 0.
#include <algorithm>
#include <array>
#include <cmath>

#include "volume/analytic_form.h"

namespace vol::volume {
namespace {

class Stepped : public AnalyticForm {
 public:
  Vec3 gradient(const Vec3&) const override { return Vec3::Zero(); }
};

/// Which of n equal boxes a canonical coordinate lies in; a border belongs to the upper box, the last to the
/// last.
int box_of(double q, int n) {
  return std::clamp(static_cast<int>(std::floor(0.5 * (q + 1) * n)), 0, n - 1);
}

class Checkerboard : public Stepped {
 public:
  double value(const Vec3& p) const override {
    return (box_of(p.x(), 8) + box_of(p.y(), 8) + box_of(p.z(), 8)) % 2;
  }
};

/// A chair: legs, seat, back with a gap. Layers from the floor (low y) up; each the plan seen from above,
/// rows along z, columns along x; the highest bit is the lowest x.
class VoxelObject : public Stepped {
 public:
  double value(const Vec3& p) const override {
    const int x = box_of(p.x(), 8);
    const int y = box_of(p.y(), 8);
    const int z = box_of(p.z(), 8);
    return kLayers[static_cast<std::size_t>(y)][static_cast<std::size_t>(z)] >> (7 - x) & 1;
  }

 private:
  using Plan = std::array<std::uint8_t, 8>;
  static constexpr Plan kEmpty{};
  static constexpr Plan kLegs{0, 0b01000010, 0, 0, 0, 0, 0b01000010, 0};
  static constexpr Plan kSeat{0, 0b01111110, 0b01111110, 0b01111110, 0b01111110, 0b01111110, 0b01111110, 0};
  static constexpr Plan kPosts{0, 0b01000010, 0, 0, 0, 0, 0, 0};
  static constexpr Plan kRest{0, 0b01111110, 0, 0, 0, 0, 0, 0};
  static constexpr std::array<Plan, 8> kLayers{kEmpty, kLegs, kLegs, kSeat, kPosts, kRest, kRest, kEmpty};
};

/// 1 within half a voxel of voxel floor(n/2) of the grid.
class Impulse : public Stepped {
 public:
  explicit Impulse(const Dims& dims) : dims_(dims) {}
  double value(const Vec3& p) const override {
    for (int a = 0; a < 3; ++a) {
      const std::int64_t n = dims_[a];
      const double index = n == 1 ? 0 : 0.5 * (p[a] + 1) * static_cast<double>(n - 1);
      if (std::abs(index - static_cast<double>(n / 2)) > 0.5) return 0;
    }
    return 1;
  }

 private:
  Dims dims_;
};

}  // namespace

FormPointer make_stepped_form(std::string_view name, const AnalyticOptions& options) {
  if (name == "checkerboard") return std::make_shared<Checkerboard>();
  if (name == "voxel-object") return std::make_shared<VoxelObject>();
  if (name == "impulse") return std::make_shared<Impulse>(options.geometry.dims);
  return nullptr;
}

}  // namespace vol::volume
