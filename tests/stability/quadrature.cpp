#include "render/quadrature.h"

#include <sstream>

#include "kernels.h"
#include "media.h"
#include "render/packet.h"

// The plain casters' rules of quadrature, ray by ray, in media whose integrals are known.
namespace vol::stability {
namespace {

struct OneRay {
  camera::Ray ray;
  TrueChord chord;
};
OneRay ray_of(const volume::FieldBounds& bounds, const render::Scene& scene, double x, double y) {
  const camera::Camera camera(scene.view, bounds.centre(), bounds.longest_edge(), 100, 100);
  const camera::Ray ray = camera.ray(x, y);
  return {ray, true_chord(bounds.corner, bounds.edges.diagonal(), ray, camera.t_min())};
}

/// n segments of 16 roundings each, and the chord's own uncertainty: relative, of the depth and so of alpha.
double homogeneous_bound(const TrueChord& chord, double n) {
  return kDouble * (16 * n + 64 + 8 * chord.condition / static_cast<double>(chord.length));
}

struct Medium {
  double opacity, reference_length;
};
/// Optical depths from 1e-306 to 1e6 along 3 to 6 lengths, by small and large opacities alike.
const Medium kMedia[] = {{std::numeric_limits<double>::min(), 1},
                         {1e-30, 2},
                         {1e-8, 1},
                         {0.5, 1e8},
                         {0.5, 1},
                         {0.9, 1e-2},
                         {0.5, 2e-6},
                         {1 - 1e-9, 50},
                         {1 - 0x1p-53, 1},
                         {1 - 0x1p-53, 1e-4}};

void homogeneous(Table& table) {
  const auto volume = half({3, 4, 5}, {0.7, 1.1, 0.9});
  const auto bounds = volume::field_bounds(volume.geometry());
  for (const Rule& rule : kStepped) {
    Worst alpha, depth;
    for (const Medium& medium : kMedia) {
      render::Scene scene = render::scene_of(render::constant_transfer(medium.opacity));
      scene.reference_length = medium.reference_length;
      const OneRay one = ray_of(bounds, scene, 48.3, 51.4);
      for (const double step : {1e-3, 0.037, 0.5, 10 * static_cast<double>(one.chord.length)}) {
        render::RenderOptions options;
        options.quadrature = rule.quadrature;
        options.step = step;
        const auto pixel =
            render::cast(render::plain_caster(volume, scene, options), bounds, scene, 48.3, 51.4);
        const Real truth = true_alpha(medium.opacity, medium.reference_length, one.chord.length);
        const double bound = homogeneous_bound(one.chord, nodes(one.chord, step));
        const auto relative = [&](double x, Real t) {
          return static_cast<double>(std::abs(x - t) /
                                     (std::abs(t) + static_cast<Real>(std::numeric_limits<double>::min())));
        };
        alpha.add(relative(pixel.alpha, truth), bound);
        for (int c = 0; c < 3; ++c)
          alpha.add(relative(pixel.colour[c], truth * static_cast<Real>(kColour[c])), bound);
        const Real way = -std::log(static_cast<Real>(2)) * static_cast<Real>(medium.reference_length) /
                         -std::log1p(-static_cast<Real>(medium.opacity));
        if (-way < 0.999L * one.chord.length) {
          const Real at = static_cast<Real>(one.chord.entry) - way;
          depth.add(static_cast<double>(std::abs(pixel.depth - at)),
                    bound * static_cast<double>(-2 * way) +
                        8 * kDouble * (one.chord.condition + std::abs(one.chord.entry)));
        }
      }
    }
    table.row("homogeneous, depth 1e-306 to 1e6, steps 1e-3 to ten times the volume", rule.name, "double",
              alpha, "any rule is exact: 16 roundings a segment, those of the chord");
    table.row("where transmittance is 0.5 in these", rule.name, "double", depth,
              "the same, over the extinction");
  }
}

/// The field runs from 0 to 1 along the ray's way back, opacity with it: s = -log(1 - a v)/reference.
void ramps(Table& table) {
  const auto volume = grid({3, 3, 5}, {1, 1, 1}, [](const Dims& at) { return double(at[2]) / 4; });
  const auto bounds = volume::field_bounds(volume.geometry());
  Worst exact, trapezoid, rectangle, reference;
  for (const double a : {0.1, 0.5, 0.99}) {
    for (const double reference_length : {0.01, 1.0, 1e3}) {
      const transfer::TransferFunction ramp{{{0, Vec3(0, 0, 0)}, {1, Vec3(1, 1, 1)}}, {{0, 0}, {1, a}}};
      render::Scene scene = render::scene_of(ramp, 0, 0);
      scene.reference_length = reference_length;
      const Real r = 4 / static_cast<Real>(reference_length);
      const auto depth = [&](Real u) {  // from the value 1 on
        const Real from = 1 - static_cast<Real>(a), to = from + static_cast<Real>(a) * u;
        return r * (u + (from * std::log(from) - to * std::log(to)) / static_cast<Real>(a));
      };
      const Real alpha = -std::expm1(-depth(1));
      const Real light = tanh_sinh([&](Real u, Real v) {
        return v * r * -std::log(1 - static_cast<Real>(a) * v) * std::exp(-depth(u));
      });
      const double steepest = -std::log1p(-a) / reference_length,
                   bend = std::pow(a / (1 - a) / 4, 2) / reference_length;
      for (const double step : {1e-3, 0.037, 0.7, 40.0}) {
        render::RenderOptions options;
        options.step = step;
        const double n = std::max(1.0, std::ceil(4 / step));
        const auto cast = [&](Quadrature quadrature) {
          options.quadrature = quadrature;
          return render::cast(render::plain_caster(volume, scene, options), bounds, scene);
        };
        const auto pre = cast(Quadrature::preintegrated);
        exact.add(static_cast<double>(std::abs(pre.alpha - alpha)), n * (1e-13 + 16 * kDouble));
        exact.add(static_cast<double>(std::abs(pre.colour[0] - light)), n * (1e-13 + 16 * kDouble));
        const double h = std::min(step, 4.0);
        trapezoid.add(static_cast<double>(std::abs(cast(Quadrature::trapezoid).alpha - alpha)),
                      h * h / 12 * 4 * bend + 16 * n * kDouble);
        rectangle.add(static_cast<double>(std::abs(cast(Quadrature::rectangle).alpha - alpha)),
                      h * steepest + 16 * n * kDouble);
      }
      render::RenderOptions options;
      options.tolerance = 1e-12;
      const auto truth = render::cast(render::reference_caster(volume, scene, options), bounds, scene);
      reference.add(static_cast<double>(std::abs(truth.alpha - alpha)), 1e-12);
      reference.add(static_cast<double>(std::abs(truth.colour[0] - light)), 1e-12);
    }
  }
  const char* what = "opacity ramps 0 to 0.99, depths 1e-4 to 1e3, steps 1e-3 to ten times the volume";
  table.row(what, "preintegrated", "double", exact,
            "exact: 1e-13 a segment, by adaptive quadrature, and 16 roundings");
  table.row(what, "trapezoid", "double", trapezoid, "h^2/12 L max|s''| of the depth");
  table.row(what, "rectangle", "double", rectangle, "h (max s - min s) of the depth: s is monotone");
  table.row(what, "reference", "double", reference, "its tolerance 1e-12");
}

/// Steps as short as there may be nodes.
void steps(Table& table) {
  const auto volume = half({2, 2, 2}, {1, 1, 1});
  const auto bounds = volume::field_bounds(volume.geometry());
  const render::Scene scene = render::scene_of(render::constant_transfer(0.4), 0, 0);
  const OneRay one = ray_of(bounds, scene, 50.5, 50.5);
  for (const Rule& rule : kStepped) {
    render::RenderOptions options;
    options.quadrature = rule.quadrature;
    options.step = 1e-6;
    const auto pixel = render::cast(render::plain_caster(volume, scene, options), bounds, scene, 50.5, 50.5);
    const Real truth = true_alpha(0.4, scene.reference_length, one.chord.length);
    table.row("step 1e-6 of the volume", rule.name, "double",
              static_cast<double>(std::abs(pixel.alpha - truth) / truth), homogeneous_bound(one.chord, 1e6),
              "16 roundings a segment");
  }
  render::RenderOptions options;
  options.width = options.height = 3;
  options.step = 1e-12;
  table.refusal("step 1e-12 of the volume", "trapezoid", "double",
                [&] { (void)render::raycast_plain(volume, scene, options); });
  table.refusal("step 1e-12 of the volume", "trapezoid, packets", "float",
                [&] { (void)render::raycast_packet(volume, scene, options); });
  options.step = 0;
  table.refusal("step 0", "trapezoid", "double",
                [&] { (void)render::raycast_plain(volume, scene, options); });
}

}  // namespace

void quadrature(Table& table) {
  homogeneous(table);
  steps(table);
  ramps(table);
}

}  // namespace vol::stability
