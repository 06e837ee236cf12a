#include <gtest/gtest.h>

#include <cmath>

#include "base/parallel.h"
#include "noise_volume.h"
#include "render/raycast.h"
#include "render/wavelet_xray.h"
#include "wavelet/dwt.h"
#include "wavelet/significance.h"

namespace vol::render {
namespace {

wavelet::Decomposition<double> transformed(const volume::Volume& volume, const std::string& wavelet,
                                           std::int64_t keep) {
  auto d = wavelet::analyze<double>(volume, {.wavelet = wavelet, .levels = 2}, volume::value_range(volume));
  wavelet::reject(d, {.keep = keep});
  return d;
}

Scene oblique(camera::Projection projection) {
  Scene scene;
  scene.view.azimuth = 33;
  scene.view.elevation = 21;
  scene.view.projection = projection;
  scene.model = Model::xray;
  return scene;
}

// The reference quadrature of any field, adaptive, knows nothing of wavelets: it samples the expansion as a
// FieldSampler. Pictures are float (6e-8) and the reference is asked for 1e-7 of the largest value and chord.
TEST(WaveletXray, EqualsTheReferenceIntegralOfTheSameField) {
  const auto volume = noise({9, 6, 11}, 3, -0.5, 1);
  for (const char* name : {"haar", "battle-lemarie-3", "daubechies-4"}) {
    const wavelet::Expansion expansion(transformed(volume, name, 12), {.depth = 2});
    for (const auto projection : {camera::Projection::orthographic, camera::Projection::perspective}) {
      const Scene scene = oblique(projection);
      const RenderOptions options{.width = 7, .height = 5, .tolerance = 1e-7};
      const auto exact = WaveletXray(expansion).draw(scene, options);
      // A fit cannot see haar's jumps: there 4000 midpoints a ray, off by at most a jump a step.
      const bool jumps = std::string(name) == "haar";
      const auto truth = jumps ? raycast_plain(expansion, scene, {.width = 7, .height = 5, .step = 0.002})
                               : raycast_reference(expansion, scene, options);
      double largest = 0;
      for (int y = 0; y < 5; ++y) {
        for (int x = 0; x < 7; ++x) largest = std::max(largest, std::abs(double(truth.image.at(x, y, 0))));
      }
      ASSERT_GT(largest, 0.1);
      for (int y = 0; y < 5; ++y) {
        for (int x = 0; x < 7; ++x) {
          EXPECT_NEAR(exact.image.at(x, y, 0), truth.image.at(x, y, 0), (jumps ? 5e-3 : 2e-6) * largest)
              << name << " " << x << " " << y;
          EXPECT_EQ(exact.image.at(x, y, 3), truth.image.at(x, y, 3));
        }
      }
    }
  }
}

// A ray's integral of what was dropped is at most the root of its length times the L2 norm of f along it;
// over parallel rays of pixel area A, sum of squares times A <= longest chord * energy dropped (world
// volume). The sum over pixel centres stands for the integral over the picture; noise on 64 x 64 pixels is
// within 5 % of it.
TEST(WaveletXray, DroppingCoefficientsCostsNoMoreThanTheirNorm) {
  const auto volume = noise({16, 12, 14}, 8, -0.5, 1);
  const Scene scene = oblique(camera::Projection::orthographic);
  const RenderOptions options{.width = 64, .height = 64};
  for (const char* name : {"haar", "battle-lemarie-1"}) {
    const wavelet::Expansion all(transformed(volume, name, 1 << 20));
    const auto full = WaveletXray(all).draw(scene, options);
    const Vec3 edges = volume.geometry().edge_lengths();
    const double width = 1.6 * edges.maxCoeff(), area = width * width / (64 * 64);
    const double voxel = volume.geometry().spacing.prod();
    for (const std::int64_t keep : {0, 1, 30, 300}) {
      auto d = wavelet::analyze<double>(volume, {.wavelet = name, .levels = 2}, volume::value_range(volume));
      const double dropped = wavelet::reject(d, {.keep = keep}).rejected_norm;
      const wavelet::Expansion some(d);
      EXPECT_EQ(some.coefficients(), keep);
      const auto picture = WaveletXray(some).draw(scene, options);
      double squares = 0;
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
          squares += std::pow(double(picture.image.at(x, y, 0)) - full.image.at(x, y, 0), 2);
        }
      }
      EXPECT_LE(std::sqrt(squares * area), 1.05 * std::sqrt(edges.norm() * voxel) * dropped) << name << keep;
    }
  }
}

TEST(WaveletXray, NothingIsBlackAndLargeValuesAreRight) {
  const auto volume = noise({16, 8, 8}, 5, -0.5, 1);
  const Scene scene = oblique(camera::Projection::orthographic);
  const RenderOptions options{.width = 8, .height = 8};
  const wavelet::Expansion none(transformed(volume, "daubechies-6", 0));
  const auto black = WaveletXray(none).draw(scene, options);
  EXPECT_EQ(black.counts.samples, 0);
  const auto large = noise({16, 8, 8}, 5, -0.5e30, 1e30);
  const wavelet::Expansion one(transformed(volume, "daubechies-6", 40)),
      huge(transformed(large, "daubechies-6", 40));
  const auto a = WaveletXray(one).draw(scene, options), b = WaveletXray(huge).draw(scene, options);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      EXPECT_EQ(black.image.at(x, y, 0), 0);
      EXPECT_NEAR(b.image.at(x, y, 0) / 1e30, a.image.at(x, y, 0), 1e-5);
    }
  }
}

TEST(WaveletXray, ThreadsDoNotMatter) {
  const auto volume = noise({16, 8, 8}, 5, -0.5, 1);
  const wavelet::Expansion expansion(transformed(volume, "coiflet-6", 100));
  const Scene scene = oblique(camera::Projection::orthographic);
  const RenderOptions options{.width = 16, .height = 16};
  const int before = thread_count();
  set_thread_count(1);
  const auto one = WaveletXray(expansion).draw(scene, options);
  set_thread_count(2);
  const auto two = WaveletXray(expansion).draw(scene, options);
  set_thread_count(before);
  EXPECT_TRUE(one.image.pixels == two.image.pixels);
  EXPECT_EQ(one.counts.samples, two.counts.samples);
}

}  // namespace
}  // namespace vol::render
