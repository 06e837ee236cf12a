#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/rng.h"
#include "render/options.h"
#include "volume/volume.h"

namespace vol::render {

/// Smooth blobs with a little noise on an unsymmetric grid (anisotropic, rotated, off-centre), values from
/// `lowest` to `lowest + full`: what the packet caster's tests draw.
template <class T>
volume::Volume packet_volume(double full, const Dims& dims = {23, 18, 29}, double lowest = 0) {
  volume::GridGeometry g;
  g.dims = dims;
  g.spacing = {0.5, 0.8, 0.4};
  g.origin = {-7, 3, 11};
  g.direction = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  volume::Grid<T> grid{g, Buffer<T>(static_cast<std::size_t>(g.count()))};
  Rng rng(1);
  const double phase = rng.uniform();
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const double x = (double(i) + 0.5) / double(dims[0]), y = (double(j) + 0.5) / double(dims[1]),
                     z = (double(k) + 0.5) / double(dims[2]);
        const auto blob = [&](double a, double b, double c, double s) {
          return std::exp(-((x - a) * (x - a) + (y - b) * (y - b) + (z - c) * (z - c)) / (2 * s * s));
        };
        double v = 0.7 * blob(0.35, 0.4, 0.6, 0.12) + 0.9 * blob(0.7, 0.6 + 0.1 * phase, 0.3, 0.08);
        v = v < 0.02 ? 0 : std::min(1.0, v + 0.05 * rng.uniform());
        grid(i, j, k) = static_cast<T>(lowest + full * v);
      }
    }
  }
  return {std::move(grid), {}};
}

/// Camera askew, colours that differ by channel; opacity 0 up to a third of the range, then a ramp and a
/// plateau.
inline Scene packet_scene(double full, double most_opaque = 0.5, double lowest = 0) {
  Scene scene;
  scene.view.azimuth = 33;
  scene.view.elevation = -21;
  const auto at = [&](double share) { return lowest + share * full; };
  scene.transfer = transfer::TransferFunction(
      {{at(0), {0.1, 0.2, 0.9}}, {at(0.4), {0.9, 0.3, 0.1}}, {at(1), {1, 0.9, 0.6}}},
      {{at(0), 0}, {at(0.3), 0}, {at(0.55), most_opaque}, {at(1), most_opaque}});
  return scene;
}

/// Opacities of 0 to 255 with `points` points, a jump among them, and ramps steep enough to be cut in
/// several.
inline std::vector<transfer::OpacityPoint> packet_ramps(int points, Rng& rng) {
  std::vector<transfer::OpacityPoint> opacities;
  for (int k = 0; k < points; ++k) {
    const double value = 10 + (k + 0.7 * rng.uniform()) * 230 / points;
    const double opacity = rng.uniform() < 0.3 ? 0 : 0.8 * rng.uniform();
    opacities.push_back({value, k == points / 2 ? 0.4 : opacity});
    if (k == points / 3) opacities.push_back({value, 0.1});
  }
  return opacities;
}

/// Grey soft scene: opacity and colour one line.
inline Scene packet_soft_scene(double full) {
  Scene scene;
  scene.view.azimuth = -40;
  scene.view.elevation = 15;
  scene.transfer = transfer::TransferFunction({{0, {0, 0, 0}}, {full, {1, 1, 1}}}, {{0, 0}, {full, 0.05}});
  return scene;
}

inline RenderOptions packet_options(Quadrature quadrature = Quadrature::trapezoid) {
  RenderOptions options;
  options.width = 45;
  options.height = 37;
  options.step = 0.173;
  options.quadrature = quadrature;
  return options;
}

}  // namespace vol::render
