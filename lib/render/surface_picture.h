#pragma once
#include <algorithm>
#include <limits>

#include "base/parallel.h"
#include "render/options.h"
#include "render/ray_box.h"
#include "render/shading.h"

namespace vol::render {

/// Unit normal, pointing out, of the face of a box that a world point is nearest to, in the box's
/// coordinates.
[[nodiscard]] inline Vec3 outward_normal(const RayBox& box, const Vec3& p_world) {
  const Vec3 u = box.coordinates(p_world);
  Eigen::Index axis = 0;
  u.cwiseMin(Vec3::Ones() - u).cwiseAbs().minCoeff(&axis);
  // A face's normal is a covector.
  return box.to_box().row(axis).transpose().normalized() * (u[axis] < 0.5 ? -1 : 1);
}

/// One ray a pixel, and its first hit with a surface: R, G, B, A (lit colour, linear; A 1 on the surface),
/// `depth` (world length along the ray, +infinity where there is none), `normal.x` .. `normal.z`,
/// `position.x` .. `position.z` (world; 0 where there is none). Blinn-Phong with the scene's shading, or its
/// defaults. Counts are folded row by row: the same whatever the number of threads.
/// \param surface  has bounds(), Counts and first_hit(ray, chord, counts), as IsosurfaceRays
template <class Surface>
[[nodiscard]] image::Image draw_first_hits(const Surface& surface, const Scene& scene, const Vec3& colour,
                                           int width, int height, typename Surface::Counts& all) {
  image::Image picture(width, height,
                       {"R", "G", "B", "A", "depth", "normal.x", "normal.y", "normal.z", "position.x",
                        "position.y", "position.z"});
  const RayBox box(surface.bounds());
  const camera::Camera camera(scene.view, surface.bounds().centre(), surface.bounds().longest_edge(), width,
                              height);
  const BlinnPhong light(scene.shading.value_or(Shading{}));
  const auto row = [&](std::int64_t begin, std::int64_t end) {
    typename Surface::Counts counts;
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        float* pixel = &picture.at(x, y, 0);
        std::fill_n(pixel, 11, 0.0F);
        pixel[4] = std::numeric_limits<float>::infinity();
        const camera::Ray ray = camera.ray(x + 0.5, y + 0.5);
        const auto chord = box.chord(ray, camera.t_min());
        if (!chord) continue;
        const auto hit = surface.first_hit(ray, *chord, counts);
        if (!hit) continue;
        const Vec3 lit = light(-hit->normal, ray.direction)(colour);
        for (int c = 0; c < 3; ++c) {
          pixel[c] = static_cast<float>(lit[c]);
          pixel[5 + c] = static_cast<float>(hit->normal[c]);
          pixel[8 + c] = static_cast<float>(hit->position[c]);
        }
        pixel[3] = 1;
        pixel[4] = static_cast<float>(hit->t);
      }
    }
    return counts;
  };
  using Counts = typename Surface::Counts;
  all = parallel_reduce<Counts>(0, height, 1, row, [](Counts& sum, const Counts& part) { sum += part; });
  return picture;
}

}  // namespace vol::render
