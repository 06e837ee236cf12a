#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volume/field_sampler.h"
#include "volume/volume.h"

namespace vol::volume {

class AnalyticForm;

/// A field known in closed form, value and exact gradient: a FieldSampler without sampling error.
///
/// Forms are defined on the canonical box [-1,1]^3, which is mapped to the box of a grid (a box of unequal
/// edges stretches the form). Points outside are clamped to the box.
class AnalyticField {
 public:
  AnalyticField(std::shared_ptr<const AnalyticForm> form, const GridGeometry& geometry);

  [[nodiscard]] double value(const Vec3& p_world) const;
  /// Where a form jumps (checkerboard, impulse, voxel-object) the gradient is 0 on both sides; between the
  /// regions of texture it is that of the point's own.
  [[nodiscard]] Vec3 gradient(const Vec3& p_world) const;
  [[nodiscard]] const FieldBounds& bounds() const { return bounds_; }
  [[nodiscard]] const GridGeometry& geometry() const { return geometry_; }

  [[nodiscard]] Vec3 world_to_canonical(const Vec3& p_world) const;
  /// Jacobian of world_to_canonical.
  [[nodiscard]] const Mat3& canonical_matrix() const { return to_canonical_; }

  /// What the values lie between: exactly for marschner-lobb, gaussian, ramp, constant, impulse, checkerboard
  /// and the shapes; nominally for the seeded forms and bust, whose extremes have no closed form: peaks of
  /// gaussians, protein and bust are met to a few percent, noise and texture keep to four standard
  /// deviations.
  [[nodiscard]] Range range() const;

  /// Voxel (i, j, k) of the field's grid, without the rounding that a way through world space would add.
  [[nodiscard]] double sample(std::int64_t i, std::int64_t j, std::int64_t k) const;
  /// A row of voxels along x, `values` as long as the row. Those of noise differ from sample() by rounding, a
  /// few 1e-15; all others are the same.
  void sample_row(std::int64_t j, std::int64_t k, std::span<double> values) const;

 private:
  std::shared_ptr<const AnalyticForm> form_;
  GridGeometry geometry_;
  FieldBounds bounds_;
  Vec3 centre_;
  Mat3 to_canonical_;
};

/// 64^3 samples over [-1,1]^3.
[[nodiscard]] GridGeometry canonical_geometry(const Dims& dims = {64, 64, 64});

struct AnalyticOptions {
  std::uint64_t seed = 1;                        ///< of gaussians, protein, noise and texture
  GridGeometry geometry = canonical_geometry();  ///< whose box the form is mapped to
};

struct AnalyticName {
  std::string_view name;
  std::string_view description;  ///< one line
};
/// All fields, in the order in which help lists them.
[[nodiscard]] const std::vector<AnalyticName>& analytic_field_names();

/// The field of a name; throws vol::Error listing the names.
[[nodiscard]] AnalyticField make_analytic_field(std::string_view name, const AnalyticOptions& options = {});

/// Standard deviation of the form "gaussian", exp(-|p|^2 / (2 sigma^2)), in canonical units.
inline constexpr double kGaussianSigma = 0.3;

/// Integral over t in [t0, t1] of exp(-|origin + t direction - centre|^2 / (2 sigma^2)) dt; the direction
/// need not be a unit vector. With c the parameter of closest approach, b the distance there and s = sigma /
/// |direction|,
///   exp(-b^2 / (2 sigma^2)) s sqrt(pi/2) (erf((t1 - c)/(s sqrt 2)) - erf((t0 - c)/(s sqrt 2))).
/// Of the field "gaussian" along a world ray: pass the ray in canonical space, where t stays the world
/// parameter.
[[nodiscard]] double gaussian_line_integral(const Vec3& centre, double sigma, const Vec3& origin,
                                            const Vec3& direction, double t0, double t1);

/// The field on its grid as a volume, filled in parallel. Integer types map [scale.min, scale.max] linearly
/// onto [0, largest] (unsigned) or [-largest, largest] (signed), rounded and clamped; floating-point types
/// hold the field itself.
[[nodiscard]] Volume sampled_volume(const AnalyticField& field, VoxelType type, Range scale);

/// The scale that sampled_volume() is given by default: the field's range; for a field of both signs one that
/// keeps zero zero, [-m, m] for signed types and [0, max] for unsigned ones, which hold the positive part
/// alone, as the distributed halves of the iron protein do.
[[nodiscard]] Range default_scale(const AnalyticField& field, VoxelType type);

}  // namespace vol::volume
