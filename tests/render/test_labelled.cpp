// Labels in pictures against closed forms, an integral by separate code, and the plain caster.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/error.h"
#include "base/rng.h"
#include "render/raycast.h"
#include "render/surfaces.h"
#include "transfer/opacity.h"
#include "volume/grid_sampler.h"
#include "volume/labels.h"

namespace vol::render {
namespace {

using Labels = volume::Grid<std::uint8_t>;

volume::GridGeometry geometry_of(const Dims& dims) {
  volume::GridGeometry g;
  g.dims = dims;
  g.spacing = {0.5, 1.25, 0.75};
  g.origin = {-3, 7, 2};
  return g;
}

volume::Volume values(const Dims& dims) {
  volume::Volume volume = volume::allocate(volume::VoxelType::f32, geometry_of(dims));
  Rng rng(5);
  for (auto& v : std::get<volume::Grid<float>>(volume.grid).voxels) v = static_cast<float>(rng.uniform());
  return volume;
}

Labels labels(const Dims& dims, const std::function<int(std::int64_t, std::int64_t, std::int64_t)>& label) {
  volume::Volume volume = volume::allocate(volume::VoxelType::u8, geometry_of(dims));
  auto& grid = std::get<Labels>(volume.grid);
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) grid(i, j, k) = static_cast<std::uint8_t>(label(i, j, k));
    }
  }
  return grid;
}

/// Looks along -z; opacities are for a spacing along z.
Scene along_z() {
  Scene scene;
  scene.transfer = {{{0, Vec3(0.1, 0.4, 0.9)}, {1, Vec3(0.9, 0.5, 0.2)}}, {{0, 0.05}, {1, 0.6}}};
  scene.reference_length = 0.75;
  scene.view.width = 2;
  return scene;
}

RenderOptions options_of(double step = 0.75) {
  RenderOptions options;
  options.width = options.height = 3;
  options.step = step;
  return options;
}

RenderResult drawn(const volume::Volume& volume, const Labels& of, const LabelStyle& style,
                   const Scene& scene, const RenderOptions& options) {
  const LabelledMedium medium(of, volume.geometry(), style);
  return raycast_plain(volume, scene, options, nullptr, &medium);
}

double at(const RenderResult& result, const char* channel) {
  return double(result.image.at(1, 1, result.image.channel(channel).value()));
}

const LabelLook kRed{Vec3(0.9, 0.2, 0.1), 0.1}, kBlue{Vec3(0.1, 0.3, 0.8), 0.3};
constexpr Dims kDims{7, 6, 9};

// Rays cross 8 spacings, that is 8 reference lengths. Pictures hold floats: 1e-6.
TEST(Labelled, OneLabelIsAConstantMedium) {
  const auto one = labels(kDims, [](auto...) { return 1; });
  for (const auto membership : {Membership::nearest, Membership::interpolated}) {
    const auto result =
        drawn(values(kDims), one, {{LabelLook{}, kRed}, membership}, along_z(), options_of(0.31));
    const double alpha = 1 - std::pow(0.9, 8);
    EXPECT_NEAR(at(result, "A"), alpha, 1e-6);
    EXPECT_NEAR(at(result, "R"), alpha * 0.9, 1e-6);
    EXPECT_NEAR(at(result, "B"), alpha * 0.1, 1e-6);
    // From an opaque label's front, the depth at which half the light is gone.
    const auto front = drawn(values(kDims), one, {{LabelLook{}, {Vec3::Ones(), 1}}}, along_z(), options_of());
    EXPECT_NEAR(at(result, "depth") - at(front, "depth"), 0.75 * std::log(0.5) / std::log(0.9), 1e-5);
  }
}

// Nearest: the border is halfway between samples 3 and 4, seen from the back 3.5 spacings of red behind 4.5
// of blue. Interpolated: opacity runs linearly from one to the other over one spacing; the trapezoid rule at
// a step of 1/150 spacing is off by (1/150)^2 / 12 of the change of the extinction's slope, 0.3: 1e-6.
TEST(Labelled, TwoSlabs) {
  const auto slabs = labels(kDims, [](auto, auto, auto k) { return k >= 4 ? 1 : 0; });
  const double front = 1 - std::pow(0.7, 4.5), behind = std::pow(0.7, 4.5) * (1 - std::pow(0.9, 3.5));
  LabelStyle style{{kRed, kBlue}, Membership::nearest};
  const auto nearest = drawn(values(kDims), slabs, style, along_z(), options_of(0.0005));
  EXPECT_NEAR(at(nearest, "A"), front + behind, 1e-3);  // a step, 1/1500 spacing, may see either side
  EXPECT_NEAR(at(nearest, "R"), 0.1 * front + 0.9 * behind, 1e-3);
  style.membership = Membership::interpolated;
  const double depth = -4 * std::log(0.7) - 3 * std::log(0.9) + transfer::mean_ramp_depth(0.3, 0.1);
  EXPECT_NEAR(at(drawn(values(kDims), slabs, style, along_z(), options_of(0.005)), "A"), -std::expm1(-depth),
              3e-6);
}

// A pair of steps passes where its estimate, three times its error in a smooth medium, is below the
// tolerance, or where no shorter steps are left: shares have kinks at cells' faces. Allowed are half a
// tolerance a sample and what the shortest steps err by, a 16th of `step`; the truth has steps of 1/750
// spacing.
TEST(Labelled, AdaptiveStepsKeepTheirTolerancesAndAreFewer) {
  Rng rng(8);
  const auto some = labels(kDims, [&](auto...) { return static_cast<int>(3 * rng.uniform()); });
  const auto volume = values(kDims);
  const LabelStyle style{{LabelLook{}, kRed, {Vec3(0.1, 0.3, 0.8), 0.8}}, Membership::interpolated};
  Scene scene = along_z();
  scene.view.azimuth = 33;
  scene.view.elevation = 21;
  for (const bool shaded : {false, true}) {
    SCOPED_TRACE(shaded);
    if (shaded) scene.shading = Shading{};
    const auto truth = drawn(volume, some, style, scene, options_of(0.001));
    RenderOptions options = options_of(0.75);
    const auto uniform = drawn(volume, some, style, scene, options);
    options.step_tolerance = 1e-3;
    const auto adaptive = drawn(volume, some, style, scene, options);
    const auto shortest = drawn(volume, some, style, scene, options_of(0.75 / 16));
    double rough = 0, error = 0, least = 0;
    for (const char* channel : {"R", "G", "B", "A"}) {
      rough = std::max(rough, std::abs(at(uniform, channel) - at(truth, channel)));
      error = std::max(error, std::abs(at(adaptive, channel) - at(truth, channel)));
      least = std::max(least, std::abs(at(shortest, channel) - at(truth, channel)));
    }
    EXPECT_LE(error, least + 0.5e-3 * at(adaptive, "samples"));
    EXPECT_LT(error, rough / 2) << "steps follow the labels";
    EXPECT_LT(adaptive.counts.samples, truth.counts.samples / 20);
  }
}

// The definition by other code: shares from the labels' indicators, light summed in 40,000 steps of their
// midpoints, which is off by less than 1e-6; so is the cast at a step of 1/300 spacing.
TEST(Labelled, InterpolatedIsItsDefinition) {
  Rng rng(3);
  const auto some = labels(kDims, [&](auto...) { return static_cast<int>(4 * rng.uniform()); });
  const auto volume = values(kDims);
  const LabelStyle style{
      {kRed, LabelLook{}, kBlue, {Vec3(0.2, 0.9, 0.4), 0.6}}, Membership::interpolated, true};
  Scene scene = along_z();
  scene.view.azimuth = 33;
  scene.view.elevation = 21;
  const auto result = drawn(volume, some, style, scene, options_of(0.0025));

  std::vector<volume::Volume> indicators;
  for (int l = 0; l < 4; ++l) indicators.push_back(volume::indicator(some, l));
  using Share = volume::GridSampler<std::uint8_t, volume::Reconstruction::trilinear>;
  std::vector<Share> shares;
  for (const auto& i : indicators) shares.emplace_back(std::get<Labels>(i.grid));
  const volume::GridSampler<float, volume::Reconstruction::trilinear> field(
      std::get<volume::Grid<float>>(volume.grid));
  const auto bounds = volume::field_bounds(volume.geometry());
  const camera::Camera camera(scene.view, bounds.centre(), bounds.longest_edge(), 3, 3);
  const camera::Ray ray = camera.ray(1.5, 1.5);
  const Chord chord = RayBox(bounds).chord(ray, camera.t_min()).value();
  constexpr int kSteps = 40000;
  const double h = chord.length() / kSteps;
  Vec3 light = Vec3::Zero();
  double depth = 0;
  for (int n = 0; n < kSteps; ++n) {
    const Vec3 p = ray.origin + (chord.entry + (n + 0.5) * h) * ray.direction;
    double opacity = 0;
    Vec3 colour = Vec3::Zero();
    for (std::size_t l = 0; l < 4; ++l) {
      const double a = shares[l].value(p) * style.looks[l].opacity;
      opacity += a;
      colour += a * style.looks[l].colour;
    }
    if (opacity > 0) colour /= opacity;
    opacity *= scene.transfer.opacity(field.value(p));
    const double own = -std::log1p(-opacity) * h / scene.reference_length;
    light +=
        std::exp(-depth) * -std::expm1(-own) * colour.cwiseProduct(scene.transfer.colour(field.value(p)));
    depth += own;
  }
  EXPECT_GT(depth, 0.1);
  EXPECT_NEAR(at(result, "A"), -std::expm1(-depth), 1e-5);
  EXPECT_NEAR(at(result, "R"), light[0], 1e-5);
  EXPECT_NEAR(at(result, "B"), light[2], 1e-5);
}

// A white label of opacity 1 leaves the value's own picture; shares sum to 1 within rounding.
TEST(Labelled, UnitLabelLeavesTheTransferFunction) {
  const auto volume = values(kDims);
  const auto some = labels(kDims, [](auto i, auto j, auto k) { return static_cast<int>((i + j + k) % 3); });
  const LabelLook unit{Vec3::Ones(), 1};
  Scene scene = along_z();
  scene.shading = Shading{};
  const auto plain = raycast_plain(volume, scene, options_of(0.2));
  for (const auto membership : {Membership::nearest, Membership::interpolated}) {
    const auto ours = drawn(volume, some, {{unit, unit, unit}, membership, true}, scene, options_of(0.2));
    for (const char* channel : {"R", "G", "B", "A"})
      EXPECT_NEAR(at(ours, channel), at(plain, channel), 1e-6) << channel;
  }
}

TEST(Labelled, UnlistedLabelsAreNotSeen) {
  const auto nine = labels(kDims, [](auto...) { return 9; });
  for (const bool times_transfer : {false, true}) {
    const LabelStyle style{{kRed, kBlue}, Membership::interpolated, times_transfer};
    const auto result = drawn(values(kDims), nine, style, along_z(), options_of());
    EXPECT_EQ(at(result, "A"), 0);
    EXPECT_EQ(at(result, "R"), 0);
    EXPECT_EQ(result.counts.samples, 0);
  }
}

TEST(Labelled, OpaqueLabelHidesAllBehind) {
  const auto slabs = labels(kDims, [](auto, auto, auto k) { return k >= 4 ? 1 : 0; });
  const auto result = drawn(values(kDims), slabs, {{kRed, {Vec3(0, 1, 0), 1}}}, along_z(), options_of());
  EXPECT_EQ(at(result, "A"), 1);
  EXPECT_EQ(at(result, "G"), 1);
  EXPECT_EQ(at(result, "R"), 0);
}

// What is left out adds nothing; where a node is on a macrocell's border, rounding decides whether it is
// taken.
TEST(Labelled, SkippingAndSurfacesChangeNothing) {
  const Dims dims{33, 29, 41};
  Rng rng(8);
  const auto few =
      labels(dims, [&](auto i, auto j, auto k) { return i > 20 && j < 9 && k % 16 < 5 ? 1 : 0; });
  const auto volume = values(dims);
  Scene scene = along_z();
  scene.view = {};
  scene.view.azimuth = 40;
  scene.view.elevation = 10;
  RenderOptions options = options_of(0.3);
  options.width = options.height = 24;
  const LabelledMedium medium(few, volume.geometry(), {{LabelLook{}, kBlue}});
  const auto skipped = raycast_plain(volume, scene, options, nullptr, &medium);
  EXPECT_GT(skipped.counts.skipped, skipped.counts.samples);
  const auto hybrid = raycast_with_surfaces(volume, scene, options, Surfaces(scene), nullptr, &medium);
  options.skip_empty = false;
  const auto all = raycast_plain(volume, scene, options, nullptr, &medium);
  EXPECT_EQ(all.counts.skipped, 0);
  double most = 0;
  for (std::size_t n = 0; n < all.image.pixels.size(); ++n) {
    if (n % 6 >= 4) continue;  // samples, depth
    most = std::max(most, double(all.image.pixels[n]));
    EXPECT_NEAR(all.image.pixels[n], skipped.image.pixels[n], 1e-7);
    EXPECT_NEAR(hybrid.image.pixels[n], skipped.image.pixels[n], 1e-7);
  }
  EXPECT_GT(most, 0.3);
}

TEST(Labelled, Refusals) {
  const auto volume = values(kDims);
  const auto good = labels(kDims, [](auto...) { return 0; });
  const volume::GridGeometry g = volume.geometry();
  EXPECT_THROW((void)volume::label_grid(volume), Error);  // fractions
  EXPECT_THROW((void)LabelledMedium(labels({7, 6, 8}, [](auto...) { return 0; }), g, {}), Error);
  EXPECT_THROW((void)LabelledMedium(good, g, {{{Vec3::Ones(), 1.5}}}), Error);
  EXPECT_THROW((void)LabelledMedium(good, g, {{{Vec3(-1, 0, 0), 0.5}}}), Error);
  auto mip = along_z();
  mip.model = Model::mip;
  EXPECT_THROW((void)drawn(volume, good, {{kRed}}, mip, options_of()), Error);
  auto other = options_of();
  other.quadrature = Quadrature::preintegrated;
  EXPECT_THROW((void)drawn(volume, good, {{kRed}}, along_z(), other), Error);
  other.quadrature = Quadrature::reference;
  const LabelledMedium medium(good, g, {{kRed}});
  const Scene scene = along_z();
  EXPECT_THROW((void)raycast_with_surfaces(volume, scene, other, Surfaces(scene), nullptr, &medium), Error);
}

}  // namespace
}  // namespace vol::render
