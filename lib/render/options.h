#pragma once
#include <optional>

#include "base/vec.h"
#include "camera/camera.h"
#include "transfer/transfer_function.h"
#include "volume/field_sampler.h"

namespace vol::render {

/// composite: emission-absorption after Max 1995, I = integral of c sigma_t T ds, T = exp(-integral sigma_t).
/// xray: integral of f, in value times world length. mip: the largest f met.
enum class Model { composite, xray, mip };

/// rectangle: a segment's left node, order 1. trapezoid: both nodes, extinction linear between them and
/// colour their mean weighted by extinction, (s0 c0 + s1 c1) / (s0 + s1), order 2: the emission c sigma_t is
/// then a linear function too, its error is 10 to 30 times smaller (MSE) than with the plain mean, and an
/// invisible node contributes nothing. preintegrated: both nodes, the field linear between them, order 2.
/// split: cell by cell, the field's polynomial along the ray cut where it crosses the transfer function's
/// points, `nodes` Gauss nodes on each smooth piece; steps play no part. reference: adaptive per cell to a
/// tolerance, which is the truth that errors are measured against.
enum class Quadrature { rectangle, trapezoid, preintegrated, split, reference };

/// Blinn-Phong; gradients are counted apart from samples.
struct Shading {
  double ambient = 0.2;
  double diffuse = 0.7;
  double specular = 0.1;
  double exponent = 10;
  std::optional<Vec3> light;  ///< world direction toward the light; none: a headlight at the viewer
};

/// What is drawn: the part of a picture's definition that a scene file holds.
struct Scene {
  camera::View view;
  transfer::TransferFunction transfer;
  double reference_length = 0;  ///< world length the opacities are for; 0: the field's smallest spacing
  std::optional<Shading> shading;
  Vec3 background{0, 0, 0};
  Model model = Model::composite;
};

/// How it is drawn: what trades time for error.
struct RenderOptions {
  int width = 512;
  int height = 512;
  Quadrature quadrature = Quadrature::trapezoid;
  volume::Reconstruction reconstruction = volume::Reconstruction::trilinear;
  double step = 0.5;  ///< world length between nodes t_i = t_entry + i step
  /// Trapezoid, composite: `step` is the longest, and shorter ones are taken where a segment could change a
  /// pixel by more, and in shaded scenes where it adds more to one than is known (step_control.h); 0: all
  /// steps are the same.
  double step_tolerance = 0;
  int nodes = 3;  ///< split: Gauss nodes a piece, 1 to 3
  /// Split: halve pieces until each ray's estimate of its own error, on the colour scale, is below; 0: fixed
  /// pieces.
  double max_error = 0;
  double tolerance = 1e-10;  ///< reference quadrature: absolute error of a pixel, on the colour scale
  double termination = 0;    ///< stop a ray once its transmittance is at most this; 0 for truth
  int image_step = 1;        ///< rays at every so many pixels, and where these do not suffice (refinement.h)
  double image_tolerance = 1e-3;  ///< by how much interpolation may miss a ray, in units of the channels
  bool skip_empty = true;         ///< do not sample what the transfer function makes invisible
};

struct RenderCounts {
  std::int64_t rays = 0;     ///< rays that meet the field's box
  std::int64_t samples = 0;  ///< reconstructions of f; split: cells and Gauss nodes
  std::int64_t gradients = 0;
  std::int64_t skipped = 0;       ///< nodes not sampled because nothing around them is visible; split: leaps
  std::int64_t terminated = 0;    ///< rays that `termination` ends in the medium; not at a surface
  std::int64_t surface_hits = 0;  ///< surfaces met in front of what is opaque
  std::int64_t surface_undecided = 0;  ///< one a ray and isosurface, or splats, that it may touch

  RenderCounts& operator+=(const RenderCounts& other) {
    rays += other.rays;
    samples += other.samples;
    gradients += other.gradients;
    skipped += other.skipped;
    terminated += other.terminated;
    surface_hits += other.surface_hits;
    surface_undecided += other.surface_undecided;
    return *this;
  }
};

}  // namespace vol::render
