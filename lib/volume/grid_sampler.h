#pragma once
#include <type_traits>

#include "volume/b_spline.h"
#include "volume/field_sampler.h"
#include "volume/kernels.h"
#include "volume/volume.h"

namespace vol::volume {

/// The parallelepiped spanned by the outermost sample centres (one spacing thick along an axis of one
/// sample).
[[nodiscard]] inline FieldBounds field_bounds(const GridGeometry& geometry) {
  const Box3 box = geometry.index_box();
  return {geometry.index_to_world(box.min),
          geometry.direction * geometry.spacing.cwiseProduct(box.size()).asDiagonal()};
}

/// A grid of samples as a field: FieldSampler by a reconstruction kernel, in double arithmetic.
///
/// Reproduced exactly, values and gradients: nearest constants; trilinear 1, x, y, z and their products;
/// Catmull-Rom polynomials of degree 2 per axis up to the border (kernels.h says how); b_spline of degree 3
/// per axis away from the border, where the mirrored spline flattens: its influence decays by 0.27 a sample.
/// Points outside are clamped to the box; the gradient there is the one at the clamped point. Along an axis
/// of one sample the field is constant. The gradient is that of the reconstructed field itself, one-sided
/// (from the upper cell) where trilinear has a kink; that of nearest is 0.
///
/// Keeps a reference to the grid, which must live longer and not change; b_spline holds its coefficients,
/// 8 bytes a voxel.
template <class T, Reconstruction kKernel>
class GridSampler {
 public:
  using value_type = T;
  static constexpr Reconstruction kReconstruction = kKernel;

  explicit GridSampler(const Grid<T>& grid)
      : dims_(grid.dims()),
        world_to_index_(grid.geometry.world_to_index_matrix()),
        origin_(grid.geometry.origin),
        bounds_(field_bounds(grid.geometry)) {
    if constexpr (kKernel == Reconstruction::b_spline) {
      coefficients_ = b_spline_coefficients(grid);
      samples_ = coefficients_.data();
    } else {
      samples_ = grid.voxels.data();
    }
  }
  GridSampler(const GridSampler&) = delete;
  GridSampler& operator=(const GridSampler&) = delete;
  GridSampler(GridSampler&&) noexcept = default;  // a moved vector keeps its address, so samples_ stays right
  GridSampler& operator=(GridSampler&&) noexcept = default;

  [[nodiscard]] const FieldBounds& bounds() const { return bounds_; }
  [[nodiscard]] Vec3 world_to_index(const Vec3& p_world) const {
    return world_to_index_ * (p_world - origin_);
  }

  [[nodiscard]] double value(const Vec3& p_world) const { return value_index(world_to_index(p_world)); }
  /// World gradient: the transposed Jacobian of world_to_index times the gradient in index space.
  [[nodiscard]] Vec3 gradient(const Vec3& p_world) const {
    return world_to_index_.transpose() * gradient_index(world_to_index(p_world));
  }

  /// The field at continuous index coordinates.
  [[nodiscard]] double value_index(const Vec3& p_index) const {
    const Weights x = weights(p_index, 0);
    const Weights y = weights(p_index, 1);
    const Weights z = weights(p_index, 2);
    double sum = 0;
    for (int c = 0; c < kTaps; ++c) {
      double plane = 0;
      for (int b = 0; b < kTaps; ++b) {
        const Sample* row = row_at(y.index[b], z.index[c]);
        double line = 0;
        for (int a = 0; a < kTaps; ++a) line += x.w[a] * static_cast<double>(row[x.index[a]]);
        plane += y.w[b] * line;
      }
      sum += z.w[c] * plane;
    }
    return sum;
  }

  /// Derivatives along the three index axes, in value per sample.
  [[nodiscard]] Vec3 gradient_index(const Vec3& p_index) const {
    const Weights x = weights(p_index, 0);
    const Weights y = weights(p_index, 1);
    const Weights z = weights(p_index, 2);
    // Relative to one sample: where all are equal the gradient is 0, not rounding, which would have a
    // direction.
    const auto base = static_cast<double>(row_at(y.index[0], z.index[0])[x.index[0]]);
    Vec3 sum = Vec3::Zero();
    for (int c = 0; c < kTaps; ++c) {
      for (int b = 0; b < kTaps; ++b) {
        const Sample* row = row_at(y.index[b], z.index[c]);
        double line = 0;
        double slope = 0;
        for (int a = 0; a < kTaps; ++a) {
          const double sample = static_cast<double>(row[x.index[a]]) - base;
          line += x.w[a] * sample;
          slope += x.dw[a] * sample;
        }
        sum += Vec3(y.w[b] * z.w[c] * slope, y.dw[b] * z.w[c] * line, y.w[b] * z.dw[c] * line);
      }
    }
    return sum;
  }

 private:
  static constexpr int kTaps = taps(kKernel);
  using Weights = AxisWeights<kTaps>;
  using Sample = std::conditional_t<kKernel == Reconstruction::b_spline, double, T>;

  [[nodiscard]] Weights weights(const Vec3& p_index, int axis) const {
    return axis_weights<kKernel>(clamped_to_axis(p_index[axis], dims_[axis]), dims_[axis]);
  }
  [[nodiscard]] const Sample* row_at(std::int64_t j, std::int64_t k) const {
    return samples_ + dims_[0] * (j + dims_[1] * k);
  }

  Dims dims_;
  Mat3 world_to_index_;
  Vec3 origin_;
  FieldBounds bounds_;
  Buffer<double> coefficients_;  // of b_spline only
  const Sample* samples_ = nullptr;
};

}  // namespace vol::volume
