#include <gtest/gtest.h>

#include "base/error.h"
#include "direct.h"
#include "fourier/canny.h"
#include "fourier/models.h"
#include "fourier/projection.h"

namespace vol::fourier {
namespace {

using namespace fourier_test;

volume::GridGeometry square_pixels() {
  volume::GridGeometry g;
  g.dims = {17, 12, 15};
  g.spacing = Vec3(0.8, 0.8, 1.7);
  g.origin = Vec3(5, -2, 40);
  return g;
}

/// Noise with a hole of zeros, in which the gradient vanishes.
volume::Volume holed_noise() {
  auto f = white_noise(square_pixels(), 21);
  for (auto& v : f.voxels) v = std::abs(v);
  for (std::int64_t k = 5; k < 11; ++k) {
    for (std::int64_t j = 2; j < 8; ++j) {
      for (std::int64_t i = 4; i < 12; ++i) f(i, j, k) = 0;
    }
  }
  volume::Volume volume;
  volume.grid = f;
  return volume;
}

camera::Camera front_camera(const volume::GridGeometry& g) {
  camera::View view;
  view.width = g.spacing.x() * static_cast<double>(g.dims[0]);
  return {view, g.centre(), 1, static_cast<int>(g.dims[0]), static_cast<int>(g.dims[1])};
}

/// The model's picture from +z at the volume's own pixels.
std::vector<Picture> front(const volume::Volume& volume, const Model& model, const ChannelWeights& weights) {
  SpectrumInfo info;
  info.geometry = volume.geometry();
  info.padding = 1;
  info.padded = info.geometry.dims;
  info.model = model.name;
  info.names = model.spectra;
  const Filter filter("trilinear", 1);
  const auto source = slice_source(transform<double>(info, model.sources), filter.taps());
  Projector<double> projector(source, filter);
  const Dims& n = info.geometry.dims;
  const auto planes = projector.project(
      slice_view(info, front_camera(info.geometry), static_cast<int>(n[0]), static_cast<int>(n[1]), true),
      weights);
  std::vector<Picture> pictures;
  for (const auto& plane : planes) pictures.emplace_back(plane.begin(), plane.end());
  return pictures;
}

/// Sums along z of g(i, j, k), times world length, row 0 the largest y.
template <class G>
Picture sums(const volume::GridGeometry& geometry, const G& g) {
  Picture picture;
  const Dims& n = geometry.dims;
  for (std::int64_t j = n[1] - 1; j >= 0; --j) {
    for (std::int64_t i = 0; i < n[0]; ++i) {
      double sum = 0;
      for (std::int64_t k = 0; k < n[2]; ++k) sum += g(i, j, k);
      picture.push_back(sum * geometry.spacing.z());
    }
  }
  return picture;
}

constexpr double kRounding = 1e-12;  // of sums of a few dozen

TEST(Models, DepthCueIsTheSumOfTheCuedField) {
  const auto volume = holed_noise();
  const auto& f = std::get<volume::Grid<double>>(volume.grid);
  const auto& g = f.geometry;
  const auto weights = depth_cue_weights(front_camera(g), 1.4);
  const double half_diagonal = 0.5 * g.edge_lengths().norm();
  const auto truth = sums(g, [&](auto i, auto j, auto k) {
    const double z = g.origin.z() + double(k) * g.spacing.z() - g.centre().z();  // the viewer is at +z
    return f(i, j, k) * 0.7 * (1 + z / half_diagonal);
  });
  EXPECT_LT(largest_difference(front(volume, depth_cue_model(volume), {weights})[0], truth), kRounding);
}

TEST(Models, DirectionalLightIsTheSumOfTheLitField) {
  const auto volume = holed_noise();
  const auto& f = std::get<volume::Grid<double>>(volume.grid);
  const Dims& n = f.dims();
  const Vec3 light(1, -2, 0.5);
  const auto truth = sums(f.geometry, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const auto d = [](double low, double high, double steps) { return (high - low) / steps; };
    const std::int64_t i0 = i > 0 ? i - 1 : 0, i1 = i + 1 < n[0] ? i + 1 : i;
    const std::int64_t j0 = j > 0 ? j - 1 : 0, j1 = j + 1 < n[1] ? j + 1 : j;
    const std::int64_t k0 = k > 0 ? k - 1 : 0, k1 = k + 1 < n[2] ? k + 1 : k;
    const Vec3 gradient(d(f(i0, j, k), f(i1, j, k), double(i1 - i0) * 0.8),
                        d(f(i, j0, k), f(i, j1, k), double(j1 - j0) * 0.8),
                        d(f(i, j, k0), f(i, j, k1), double(k1 - k0) * 1.7));
    const Vec3 normal = gradient.norm() > 0 ? Vec3(-gradient / gradient.norm()) : Vec3::Zero();
    return f(i, j, k) * 0.5 * (1 + light.normalized().dot(normal));
  });
  EXPECT_LT(
      largest_difference(front(volume, directional_model(volume), {directional_weights(light)})[0], truth),
      kRounding);
  EXPECT_THROW((void)directional_weights(Vec3::Zero()), Error);
  for (const double length : {1e200, 1e-200, 5e-324, 1.7e308}) {  // lengths whose squares are no numbers
    EXPECT_EQ(directional_weights(Vec3(0, length, 0)), directional_weights(Vec3(0, 1, 0))) << length;
    EXPECT_EQ(directional_weights(Vec3(-length, length, 0)), directional_weights(Vec3(-1, 1, 0))) << length;
  }
}

TEST(Models, ControlPointsOfOneAreTheUnclassifiedProjection) {
  const auto volume = holed_noise();
  const auto& f = std::get<volume::Grid<double>>(volume.grid);
  const auto scaled = [&](auto i, auto j, auto k) {
    return std::clamp((f(i, j, k) - 0.2) / (1.5 - 0.2), 0.0, 1.0);
  };
  for (const int n : {1, 2, 6, 16, 21}) {
    const auto model = bezier_model(volume, n, {0.2, 1.5});
    const std::vector<double> ones(static_cast<std::size_t>(n), 1.0);
    EXPECT_LT(largest_difference(front(volume, model, {ones})[0], sums(f.geometry, scaled)), kRounding) << n;
  }
  // And any others are v B(v), by de Casteljau.
  const std::vector<double> points{0.1, 0, 2, -0.5, 1, 0.7};
  const auto truth = sums(f.geometry, [&](auto i, auto j, auto k) {
    auto b = points;
    const double v = scaled(i, j, k);
    for (std::size_t level = 1; level < b.size(); ++level) {
      for (std::size_t p = 0; p + level < b.size(); ++p) b[p] = (1 - v) * b[p] + v * b[p + 1];
    }
    return v * b[0];
  });
  EXPECT_LT(largest_difference(front(volume, bezier_model(volume, 6, {0.2, 1.5}), {points})[0], truth),
            kRounding);
  EXPECT_THROW((void)bezier_model(volume, 22, {0, 1}), Error);
  EXPECT_THROW((void)bezier_model(volume, 3, {1, 1}), Error);
}

TEST(Models, BandsAreTheirVoxelsInTheirColours) {
  const auto volume = holed_noise();
  const auto& f = std::get<volume::Grid<double>>(volume.grid);
  const double top = volume::value_range(volume).max;
  const auto model = bands_model(volume, {{0, 0.5}, {0.5, top}}, true);
  ASSERT_EQ(model.spectra.size(), 3u);
  const auto pictures = front(volume, model, {{1, 1, 0}, {1, 0, 0}, {0, 0, 2}});
  EXPECT_LT(largest_difference(pictures[0], sums(f.geometry, f)), kRounding);  // both, the largest value too
  EXPECT_LT(largest_difference(
                pictures[1],
                sums(f.geometry, [&](auto i, auto j, auto k) { return f(i, j, k) < 0.5 ? f(i, j, k) : 0; })),
            kRounding);
  const auto edges = canny_edges(volume);
  const auto truth = sums(f.geometry, [&](auto i, auto j, auto k) { return 2.0 * edges[f.offset(i, j, k)]; });
  EXPECT_LT(largest_difference(pictures[2], truth), kRounding);
  EXPECT_THROW((void)bands_model(volume, {}, false), Error);
}

// A smooth ball: edges lie where the slope is largest, within a step of its radius, and all round it.
TEST(Canny, EdgesOfABallAreItsSurface) {
  volume::GridGeometry g;
  g.dims = {40, 34, 26};
  g.spacing = Vec3(1, 1.2, 1.6);
  auto f = grid_of(g);
  const double radius = 13;
  for (std::int64_t n = 0; n < g.count(); ++n) {
    const Vec3 p = g.index_to_world(Vec3(double(n % 40), double(n / 40 % 34), double(n / 40 / 34)));
    f.voxels[static_cast<std::size_t>(n)] = 1 / (1 + std::exp((p - g.centre()).norm() - radius));
  }
  volume::Volume volume;
  volume.grid = f;
  const auto edges = canny_edges(volume);
  int octants = 0, found = 0;
  for (std::int64_t n = 0; n < g.count(); ++n) {
    if (edges[static_cast<std::size_t>(n)] == 0) continue;
    const Vec3 p =
        g.index_to_world(Vec3(double(n % 40), double(n / 40 % 34), double(n / 40 / 34))) - g.centre();
    EXPECT_NEAR(p.norm(), radius, 1.6);
    octants |= 1 << ((p.x() > 0 ? 1 : 0) + (p.y() > 0 ? 2 : 0) + (p.z() > 0 ? 4 : 0));
    ++found;
  }
  EXPECT_EQ(octants, 255);
  // One layer of voxels of 1.92 each covers 4 pi r^2, give or take slanted layers: between half and twice.
  const double layer = 4 * std::numbers::pi * radius * radius / std::pow(1.92, 2.0 / 3);
  EXPECT_GT(found, 0.5 * layer);
  EXPECT_LT(found, 2 * layer);
}

TEST(Canny, AConstantVolumeHasNoEdges) {
  auto f = grid_of(square_pixels());
  std::fill(f.voxels.begin(), f.voxels.end(), 7.0);
  volume::Volume volume;
  volume.grid = f;
  for (const auto edge : canny_edges(volume)) EXPECT_EQ(edge, 0);
  EXPECT_THROW((void)canny_edges(volume, {.sigma = 1, .low = 0.5, .high = 0.2}), Error);
}

}  // namespace
}  // namespace vol::fourier
