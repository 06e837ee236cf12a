#include "camera/camera.h"

#include <numbers>
#include <sstream>

#include "base/rng.h"
#include "kernels.h"
#include "render/ray_box.h"
#include "truth.h"

namespace vol::stability {
namespace {

const Vec3 kCorner(-7, 3, 11), kSize(2, 3, 1.5);

volume::FieldBounds box(const Vec3& corner, const Vec3& size) {
  return {corner, Mat3(size.asDiagonal())};
}

/// Chords of the rays of a 41 x 31 picture: length against the slab test.
void chords(Table& table, const std::string& what, const camera::View& view, const Vec3& corner,
            const Vec3& size) {
  const volume::FieldBounds bounds = box(corner, size);
  const render::RayBox box_of_rays(bounds);
  const camera::Camera camera(view, bounds.centre(), bounds.longest_edge(), 41, 31);
  Worst worst;
  for (int y = 0; y < 31; ++y) {
    for (int x = 0; x < 41; ++x) {
      const camera::Ray ray = camera.ray(x + 0.5, y + 0.5);
      const auto chord = box_of_rays.chord(ray, camera.t_min());
      const TrueChord truth = true_chord(corner, size, ray, camera.t_min());
      const Real length = chord ? static_cast<Real>(chord->exit) - static_cast<Real>(chord->entry) : 0;
      // Where a ray just misses, the ends that pass each other are as uncertain.
      const double scale = std::max(truth.condition, corner.norm() + size.norm() + ray.origin.norm());
      worst.add(static_cast<double>(std::abs(length - truth.length)), 8 * kDouble * scale);
    }
  }
  table.row(what, "RayBox::chord", "double", worst,
            "8 roundings of the positions over the cosine to the face");
}

/// Directions against their definition, angles and all.
void rays(Table& table) {
  Worst worst;
  for (const double fov : {0.01, 1.0, 30.0, 120.0, 179.0}) {
    for (const double azimuth : {0.0, 30.0, 90.0, 180.0, -135.0}) {
      for (const double elevation : {0.0, 20.0, 89.9, -45.0}) {
        camera::View view;
        view.projection = camera::Projection::perspective;
        view.fov = fov;
        view.azimuth = azimuth;
        view.elevation = elevation;
        const camera::Camera camera(view, Vec3(1, 2, 3), 5, 40, 30);
        const Real degree = std::numbers::pi_v<Real> / 180, a = azimuth * degree, e = elevation * degree;
        const Real d[3] = {-std::cos(e) * std::sin(a), -std::sin(e), -std::cos(e) * std::cos(a)};
        const Real right[3] = {std::cos(a), 0, -std::sin(a)};
        const Real up[3] = {-std::sin(e) * std::sin(a), std::cos(e), -std::sin(e) * std::cos(a)};
        const Real half = std::tan(static_cast<Real>(fov) / 2 * degree);
        for (const auto& [x, y] : {std::pair{0.5, 0.5}, {20.0, 15.0}, {33.5, 2.5}}) {
          const Vec3 found = camera.ray(x, y).direction;
          const Real across = half * (static_cast<Real>(x) / 20 - 1) * 40 / 30,
                     upward = half * (1 - static_cast<Real>(y) / 15);
          Real truth[3], norm = 0, difference = 0;
          for (int i = 0; i < 3; ++i) {
            truth[i] = d[i] + across * right[i] + upward * up[i];
            norm += truth[i] * truth[i];
          }
          for (int i = 0; i < 3; ++i)
            difference = std::max(difference, std::abs(found[i] - truth[i] / std::sqrt(norm)));
          // right = d x up is normalised: by 1/cos(elevation) d's rounding counts.
          worst.add(static_cast<double>(difference),
                    32 * kDouble / std::cos(elevation * std::numbers::pi / 180));
        }
      }
    }
  }
  table.row("field of view 0.01 to 179 degrees, along axes and askew", "Camera::ray", "double", worst,
            "32 roundings, of d x up over its length");
}

}  // namespace

void camera(Table& table) {
  rays(table);
  vol::camera::View view;
  view.azimuth = 25;
  view.elevation = -35;
  chords(table, "askew, orthographic", view, kCorner, kSize);
  chords(table, "askew, an edge of 1e-4 of the others, origin 1e6 away", view, Vec3(1e6, 1e6, -1e6),
         Vec3(1, 1e-4, 1));
  view.projection = vol::camera::Projection::perspective;
  for (const double fov : {0.01, 30.0, 179.0}) {
    view.fov = fov;
    std::ostringstream what;
    what << "askew, field of view " << fov;
    chords(table, what.str(), view, kCorner, kSize);
  }
  view.fov = 90;
  view.distance = 0.4;  // the box is 2 x 3 x 1.5
  chords(table, "camera inside the volume", view, kCorner, kSize);
  view = {};
  for (const double azimuth : {0.0, 90.0, 180.0}) {
    view.azimuth = azimuth;
    std::ostringstream what;
    what << "along an axis, azimuth " << azimuth;
    chords(table, what.str(), view, kCorner, kSize);
  }
  view = {};
  view.elevation = 90;
  chords(table, "along an axis, elevation 90", view, kCorner, kSize);
  // The middle pixel's ray runs in the box's face, or so much beside it.
  for (const double beside : {0.0, 1e-12, -1e-12}) {
    view = {};
    view.target = Vec3(kCorner[0], kCorner[1] + beside, kCorner[2]);
    std::ostringstream what;
    what << "grazing, " << beside << " beside a face and an edge";
    chords(table, what.str(), view, kCorner, kSize);
  }
  for (const double fov : {0.0, 180.0}) {
    view = {};
    view.projection = vol::camera::Projection::perspective;
    view.fov = fov;
    table.refusal(fov == 0 ? "field of view 0" : "field of view 180", "Camera", "double",
                  [&] { (void)vol::camera::Camera(view, Vec3::Zero(), 1, 4, 4); });
  }
  view = {};
  view.target = kCorner;
  view.azimuth = 1e-7;
  chords(table, "grazing, 1e-7 degrees from a face", view, kCorner, kSize);
}

}  // namespace vol::stability
