#include "render/raycast.h"

#include <sstream>

#include "kernels.h"
#include "media.h"
#include "render/packet.h"

// Pictures by all casters, plain ones in double, packets and split in float: views, sizes and values at their
// extremes.
namespace vol::stability {
namespace {

/// A picture against closed forms, pixel by pixel.
void pictures(Table& table, const std::string& what, const camera::View& view, const volume::Volume& volume,
              double opacity, double step) {
  render::Scene scene = render::scene_of(render::constant_transfer(opacity));
  scene.view = view;
  const auto bounds = volume::field_bounds(volume.geometry());
  render::RenderOptions options;
  options.width = 29;
  options.height = 23;
  options.step = step;
  options.tolerance = 1e-12;
  const camera::Camera camera(view, bounds.centre(), bounds.longest_edge(), options.width, options.height);
  const auto draw = [&](const render::RenderResult& result, double tolerance, double a_node, Worst& worst) {
    for (int y = 0; y < options.height; ++y) {
      for (int x = 0; x < options.width; ++x) {
        const auto ray = camera.ray(x + 0.5, y + 0.5);
        const auto chord = true_chord(bounds.corner, bounds.edges.diagonal(), ray, camera.t_min());
        const auto truth = static_cast<double>(true_alpha(opacity, scene.reference_length, chord.length));
        // What positions may add to the chord; alpha moves by no more than the depth does. An opaque medium
        // is seen wherever there is a chord at all.
        const double ends = 8 * kDouble * std::max(chord.condition, bounds.corner.norm() + ray.origin.norm());
        if (opacity == 1 && static_cast<double>(chord.length) < ends) continue;
        const double moved = opacity == 1 ? 0 : ends / scene.reference_length * -std::log1p(-opacity);
        const double bound = tolerance + a_node * nodes(chord, step) + moved + kFloat * truth;
        worst.add(std::abs(result.image.at(x, y, 3) - truth), bound);
        for (int c = 0; c < 3; ++c) worst.add(std::abs(result.image.at(x, y, c) - kColour[c] * truth), bound);
      }
    }
  };
  Worst plain, packets, split, reference;
  for (const Rule& rule : kStepped) {
    options.quadrature = rule.quadrature;
    draw(render::raycast_plain(volume, scene, options), 64 * kDouble, 16 * kDouble, plain);
    draw(render::raycast_packet(volume, scene, options), render::packet_tolerance(0), 1e-8, packets);
  }
  options.quadrature = Quadrature::split;
  draw(render::raycast_packet(volume, scene, options), 2e-5, 0, split);
  options.quadrature = Quadrature::reference;
  draw(render::raycast_reference(volume, scene, options), options.tolerance, 0, reference);
  table.row(what, "three stepped rules", "double", plain,
            "16 roundings a segment, 8 of positions, pixel in float");
  table.row(what, "three stepped rules, packets", "float", packets,
            "packet_tolerance(nodes) = 2e-6 + 1e-8 nodes");
  table.row(what, "split, packets", "float", split, "2e-5, as packet.h states");
  table.row(what, "reference", "double", reference, "its tolerance 1e-12");
}

void views(Table& table) {
  const auto volume = half({3, 4, 5}, {0.7, 1.1, 0.9});
  camera::View askew;
  askew.azimuth = 25;
  askew.elevation = -35;
  camera::View aligned;
  aligned.width = 2.9;  // a voxel is 7 pixels across
  pictures(table, "optical depth 1e6", askew, volume, 1 - 0x1p-53, 0.5);
  pictures(table, "opacity 1e-8 a length", askew, volume, 1e-8, 0.05);
  pictures(table, "opacity 1", askew, volume, 1, 0.3);
  pictures(table, "opacity 0", askew, volume, 0, 0.3);
  pictures(table, "along an axis, rays on voxel planes", aligned, volume, 0.4, 0.1);
  pictures(table, "spacing ratio 1e4", askew, half({4, 3, 5}, {1e-2, 1, 100}), 0.4, 0.7);
  pictures(table, "1 x 1 x 4096", askew, half({1, 1, 4096}, {1, 1, 1}), 0.1, 1);
  pictures(table, "2 x 3 x 1", askew, half({2, 3, 1}, {1, 1, 1}), 0.4, 0.1);
  pictures(table, "primes 31 x 7 x 13", askew, half({31, 7, 13}, {1, 1, 1}), 0.1, 1);
  askew.projection = camera::Projection::perspective;
  for (const double fov : {0.01, 30.0, 179.0}) {
    askew.fov = fov;
    std::ostringstream what;
    what << "field of view " << fov;
    pictures(table, what.str(), askew, volume, 0.4, 0.1);
  }
  askew.fov = 90;
  askew.distance = 0.6;
  pictures(table, "camera inside the volume", askew, volume, 0.4, 0.1);
  askew.azimuth = askew.elevation = 0;
  pictures(table, "camera inside, on a voxel plane, along an axis", askew, volume, 0.4, 0.1);
}

/// A picture depends on values only through the transfer function: scale or shift both, and it stays.
void values(Table& table) {
  const volume::Volume volume = render::generic_volume();
  const auto bounds = volume::field_bounds(volume.geometry());
  const double slope = 2.0 / 3, most = 0.4;
  const transfer::TransferFunction base{{{0.1, Vec3(0, 0, 0)}, {0.9, Vec3(1, 0.5, 0.2)}},
                                        {{0.2, 0}, {0.8, most}}};
  const render::Scene scene = render::scene_of(base);
  for (const auto& [what, scale, shift] : {std::tuple{"values of 1e30", 1e30, 0.0},
                                           {"values of 1e-30", 1e-30, 0.0},
                                           {"signal 1 on 1e8", 1.0, 1e8}}) {
    volume::Volume other = volume;
    for (auto& v : std::get<volume::Grid<double>>(other.grid).voxels) v = v * scale + shift;
    auto colours = base.colours();
    auto opacities = base.opacities();
    for (auto& p : colours) p.value = p.value * scale + shift;
    for (auto& p : opacities) p.value = p.value * scale + shift;
    const render::Scene same = render::scene_of({colours, opacities});
    const double length = render::chord_length(bounds, scene);
    // A value is off by 8 roundings, a reconstruction's and the points'; colour (slope 1.25) moves with it.
    const double moved =
        8 * kDouble * (1 + shift / scale) * (length / scene.reference_length * slope / (1 - most) + 1.25);
    for (const Rule& rule : kStepped) {
      render::RenderOptions options;
      options.quadrature = rule.quadrature;
      const double error =
          render::difference(render::cast(render::plain_caster(other, same, options), bounds, same),
                             render::cast(render::plain_caster(volume, scene, options), bounds, scene));
      // Both pictures' adaptive quadrature is good to 1e-13 a segment.
      const bool adaptive = rule.quadrature == Quadrature::preintegrated;
      const double segment = adaptive ? 2e-13 : 16 * kDouble;
      table.row(what, rule.name, "double", error, moved + segment * length / options.step,
                adaptive ? "8 roundings of a value times slope and chord; 2e-13 a segment, by adaptive "
                           "quadrature of both"
                         : "8 roundings of a value times slope and chord, 16 a segment");
    }
    render::RenderOptions options;
    options.width = 21;
    options.height = 17;
    const auto plain = render::raycast_plain(volume, scene, options),
               packets = render::raycast_packet(other, same, options);
    Worst worst;
    for (int y = 0; y < options.height; ++y) {
      for (int x = 0; x < options.width; ++x) {
        for (int c = 0; c < 4; ++c) {
          worst.add(std::abs(double(plain.image.at(x, y, c)) - double(packets.image.at(x, y, c))),
                    render::packet_tolerance(plain.image.at(x, y, 4)) + moved);
        }
      }
    }
    table.row(what, std::string("trapezoid, ") + packets.caster, "float", worst,
              "packet_tolerance(nodes) and as above");
  }
  volume::Volume bad = volume;
  std::get<volume::Grid<double>>(bad.grid).voxels[5] = std::nan("");
  table.refusal("NaN in the volume", "trapezoid", "double",
                [&] { (void)render::raycast_plain(bad, scene, {}); });
  table.refusal("NaN in the volume", "trapezoid, packets", "float",
                [&] { (void)render::raycast_packet(bad, scene, {}); });
  table.refusal("NaN in the volume", "reference", "double",
                [&] { (void)render::raycast_reference(bad, scene, {}); });
}

/// X-ray along z through the voxels themselves: the trapezoid rule of a row, for the trilinear field exactly.
void xrays(Table& table) {
  for (const auto& [what, dims, scale, shift] :
       {std::tuple{"xray on voxel columns, values 1e30", Dims{4, 3, 9}, 1e30, 0.0},
        {"xray on voxel columns, values 1e-30", Dims{4, 3, 9}, 1e-30, 0.0},
        {"xray on voxel columns, signal 1 on 1e8", Dims{4, 3, 9}, 1.0, 1e8},
        {"xray on the column of 1 x 1 x 4096", Dims{1, 1, 4096}, 1.0, 0.0}}) {
    Rng rng(3);
    const auto volume =
        grid(dims, {1, 1, 1}, [&](const Dims&) { return rng.uniform(-1, 1) * scale + shift; });
    const auto& voxels = std::get<volume::Grid<double>>(volume.grid);
    const auto bounds = volume::field_bounds(volume.geometry());
    Worst stepped, reference;
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        render::Scene scene = render::scene_of(render::constant_transfer(0.4), 0, 0);
        scene.model = render::Model::xray;
        scene.view.target = volume.geometry().index_to_world({double(i), double(j), 0});
        Real truth = 0, size = 0;
        for (std::int64_t k = 0; k < dims[2]; ++k) {
          const Real share = (k == 0 || k == dims[2] - 1) ? 0.5L : 1;
          truth += share * static_cast<Real>(voxels(i, j, k));
          size += share * static_cast<Real>(std::abs(voxels(i, j, k)));
        }
        for (const Rule& rule : kStepped) {
          if (rule.quadrature == Quadrature::rectangle) continue;
          render::RenderOptions options;
          options.quadrature = rule.quadrature;
          options.step = 1;
          const auto pixel =
              render::cast(render::plain_caster(volume, scene, options), bounds, scene, 50, 50);
          stepped.add(static_cast<double>(std::abs(pixel.colour[0] - truth) / size),
                      gamma(8 * double(dims[2]) + 64, kDouble));
        }
        const auto pixel = render::cast(render::reference_caster(volume, scene, {}), bounds, scene, 50, 50);
        reference.add(static_cast<double>(std::abs(pixel.colour[0] - truth) / size),
                      gamma(8 * double(dims[2]) + 64, kDouble));
      }
    }
    table.row(what, "trapezoid, preintegrated", "double", stepped,
              "gamma_(8n+64) of the magnitudes: n sums, positions to n roundings");
    table.row(what, "reference", "double", reference,
              "gamma_(8n+64) of the magnitudes: n sums, positions to n roundings");
  }
  const auto huge = grid({30, 30, 30}, {1, 1, 1}, [](const Dims&) { return 3e38; });
  render::Scene scene = render::scene_of(render::constant_transfer(0.4));
  scene.model = render::Model::xray;
  table.refusal("xray of values 3e38", "trapezoid", "float pixel",
                [&] { (void)render::raycast_plain(huge, scene, {}); });
}

}  // namespace

void raycast(Table& table) {
  values(table);
  xrays(table);
  views(table);
}

}  // namespace vol::stability
