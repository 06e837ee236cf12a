// Surfaces among a medium: against closed forms, against the isosurface's own picture, and against its mesh.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "fields.h"
#include "isosurface/marching_cubes.h"
#include "isosurface_oracle.h"
#include "render/gauss.h"
#include "render/surfaces.h"

namespace vol::render {
namespace {

constexpr double kTolerance = 1e-10;  // the reference's default
const Vec3 kColour(0.9, 0.3, 0.1);

RenderOptions options_with(Quadrature quadrature, double step = 0.1) {
  RenderOptions options;
  options.quadrature = quadrature;
  options.step = step;
  return options;
}

/// Ambient light alone, as it is: a surface shows its colour whatever its normal.
Scene unlit(Scene scene) {
  scene.shading = Shading{.ambient = 1, .diffuse = 0, .specular = 0, .exponent = 1, .light = {}};
  return scene;
}

/// A gradient for fields whose lighting does not ask for one.
Vec3 flat(const Vec3&) {
  return Vec3::Zero();
}

/// Two triangles that hold a square about `centre` across `normal`.
mesh::TriangleMesh sheet(const Vec3& centre, const Vec3& normal, double half) {
  const Vec3 u = normal.unitOrthogonal() * half;
  const Vec3 v = normal.cross(u);
  mesh::TriangleMesh mesh;
  for (const auto& [a, b] :
       {std::pair(-1.0, -1.0), std::pair(1.0, -1.0), std::pair(1.0, 1.0), std::pair(-1.0, 1.0)}) {
    const Vec3 p = centre + a * u + b * v;
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// The pixel at (50.3, 49.4) of 100 x 100, as fields.h's cast().
struct Shot {
  camera::Ray ray;
  Chord chord;
  Shot(const volume::FieldBounds& box, const Scene& scene) {
    const camera::Camera camera(scene.view, box.centre(), box.longest_edge(), 100, 100);
    ray = camera.ray(50.3, 49.4);
    chord = RayBox(box).chord(ray, camera.t_min()).value();
  }
  [[nodiscard]] Vec3 at(double share) const {
    return ray.origin + (chord.entry + share * chord.length()) * ray.direction;
  }
  Pixel operator()(const HybridCaster& cast) const {
    RenderCounts counts;
    return cast(ray, &chord, counts);
  }
};

// A constant medium with sheets of opacity b at shares s1 and s2 of the chord:
//   I = (1 - e1) c + e1 b C + e1 (1 - b) ((1 - e2) c + e2 (b C + (1 - b) (1 - e3) c)),
// e1, e2, e3 the medium's transmittances between. Every rule is exact on a constant medium, at any step.
TEST(Surfaces, BetweenPartsOfAConstantMedium) {
  const FunctionField field{[](const Vec3&) { return 3.0; }, flat, generic_box()};
  const Vec3 medium(0.2, 0.5, 0.9);
  for (const double a : {0.0, 0.3, 0.99}) {
    for (const double b : {0.0, 0.25, 1.0}) {
      // Shading leaves the medium's colour as it is, too: ambient 1.
      const Scene scene = unlit(scene_of(constant_transfer(a)));
      const Shot shot(field.box, scene);
      constexpr double kShare[2] = {0.31, 0.72};
      const mesh::TriangleMesh near = sheet(shot.at(kShare[0]), Vec3(-shot.ray.direction), 0.3);
      const mesh::TriangleMesh far =
          sheet(shot.at(kShare[1]), Vec3(shot.ray.direction + Vec3(0.2, 0.3, 0)), 0.4);
      const mesh::MeshRays near_rays(near), far_rays(far);
      Surfaces surfaces(scene);
      surfaces.add(far_rays, {kColour, b});
      surfaces.add(near_rays, {kColour, b});
      const double sigma = -std::log1p(-a) / scene.reference_length;
      const double length = shot.chord.length();
      const auto transmittance = [&](double share) { return std::exp(-sigma * length * share); };
      const double e1 = transmittance(kShare[0]), e2 = transmittance(kShare[1] - kShare[0]),
                   e3 = transmittance(1 - kShare[1]);
      const Vec3 behind = (1 - e2) * medium + e2 * (b * kColour + (1 - b) * (1 - e3) * medium);
      const Vec3 colour = (1 - e1) * medium + e1 * (b * kColour + (1 - b) * behind);
      const double left = e1 * (1 - b) * e2 * (1 - b) * e3;
      // T falls to 1/2 before, at or behind the first sheet.
      double depth = std::numeric_limits<double>::infinity();
      if (e1 <= 0.5) {
        depth = shot.chord.entry + std::log(2) / sigma;
      } else if (e1 * (1 - b) <= 0.5) {
        depth = shot.chord.entry + kShare[0] * length;
      } else if (e1 * (1 - b) * e2 <= 0.5) {
        depth = shot.chord.entry + kShare[0] * length + std::log(2 * e1 * (1 - b)) / sigma;
      } else if (e1 * (1 - b) * e2 * (1 - b) <= 0.5) {
        depth = shot.chord.entry + kShare[1] * length;
      } else if (left <= 0.5) {
        depth = shot.chord.entry + kShare[1] * length + std::log(2 * e1 * e2 * (1 - b) * (1 - b)) / sigma;
      }
      for (const auto rule :
           {Quadrature::rectangle, Quadrature::trapezoid, Quadrature::preintegrated, Quadrature::reference}) {
        const Pixel p = shot(hybrid_caster(view_of(field), scene, options_with(rule, 0.17), surfaces));
        const double tolerance = rule == Quadrature::reference ? kTolerance : 1e-12;
        EXPECT_LT((p.colour - colour).norm(), tolerance) << a << ' ' << b << ' ' << int(rule);
        EXPECT_NEAR(p.alpha, 1 - left, tolerance);
        if (std::isinf(depth)) {
          EXPECT_EQ(p.depth, depth);
        } else {
          EXPECT_NEAR(p.depth, depth, 1e-9);
        }
        if (rule == Quadrature::reference) {
          EXPECT_LE(p.error, 2 * kTolerance);
        }
      }
    }
  }
}

// A ramp, f = z / L, a = A f, c = f, and a sheet at z = Z: the closed form of ClosedForm.RampMedium up to Z,
// and from Z on with what the sheet leaves.
TEST(Surfaces, BetweenPartsOfARamp) {
  constexpr double kLength = 2.5;
  const FunctionField field{[](const Vec3& p) { return p[2] / kLength; }, flat,
                            box_of(Vec3(-1, -1, 0), Vec3(2, 2, kLength))};
  for (const double top : {0.4, 0.99}) {
    const Scene scene =
        unlit(scene_of({{{0, Vec3(0, 0, 0)}, {1, Vec3(1, 1, 1)}}, {{0, 0}, {1, top}}}, 180, 0));  // along +z
    const double k = kLength / (scene.reference_length * top);
    const auto tau = [&](double f) { return k * (top * f + (1 - top * f) * std::log1p(-top * f)); };
    // Integral of c (-dT) from f0 to f1, T = 1 at f0, by parts.
    const auto emitted = [&](double f0, double f1) {
      const auto t = [&](double f) { return std::exp(tau(f0) - tau(f)); };
      return f0 - f1 * t(f1) + gauss_kronrod(t, f0, f1, 1e-14);
    };
    const Shot shot(field.box, scene);
    for (const double place : {0.2, 0.55, 0.83}) {
      for (const double b : {0.4, 1.0}) {
        const mesh::TriangleMesh mesh = sheet(shot.at(place), Vec3(0.1, 0.2, -1), 0.2);
        const mesh::MeshRays rays(mesh);
        Surfaces surfaces(scene);
        surfaces.add(rays, {kColour, b});
        const double e = std::exp(-tau(place));
        const double colour = emitted(0, place) + e * (b * kColour[0] + (1 - b) * emitted(place, 1));
        const double alpha = 1 - e * (1 - b) * std::exp(tau(place) - tau(1));
        // One interval of the transfer function and a linear field: preintegrated is exact at any step.
        for (const auto rule : {Quadrature::preintegrated, Quadrature::reference}) {
          const Pixel p = shot(hybrid_caster(view_of(field), scene, options_with(rule, 0.6), surfaces));
          EXPECT_NEAR(p.colour[0], colour, rule == Quadrature::reference ? kTolerance : 1e-12);
          EXPECT_NEAR(p.alpha, alpha, rule == Quadrature::reference ? kTolerance : 1e-12);
        }
        // The trapezoid keeps its order although no node of a uniform grid is at the sheet: the error falls
        // by 4 when the step halves; between 3.3 and 5 leaves room for the last, shorter segments.
        const auto error = [&](double step) {
          return std::abs(
              shot(hybrid_caster(view_of(field), scene, options_with(Quadrature::trapezoid, step), surfaces))
                  .colour[0] -
              colour);
        };
        const double ratio = error(kLength / 80) / error(kLength / 160);
        EXPECT_GT(ratio, 3.3) << top << ' ' << place << ' ' << b;
        EXPECT_LT(ratio, 5) << top << ' ' << place << ' ' << b;
      }
    }
  }
}

/// A transfer function of no opacity.
transfer::TransferFunction nothing() {
  return {{{0, Vec3(1, 1, 1)}}, {{0, 0}}};
}

// No medium: an opaque isosurface is isosurf-ray's picture bit by bit; a translucent one has its first hit
// and, in front of what is behind, all further ones.
TEST(Surfaces, WithoutAMediumAreTheIsosurfacesPicture) {
  Rng rng(31);
  const volume::Volume volume = random_volume(rng, {9, 8, 10});
  for (const bool perspective : {false, true}) {
    Scene scene = scene_of(nothing());
    if (perspective) scene.view.projection = camera::Projection::perspective;
    for (const auto kernel : {volume::Reconstruction::trilinear, volume::Reconstruction::b_spline}) {
      const IsosurfaceRays isosurface(volume, kernel, 0.3, false);
      const IsosurfaceImage own = draw_isosurface(isosurface, scene, kColour, 48, 40);
      RenderOptions options = options_with(Quadrature::trapezoid, 0.5);
      options.reconstruction = kernel;
      options.width = 48;
      options.height = 40;
      Surfaces opaque(scene);
      opaque.add(isosurface, {kColour, 1});
      const RenderResult drawn = raycast_with_surfaces(volume, scene, options, opaque);
      EXPECT_STREQ(drawn.caster, "plain");
      EXPECT_EQ(drawn.counts.surface_hits, own.counts.hits);
      EXPECT_GT(own.counts.hits, 300);
      constexpr double b = 0.375;
      Surfaces translucent(scene);
      translucent.add(isosurface, {kColour, b});
      const HybridCaster cast = hybrid_caster(volume, scene, options, translucent);
      const camera::Camera camera(scene.view, isosurface.bounds().centre(),
                                  isosurface.bounds().longest_edge(), 48, 40);
      const RayBox box(isosurface.bounds());
      const BlinnPhong light{Shading{}};
      for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 48; ++x) {
          for (int c = 0; c < 4; ++c) EXPECT_EQ(drawn.image.at(x, y, c), own.image.at(x, y, c));
          EXPECT_EQ(drawn.image.at(x, y, 5), own.image.at(x, y, 4));  // depth
          // Hit after hit, each on what is left of the chord behind the one before.
          const camera::Ray ray = camera.ray(x + 0.5, y + 0.5);
          auto chord = box.chord(ray, camera.t_min());
          if (!chord) continue;
          RenderCounts counts;
          const Pixel p = cast(ray, &*chord, counts);
          Vec3 colour = Vec3::Zero();
          double left = 1;
          IsosurfaceRays::Counts own_counts;
          for (int n = 0; n < 1000; ++n) {
            const auto hit = isosurface.first_hit(ray, *chord, own_counts);
            if (!hit) break;
            colour += left * b * light(-hit->normal, ray.direction)(kColour);
            left *= 1 - b;
            chord->entry = hit->t + 1e-9;  // rounding puts the hit itself on either side
            if (!(chord->entry < chord->exit)) break;
          }
          EXPECT_LT((p.colour - colour).norm(), 1e-7);
          EXPECT_NEAR(p.alpha, 1 - left, 1e-12);
        }
      }
    }
  }
}

/// Distance from the rim of a torus: slope 1 wherever its surface is.
volume::Volume torus() {
  volume::Grid<double> grid;
  grid.geometry.dims = {33, 35, 34};
  grid.geometry.spacing = {0.5, 0.47, 0.49};
  grid.voxels = Buffer<double>(static_cast<std::size_t>(grid.geometry.count()));
  for (std::int64_t k = 0; k < 34; ++k) {
    for (std::int64_t j = 0; j < 35; ++j) {
      for (std::int64_t i = 0; i < 33; ++i) {
        const Vec3 p =
            grid.geometry.index_to_world(Vec3(double(i), double(j), double(k))) - Vec3(8.1, 8.2, 8.05);
        grid(i, j, k) = 2.1 - std::hypot(std::hypot(p[0], p[1]) - 4.6, p[2]);
      }
    }
  }
  volume::Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

// In a medium of constant extinction a surface and its mesh, in place of one another, differ by no more than
// the medium over the chord error, measured along the rays: |dI| <= sigma |dt| for colours within 0 to 1.
TEST(Surfaces, TheMeshOfAnIsosurfaceStandsForIt) {
  const volume::Volume volume = torus();
  const auto mesh = isosurface::marching_cubes(volume, 0, {}).mesh;
  const mesh::MeshRays mesh_rays(mesh);
  const IsosurfaceRays isosurface(volume, volume::Reconstruction::trilinear, 0, false);
  Scene scene = unlit(scene_of(constant_transfer(0.1)));
  const RenderOptions options = options_with(Quadrature::trapezoid, 0.5);
  const double sigma = -std::log1p(-0.1) / scene.reference_length;
  const RayBox box(isosurface.bounds());
  const camera::Camera camera(scene.view, isosurface.bounds().centre(), isosurface.bounds().longest_edge(),
                              60, 60);
  for (const double b : {0.4, 1.0}) {
    Surfaces by_rays(scene), by_mesh(scene);
    by_rays.add(isosurface, {kColour, b});
    by_mesh.add(mesh_rays, {kColour, b});
    const HybridCaster ray_cast = hybrid_caster(volume, scene, options, by_rays);
    const HybridCaster mesh_cast = hybrid_caster(volume, scene, options, by_mesh);
    int same = 0, apart = 0;
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 60; ++x) {
        const camera::Ray ray = camera.ray(x + 0.5, y + 0.5);
        const auto chord = box.chord(ray, camera.t_min());
        if (!chord) continue;
        RenderCounts counts;
        std::vector<SurfaceHit> hits, others;
        by_rays.find(ray, &*chord, hits, counts);
        by_mesh.find(ray, &*chord, others, counts);
        if (hits.size() != others.size()) {
          ++apart;  // grazing
          continue;
        }
        if (hits.empty()) continue;
        ++same;
        double distance = 0;
        for (std::size_t n = 0; n < hits.size(); ++n) distance += std::abs(hits[n].t - others[n].t);
        const Pixel p = ray_cast(ray, &*chord, counts);
        const Pixel q = mesh_cast(ray, &*chord, counts);
        EXPECT_LE(difference(p, q), sigma * distance + 1e-12);
        // A chord of length h on a circle of radius 2.1 is h^2 / 8 / 2.1 off it, h up to 0.85, a cell's
        // diagonal; twice that for the trilinear surface, which is off it as well; along a ray more by its
        // slope.
        IsosurfaceRays::Counts own;
        const double slope = std::abs(isosurface.first_hit(ray, *chord, own)->normal.dot(ray.direction));
        if (slope > 0.3) {
          EXPECT_LE(std::abs(hits[0].t - others[0].t) * slope, 2 * 0.043);
        }
      }
    }
    EXPECT_GT(same, 300);
    EXPECT_LT(apart, 40);
  }
}

// A mesh beside the volume and in front of it, the eye between: what is behind the eye is not seen.
TEST(Surfaces, MeshesReachBeyondTheVolume) {
  const FunctionField field{[](const Vec3&) { return 3.0; }, flat, box_of(Vec3(-1, -1, -1), Vec3(2, 2, 2))};
  Scene scene = unlit(scene_of(constant_transfer(0.3), 0, 0));  // along -z
  const mesh::TriangleMesh plane = sheet(Vec3(0, 0, 3), Vec3(0, 0, 1), 10);
  const mesh::MeshRays rays(plane);
  RenderOptions options = options_with(Quadrature::trapezoid, 0.5);
  options.width = 20;
  options.height = 20;
  Surfaces surfaces(scene);
  surfaces.add(rays, {kColour, 1});
  const RenderResult whole = raycast_with_surfaces(view_of(field), scene, options, surfaces);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      EXPECT_EQ(whole.image.at(x, y, 0), static_cast<float>(kColour[0]));
      EXPECT_EQ(whole.image.at(x, y, 3), 1);
    }
  }
  scene.view.projection = camera::Projection::perspective;
  scene.view.distance = 2.5;  // between the plane and the volume
  scene.view.fov = 90;        // the volume is not all of the picture
  Surfaces behind(scene);
  behind.add(rays, {kColour, 1});
  const RenderResult none = raycast_with_surfaces(view_of(field), scene, options, behind);
  EXPECT_EQ(none.counts.surface_hits, 0);
  EXPECT_TRUE(same_bits(none.image, raycast_plain(field, scene, options).image));
  EXPECT_EQ(none.image.at(0, 0, 3), 0);
}

TEST(Surfaces, WhatIsNoSurfaceIsRefused) {
  Scene scene = scene_of(nothing());
  const mesh::TriangleMesh plane = sheet(Vec3(0, 0, 0), Vec3(0, 0, 1), 1);
  const mesh::MeshRays rays(plane);
  Surfaces surfaces(scene);
  EXPECT_THROW(surfaces.add(rays, {Vec3(0, 0, 2), 1}), Error);
  EXPECT_THROW(surfaces.add(rays, {Vec3(0, 0, 1), -0.1}), Error);
  EXPECT_THROW(surfaces.add(rays, {Vec3(0, 0, 1), std::nan("")}), Error);
  scene.model = Model::mip;
  EXPECT_THROW(Surfaces{scene}, Error);
}

}  // namespace
}  // namespace vol::render
