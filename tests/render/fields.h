#pragma once
#include <cmath>
#include <cstring>
#include <functional>

#include "base/rng.h"
#include "render/picture.h"
#include "render/raycast.h"
#include "volume/grid_sampler.h"

namespace vol::render {

/// A field in closed form on a box.
struct FunctionField {
  std::function<double(const Vec3&)> f;
  std::function<Vec3(const Vec3&)> g = [](const Vec3&) { return Vec3::Zero().eval(); };
  volume::FieldBounds box;

  [[nodiscard]] double value(const Vec3& p) const { return f(p); }
  [[nodiscard]] Vec3 gradient(const Vec3& p) const { return g(p); }
  [[nodiscard]] const volume::FieldBounds& bounds() const { return box; }
};

inline volume::FieldBounds box_of(const Vec3& corner, const Vec3& size) {
  return {corner, Mat3(size.asDiagonal())};
}

inline volume::FieldBounds generic_box() {
  return {Vec3(-3, 5, 2), Eigen::AngleAxisd(0.4, Vec3(2, -1, 3).normalized()).toRotationMatrix() *
                              Vec3(2, 3, 1.5).asDiagonal()};
}

inline transfer::TransferFunction constant_transfer(double opacity, const Vec3& colour = {0.2, 0.5, 0.9}) {
  return {{{0, colour}}, {{0, opacity}}};
}

/// Grey = value, opacity = slope * value, both clamped at value 1.
inline transfer::TransferFunction ramp_transfer(double top = 0.6) {
  return {{{0, Vec3(0, 0, 0)}, {1, Vec3(1, 0.8, 0.5)}}, {{0, 0}, {1, top}}};
}

inline Scene scene_of(const transfer::TransferFunction& transfer, double azimuth = 25,
                      double elevation = -35) {
  Scene scene;
  scene.transfer = transfer;
  scene.reference_length = 0.7;
  scene.view.azimuth = azimuth;
  scene.view.elevation = elevation;
  return scene;
}

/// The pixel at (x, y) of a 100 x 100 picture, in double.
inline Pixel cast(const RayCaster& caster, const volume::FieldBounds& bounds, const Scene& scene,
                  double x = 50.3, double y = 49.4, RenderCounts* counts = nullptr) {
  const camera::Camera camera(scene.view, bounds.centre(), bounds.longest_edge(), 100, 100);
  const camera::Ray ray = camera.ray(x, y);
  const auto chord = RayBox(bounds).chord(ray, camera.t_min());
  RenderCounts own;
  return chord ? caster(ray, *chord, counts ? *counts : own) : Pixel{};
}

inline double chord_length(const volume::FieldBounds& bounds, const Scene& scene, double x = 50.3,
                           double y = 49.4) {
  const camera::Camera camera(scene.view, bounds.centre(), bounds.longest_edge(), 100, 100);
  const auto chord = RayBox(bounds).chord(camera.ray(x, y), camera.t_min());
  return chord ? chord->length() : 0;
}

inline volume::GridGeometry generic_grid_geometry(const Dims& dims = {9, 12, 7}) {
  volume::GridGeometry g;
  g.dims = dims;
  g.spacing = {0.5, 2, 1.25};
  g.origin = {-7, 3, 11};
  g.direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  return g;
}

/// Samples in [0, 1]: smooth, nothing symmetric, not zero at the border; with noise for kinks everywhere.
inline volume::Volume generic_volume(double noise = 0.3, const Dims& dims = {9, 12, 7}) {
  volume::Grid<double> grid{generic_grid_geometry(dims), {}};
  grid.voxels.resize(static_cast<std::size_t>(grid.geometry.count()));
  Rng rng(7);
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const auto x = static_cast<double>(i), y = static_cast<double>(j), z = static_cast<double>(k);
        const double smooth = 0.5 + 0.35 * std::sin(0.5 * x + 0.2 * y) * std::cos(0.4 * z - 0.3 * y);
        grid(i, j, k) = (1 - noise) * smooth + noise * rng.uniform();
      }
    }
  }
  volume::Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

inline double difference(const Pixel& a, const Pixel& b) {
  return std::max((a.colour - b.colour).cwiseAbs().maxCoeff(), std::abs(a.alpha - b.alpha));
}

inline bool same_bits(const image::Image& a, const image::Image& b) {
  return a.pixels.size() == b.pixels.size() &&
         std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(float)) == 0;
}

}  // namespace vol::render
