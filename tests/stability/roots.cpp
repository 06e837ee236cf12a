#include "base/rng.h"
#include "kernels.h"
#include "render/isosurface_rays.h"
#include "truth.h"
#include "volume/grid_sampler.h"

// First crossings of polynomials and of isosurfaces, where the root is known.
namespace vol::stability {
namespace {

using render::Bernstein;

/// (u - r) times a factor without roots in [0, 1], in Bernstein form, and the most that rounding its
/// coefficients may move p at r over p'(r).
struct Known {
  Bernstein p;
  double uncertain;
};
Known polynomial(double root, int degree, double scale, double offset, Rng& rng) {
  std::vector<Real> factor(static_cast<std::size_t>(degree));  // degree - 1, positive
  for (auto& b : factor) b = static_cast<Real>(scale) * static_cast<Real>(rng.uniform(0.5, 2));
  Known known;
  known.p.degree = degree;
  Real largest = 0, at_root = 0;
  for (int k = 0; k <= degree; ++k) {  // (u - r) q: ((1 - r) k q_k-1 - r (n - k) q_k) / n
    Real b = 0;
    const Real n = degree, r = root;
    if (k > 0) b += (1 - r) * static_cast<Real>(k) * factor[static_cast<std::size_t>(k - 1)];
    if (k < degree) b -= r * (n - static_cast<Real>(k)) * factor[static_cast<std::size_t>(k)];
    b = b / n + static_cast<Real>(offset);
    known.p.b[static_cast<std::size_t>(k)] = static_cast<double>(b);
    largest = std::max(largest, std::abs(b));
  }
  Bernstein q;
  q.degree = degree - 1;
  for (int k = 0; k < degree; ++k)
    q.b[static_cast<std::size_t>(k)] = static_cast<double>(factor[static_cast<std::size_t>(k)]);
  at_root = static_cast<Real>(q(root));  // p'(r)
  known.uncertain = static_cast<double>(largest / at_root);
  return known;
}

void crossings(Table& table, const std::string& what, double scale, double offset) {
  Worst worst;
  Rng rng(13);
  for (int trial = 0; trial < 2000; ++trial) {
    const double root = trial % 5 == 0   ? std::pow(10, rng.uniform(-15, -1))
                        : trial % 5 == 1 ? 1 - std::pow(10, rng.uniform(-15, -1))
                                         : rng.uniform();
    const int degree = trial % 3 == 0 ? 1 : trial % 3 == 1 ? 3 : 9;
    const Known known = polynomial(root, degree, scale, offset, rng);
    const auto found = render::first_crossing(known.p, offset);
    // Within what the coefficients' rounding moves the root: beyond an end it may be none.
    const double bound = 1e-14 + 4.0 * degree * kDouble * known.uncertain;
    if (!found && (root < bound || root > 1 - bound)) continue;
    worst.add(found ? std::abs(*found - root) : HUGE_VAL, bound);
  }
  table.row(what, "first_crossing", "double", worst,
            "1e-14, and 4 n roundings of the coefficients over the slope");
}

/// A plane f = scale (i - 1.3) + offset seen by rays: each hits it where the coordinate is.
void planes(Table& table, const std::string& what, double scale, double offset, const Vec3& spacing,
            const camera::View& view, volume::Reconstruction reconstruction) {
  volume::Grid<double> grid;
  grid.geometry.dims = {6, 5, 7};
  grid.geometry.spacing = spacing;
  grid.geometry.origin = Vec3(3, -2, 1);
  grid.voxels = Buffer<double>(static_cast<std::size_t>(grid.geometry.count()));
  std::size_t n = 0;
  for (std::int64_t k = 0; k < 7; ++k) {
    for (std::int64_t j = 0; j < 5; ++j) {
      for (std::int64_t i = 0; i < 6; ++i) grid.voxels[n++] = scale * double(i) + offset;
    }
  }
  volume::Volume volume;
  volume.grid = std::move(grid);
  const double isovalue = 1.3 * scale + offset;
  const render::IsosurfaceRays surface(volume, reconstruction, isovalue, false);
  const auto bounds = volume::field_bounds(volume.geometry());
  const camera::Camera camera(view, bounds.centre(), bounds.longest_edge(), 31, 23);
  const render::RayBox box(bounds);
  Worst worst;
  for (int y = 0; y < 23; ++y) {
    for (int x = 0; x < 31; ++x) {
      const camera::Ray ray = camera.ray(x + 0.5, y + 0.5);
      const auto chord = box.chord(ray, camera.t_min());
      if (!chord || ray.direction[0] == 0) continue;
      render::IsosurfaceRays::Counts counts;
      const auto hit = surface.first_hit(ray, *chord, counts);
      const Real level = (static_cast<Real>(isovalue) - static_cast<Real>(offset)) / static_cast<Real>(scale);
      const Real at = 3 + level * static_cast<Real>(spacing[0]);
      const Real t = (at - static_cast<Real>(ray.origin[0])) / static_cast<Real>(ray.direction[0]);
      // Samples less the isovalue are exact but for one rounding: an offset costs no digit.
      const double values = 6 * spacing[0];
      const double bound =
          (32 * kDouble *
           (values + static_cast<double>(std::abs(at)) + ray.origin.norm() + bounds.longest_edge())) /
              std::abs(ray.direction[0]) +
          2e-14 * chord->length();
      if (t < static_cast<Real>(chord->entry + bound) || t > static_cast<Real>(chord->exit - bound)) continue;
      worst.add(hit ? static_cast<double>(std::abs(static_cast<Real>(hit->t) - t)) : HUGE_VAL, bound);
    }
  }
  table.row(what, "IsosurfaceRays::first_hit", "double", worst,
            "32 roundings of values and positions over the cosine, 1e-14 of a cell");
}

}  // namespace

void roots(Table& table) {
  crossings(table, "degree 1, 3, 9, roots from 1e-15 to 1 - 1e-15", 1, 0);
  crossings(table, "coefficients of 1e30", 1e30, 0);
  crossings(table, "coefficients of 1e-30", 1e-30, 0);
  crossings(table, "coefficients of 1 on 1e8", 1, 1e8);
  camera::View view;
  view.azimuth = 35;
  view.elevation = -20;
  const auto linear = volume::Reconstruction::trilinear;
  planes(table, "a plane, askew", 1, 0, {1, 1, 1}, view, linear);
  planes(table, "a plane, askew, Catmull-Rom", 1, 0, {1, 1, 1}, view, volume::Reconstruction::catmull_rom);
  planes(table, "values of 1e30", 1e30, 0, {1, 1, 1}, view, linear);
  planes(table, "values of 1e-30", 1e-30, 0, {1, 1, 1}, view, linear);
  planes(table, "signal 1 on 1e8", 1, 1e8, {1, 1, 1}, view, linear);
  planes(table, "spacing ratio 1e4", 1, 0, {1e-2, 1, 100}, view, linear);
  view.azimuth = 90;
  view.elevation = 0;
  planes(table, "along an axis", 1, 0, {1, 1, 1}, view, linear);
  view.azimuth = 1e-5;
  view.target = Vec3(3 + 1.3, 0, 4);  // on the plane: the middle column of rays meets it
  planes(table, "grazing, 1e-5 degrees from the plane", 1, 0, {1, 1, 1}, view, linear);
  view.target.reset();
  view.azimuth = 35;
  view.projection = camera::Projection::perspective;
  view.fov = 179;
  planes(table, "field of view 179", 1, 0, {1, 1, 1}, view, linear);
  view.fov = 0.01;
  planes(table, "field of view 0.01", 1, 0, {1, 1, 1}, view, linear);
  view.fov = 100;
  view.distance = 0.5;
  planes(table, "camera inside the volume", 1, 0, {1, 1, 1}, view, linear);
  table.refusal("an isovalue that is not finite", "IsosurfaceRays", "double", [] {
    volume::Volume volume = volume::allocate(volume::VoxelType::f32, {.dims = {2, 2, 2}});
    std::fill_n(std::get<volume::Grid<float>>(volume.grid).voxels.begin(), 8, 0.0f);
    (void)render::IsosurfaceRays(volume, volume::Reconstruction::trilinear, std::nan(""), false);
  });
}

}  // namespace vol::stability
