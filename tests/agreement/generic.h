#pragma once
#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "image/image.h"
#include "render/raycast.h"
#include "volume/volume.h"

// Two unrelated ways to one picture, each in a library of its own.
namespace vol::agreement {

/// Unequal steps, oblique axes, an origin away from 0.
inline volume::GridGeometry oblique_geometry(const Dims& dims) {
  volume::GridGeometry g;
  g.dims = dims;
  g.spacing = Vec3(0.7, 1.1, 0.9);
  g.origin = Vec3(3, -20, 11);
  g.direction = Eigen::AngleAxisd(0.4, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  return g;
}

template <class F>
volume::Volume sampled(const volume::GridGeometry& geometry, const F& f) {
  volume::Grid<double> grid{geometry, Buffer<double>(static_cast<std::size_t>(geometry.count()))};
  for (std::int64_t k = 0; k < grid.dims()[2]; ++k) {
    for (std::int64_t j = 0; j < grid.dims()[1]; ++j) {
      for (std::int64_t i = 0; i < grid.dims()[0]; ++i) {
        grid(i, j, k) = f(geometry.index_to_world(Vec3(double(i), double(j), double(k))));
      }
    }
  }
  volume::Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

inline volume::Volume noise(const volume::GridGeometry& geometry, std::uint64_t seed) {
  Rng rng(seed);
  return sampled(geometry, [&](const Vec3&) { return rng.uniform(); });
}

/// All of the picture's definition that the ways could choose otherwise is given.
inline render::Scene oblique_scene(render::Model model, double width) {
  render::Scene scene;
  scene.model = model;
  scene.view.azimuth = 33;
  scene.view.elevation = 21;
  scene.view.width = width;
  scene.reference_length = 1;
  return scene;
}

struct Difference {
  double largest = 0;  ///< of a pixel
  double peak = 0;     ///< of the second picture
};

/// Of channel c.
inline Difference compare(const image::Image& a, const image::Image& b, int c, int width, int height) {
  Difference found;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double other = b.at(x, y, c);
      found.largest = std::max(found.largest, std::abs(a.at(x, y, c) - other));
      found.peak = std::max(found.peak, std::abs(other));
    }
  }
  return found;
}

}  // namespace vol::agreement
