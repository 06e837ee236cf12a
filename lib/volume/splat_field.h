#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "volume/field_sampler.h"
#include "volume/labels.h"

namespace vol::volume {

struct SplatOptions {
  double support = 1.5;  ///< radius R of a splat, world length
};

/// Chosen voxels as the sum of shifted radial basis functions (Gross, Lippert, Dreger & Koch 1995, eqs. 47,
/// 48):
///   f(x) = sum over the chosen voxels at x_v of b(x - x_v),   b(x) = (1 - |x|^2 / R^2)^3 for |x| < R, else
///   0.
///
/// Equation (49), b = b1(x)^2 + b2(y)^2 + b3(z)^2, as printed is neither radial nor local: b1(x)^2 alone
/// fills the whole plane of its x. The sum of squares is read as the squared radius, and the cubic is one in
/// it: twice continuously differentiable, 1 at its centre, and along a ray a polynomial of degree 6. Radii
/// are world lengths, so that splats are balls whatever the spacing.
///
/// The voxels' own lattice is the cell list: what lies within R of a point is found by its index.
/// A FieldSampler; 0 beyond its bounds.
class SplatField {
 public:
  /// \param chosen  of label 0, 1, ...: whether its voxels are splatted
  /// \throws vol::Error on a support that is not positive, or one of more than 8 voxels, or less than 1/100,
  /// along an axis
  SplatField(Grid<std::uint8_t> labels, const std::vector<bool>& chosen, const SplatOptions& options);

  [[nodiscard]] double value(const Vec3& p_world) const;
  [[nodiscard]] Vec3 gradient(const Vec3& p_world) const;
  /// The chosen voxels' box, with a support around it.
  [[nodiscard]] const FieldBounds& bounds() const { return bounds_; }

  /// Of label l's splats at a point: the sum, at [l].
  void shares(const Vec3& p_world, std::array<double, 256>& of) const;

  [[nodiscard]] double support() const { return support_; }
  [[nodiscard]] std::int64_t count() const { return count_; }  ///< of the splats

  /// Calls f(label, x_v) for the chosen voxels whose splats may reach the segment between two world points,
  /// and perhaps some more; x fastest.
  template <class F>
  void for_splats(const Vec3& a_world, const Vec3& b_world, const F& f) const;

 private:
  static constexpr std::int64_t kBlock = 4;  // voxels along the edge of a block that is passed over as one

  Grid<std::uint8_t> labels_;
  std::array<bool, 256> chosen_{};
  double support_;
  std::int64_t count_ = 0;
  Mat3 world_to_index_, index_to_world_;
  Vec3 reach_;  // of a ball of radius support, in index coordinates
  FieldBounds bounds_;
  Dims blocks_{0, 0, 0};
  std::vector<std::uint8_t> any_;  // of each block: whether it has a chosen voxel
};

template <class F>
void SplatField::for_splats(const Vec3& a_world, const Vec3& b_world, const F& f) const {
  const Vec3 a = world_to_index_ * (a_world - labels_.geometry.origin);
  const Vec3 b = world_to_index_ * (b_world - labels_.geometry.origin);
  std::int64_t first[3], last[3];
  for (int axis = 0; axis < 3; ++axis) {
    const auto most = static_cast<double>(labels_.geometry.dims[static_cast<std::size_t>(axis)] - 1);
    const double lo = std::ceil(std::min(a[axis], b[axis]) - reach_[axis]);
    const double hi = std::floor(std::max(a[axis], b[axis]) + reach_[axis]);
    if (!(lo <= most && hi >= 0)) return;
    first[axis] = static_cast<std::int64_t>(std::max(lo, 0.0));
    last[axis] = static_cast<std::int64_t>(std::min(hi, most));
  }
  const auto end_of = [&](std::int64_t at, int axis) { return std::min(last[axis], at | (kBlock - 1)); };
  for (std::int64_t k0 = first[2]; k0 <= last[2]; k0 = end_of(k0, 2) + 1) {
    for (std::int64_t j0 = first[1]; j0 <= last[1]; j0 = end_of(j0, 1) + 1) {
      for (std::int64_t i0 = first[0]; i0 <= last[0]; i0 = end_of(i0, 0) + 1) {
        const std::int64_t block = i0 / kBlock + blocks_[0] * (j0 / kBlock + blocks_[1] * (k0 / kBlock));
        if (any_[static_cast<std::size_t>(block)] == 0) continue;
        for (std::int64_t k = k0; k <= end_of(k0, 2); ++k) {
          for (std::int64_t j = j0; j <= end_of(j0, 1); ++j) {
            for (std::int64_t i = i0; i <= end_of(i0, 0); ++i) {
              const std::uint8_t label = labels_(i, j, k);
              if (!chosen_[label]) continue;
              const Vec3 index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
              f(label, Vec3(labels_.geometry.origin + index_to_world_ * index));
            }
          }
        }
      }
    }
  }
}

}  // namespace vol::volume
