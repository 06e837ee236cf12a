#include "volume/analytic_field.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.h"
#include "base/parallel.h"
#include "volume/analytic_form.h"
#include "volume/arithmetic.h"
#include "volume/grid_sampler.h"

namespace vol::volume {

AnalyticField::AnalyticField(FormPointer form, const GridGeometry& geometry)
    : form_(std::move(form)),
      geometry_(geometry),
      bounds_(field_bounds(geometry)),
      centre_(geometry.centre()) {
  const Vec3 edges = geometry.edge_lengths();
  to_canonical_ = (2 * edges.cwiseInverse()).asDiagonal() * geometry.direction.inverse();
}

Vec3 AnalyticField::world_to_canonical(const Vec3& p_world) const {
  return to_canonical_ * (p_world - centre_);
}

double AnalyticField::value(const Vec3& p_world) const {
  Vec3 q = world_to_canonical(p_world).cwiseMax(-1).cwiseMin(1);
  for (int a = 0; a < 3; ++a) {
    if (geometry_.dims[a] == 1) q[a] = 0;  // constant along an axis of one sample
  }
  return form_->value(q);
}

Vec3 AnalyticField::gradient(const Vec3& p_world) const {
  Vec3 q = world_to_canonical(p_world).cwiseMax(-1).cwiseMin(1);
  for (int a = 0; a < 3; ++a) {
    if (geometry_.dims[a] == 1) q[a] = 0;
  }
  Vec3 slope = form_->gradient(q);
  for (int a = 0; a < 3; ++a) {
    if (geometry_.dims[a] == 1) slope[a] = 0;
  }
  return to_canonical_.transpose() * slope;
}

Range AnalyticField::range() const {
  return form_->range();
}

double AnalyticField::sample(std::int64_t i, std::int64_t j, std::int64_t k) const {
  const Dims& n = geometry_.dims;
  return form_->value(
      Vec3(canonical_coordinate(i, n[0]), canonical_coordinate(j, n[1]), canonical_coordinate(k, n[2])));
}

void AnalyticField::sample_row(std::int64_t j, std::int64_t k, std::span<double> values) const {
  const Dims& n = geometry_.dims;
  std::vector<double> x(static_cast<std::size_t>(n[0]));
  for (std::int64_t i = 0; i < n[0]; ++i) x[static_cast<std::size_t>(i)] = canonical_coordinate(i, n[0]);
  form_->row(x, canonical_coordinate(j, n[1]), canonical_coordinate(k, n[2]), values);
}

GridGeometry canonical_geometry(const Dims& dims) {
  GridGeometry geometry;
  geometry.dims = dims;
  for (int a = 0; a < 3; ++a) {
    geometry.spacing[a] = dims[a] > 1 ? 2 / static_cast<double>(dims[a] - 1) : 2;
    geometry.origin[a] = dims[a] > 1 ? -1 : 0;
  }
  return geometry;
}

const std::vector<AnalyticName>& analytic_field_names() {
  static const std::vector<AnalyticName> names = {
      {"marschner-lobb", "the test signal of Marschner & Lobb 1994: fM = 6, alpha = 0.25"},
      {"gaussian", "exp(-|p|^2 / (2 0.3^2))"},
      {"gaussians", "seeded cloud of 20 Gaussians"},
      {"protein", "screened-Coulomb potential of a folded, seeded chain of charges of both signs"},
      {"sphere", "ball of radius 0.6 with a smooth edge, 1/2 on its surface"},
      {"shell", "hollow sphere of radius 0.6 with smooth edges"},
      {"torus", "torus about z, radii 0.55 and 0.22, with a smooth edge, 1/2 on its surface"},
      {"bust", "head and shoulders of smooth blobs"},
      {"voxel-object", "a chair of 8^3 binary boxes"},
      {"ramp", "linear, 0 at one corner and 1 at the opposite one"},
      {"constant", "1/2 everywhere"},
      {"impulse", "1 in the box of the middle voxel, else 0"},
      {"checkerboard", "8^3 boxes of 0 and 1 in turn"},
      {"noise", "seeded sum of cosines, band-limited to 8 cycles an edge"},
      {"texture", "four regions of seeded waves, alike in mean and variance; see --labels-output"},
  };
  return names;
}

AnalyticField make_analytic_field(std::string_view name, const AnalyticOptions& options) {
  options.geometry.validate();
  for (const auto& make : {make_elementary_form, make_blob_form, make_shape_form, make_stepped_form,
                           make_protein_form, make_texture_form}) {
    if (auto form = make(name, options)) return {std::move(form), options.geometry};
  }
  std::string names;
  for (const auto& entry : analytic_field_names())
    names += (names.empty() ? "" : ", ") + std::string(entry.name);
  throw Error("no field '" + std::string(name) + "'; there are: " + names);
}

double gaussian_line_integral(const Vec3& centre, double sigma, const Vec3& origin, const Vec3& direction,
                              double t0, double t1) {
  const double length = direction.norm();
  const double c = direction.dot(centre - origin) / (length * length);
  const double b2 = (origin + c * direction - centre).squaredNorm();
  const double s = sigma / length;
  // erfc where both ends lie on one side of the maximum: there the difference of two erf would cancel.
  double u0 = (t0 - c) / (s * std::numbers::sqrt2);
  double u1 = (t1 - c) / (s * std::numbers::sqrt2);
  if (u1 < 0 && u0 < 0) {
    std::swap(u0, u1);
    u0 = -u0;
    u1 = -u1;
  }
  const double difference = u0 > 0 && u1 > 0 ? std::erfc(u0) - std::erfc(u1) : std::erf(u1) - std::erf(u0);
  return std::exp(-b2 / (2 * sigma * sigma)) * s * std::sqrt(std::numbers::pi / 2) * difference;
}

Volume sampled_volume(const AnalyticField& field, VoxelType type, Range scale) {
  Volume volume = allocate(type, field.geometry());
  visit(volume, [&](auto& grid) {
    using T = typename std::decay_t<decltype(grid)>::value_type;
    const auto [nx, ny, nz] = grid.dims();
    parallel_for(0, ny * nz, 4, [&](std::int64_t first, std::int64_t last) {
      std::vector<double> values(static_cast<std::size_t>(nx));
      for (std::int64_t row = first; row < last; ++row) {
        field.sample_row(row % ny, row / ny, values);
        for (std::int64_t i = 0; i < nx; ++i) {
          const double f = values[static_cast<std::size_t>(i)];
          T& voxel = grid.voxels[static_cast<std::size_t>(i + nx * row)];
          if constexpr (std::is_integral_v<T>) {
            constexpr double kLargest = static_cast<double>(std::numeric_limits<T>::max());
            constexpr double kLowest = std::is_signed_v<T> ? -kLargest : 0;
            const double u = (f - scale.min) / (scale.max - scale.min);
            voxel = stored_as<T>(std::fmax(kLowest + u * (kLargest - kLowest), kLowest));
          } else {
            voxel = stored_as<T>(f);
          }
        }
      }
    });
  });
  return volume;
}

Range default_scale(const AnalyticField& field, VoxelType type) {
  const Range range = field.range();
  if (!(range.min < 0 && range.max > 0)) return range;
  const bool is_unsigned = type == VoxelType::u8 || type == VoxelType::u16 || type == VoxelType::u32;
  const double most = std::fmax(-range.min, range.max);
  return is_unsigned ? Range{0, range.max} : Range{-most, most};
}

}  // namespace vol::volume
