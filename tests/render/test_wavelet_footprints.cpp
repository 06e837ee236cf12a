#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "noise_volume.h"
#include "render/footprint_kernel.h"
#include "render/footprint_plan.h"
#include "render/parallel_view.h"
#include "render/wavelet_footprints.h"
#include "render/wavelet_xray.h"
#include "wavelet/dwt.h"
#include "wavelet/significance.h"

namespace vol::render {
namespace {

/// Not turned, so that views along the axes are that.
volume::Volume noise(const Dims& dims, std::uint64_t seed, double amplitude = 1) {
  return render::noise(dims, seed, -0.5 * amplitude, amplitude, false);
}

wavelet::Expansion expansion(const volume::Volume& volume, const std::string& wavelet, int levels,
                             std::int64_t keep, int depth = 3) {
  auto d =
      wavelet::analyze<double>(volume, {.wavelet = wavelet, .levels = levels}, volume::value_range(volume));
  wavelet::reject(d, {.keep = keep});
  return wavelet::Expansion(std::move(d), {.depth = depth});
}

Scene view(double azimuth, double elevation) {
  Scene scene;
  scene.view.azimuth = azimuth;
  scene.view.elevation = elevation;
  scene.model = Model::xray;
  return scene;
}

struct Difference {
  double largest = 0, range = 0;
};
Difference difference(const image::Image& a, const image::Image& b) {
  Difference d;
  double least = 1e300, most = -1e300;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const double truth = b.at(x, y, 0);
      d.largest = std::max(d.largest, std::abs(a.at(x, y, 0) - truth));
      least = std::min(least, truth);
      most = std::max(most, truth);
      EXPECT_EQ(a.at(x, y, 3), b.at(x, y, 3)) << x << " " << y;
    }
  }
  d.range = most - least;
  return d;
}

/// Draws both ways; the error as a share of the range. Pictures are float, so 2e-7 is nothing.
double error_of(const wavelet::Expansion& field, const Scene& scene, double allowed,
                FootprintReport* report = nullptr, int width = 21, int height = 17) {
  const RenderOptions options{.width = width, .height = height};
  WaveletFootprints footprints(field, scene, options, allowed);
  if (report != nullptr) *report = footprints.report();
  const auto d = difference(footprints.draw().image, WaveletXray(field).draw(scene, options).image);
  EXPECT_GT(d.range, 0);
  return d.largest / d.range;
}

// Closed forms, at whatever view, but for rounding to float.
TEST(WaveletFootprints, BoxesOfHaarAreExact) {
  Rng rng(2);
  for (const Dims& dims : {Dims{9, 6, 11}, Dims{16, 8, 8}, Dims{1, 13, 7}, Dims{5, 1, 1}}) {
    const auto volume = noise(dims, 3);
    for (const std::int64_t keep : {std::int64_t{5}, std::int64_t{1} << 20}) {
      const auto field = expansion(volume, "haar", 2, keep);
      for (const double tilt : {0.0, 1e-9, 1e-6, 1e-3, 1.0, 33.7}) {
        for (const double azimuth : {0.0, 90.0, 180.0, 41.3}) {
          FootprintReport report;
          const Scene scene = view(azimuth + tilt, rng.uniform(0, 1) < 0.5 ? tilt : 0.0);
          EXPECT_LT(error_of(field, scene, 1e-6, &report), 2e-7) << azimuth << " " << tilt;
          EXPECT_EQ(report.terms_exact + report.terms_tables, 0);
        }
      }
    }
  }
}

// Ways, wavelets, sizes, views: the error asked for is kept.
class FootprintsOf : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Wavelets, FootprintsOf,
                         testing::Values("daubechies-4", "daubechies-8", "coiflet-6", "battle-lemarie-1"));

TEST_P(FootprintsOf, KeepTheErrorAtRandomViews) {
  Rng rng(7);
  std::int64_t tables = 0;
  for (const Dims& dims : {Dims{21, 26, 24}, Dims{32, 9, 17}}) {
    const auto volume = noise(dims, 3);
    for (const double allowed : {1e-3, 1e-4, 1e-5, 1e-6}) {
      const auto field = expansion(volume, GetParam(), 1, rng.uniform(0, 1) < 0.5 ? 60 : 1500);
      FootprintReport report;
      const Scene scene = view(rng.uniform(0, 360), rng.uniform(-90, 90));
      EXPECT_LT(error_of(field, scene, allowed, &report), allowed + 2e-7) << allowed;
      EXPECT_LE(report.estimate, report.allowed);
      EXPECT_LE(report.found, report.allowed);
      tables += report.terms_tables;
    }
  }
  // Of what takes few pixels exact integrals are cheaper than tables: see the next test.
  if (std::string(GetParam()).starts_with("daubechies")) {
    EXPECT_GT(tables, 0);
  }
}

TEST(WaveletFootprints, TablesKeepTheErrorOfRoughWavelets) {
  const auto volume = noise({32, 24, 28}, 6);
  for (const char* name : {"daubechies-4", "coiflet-6"}) {
    const auto field = expansion(volume, name, 1, 300, 6);
    for (const double allowed : {1e-2, 1e-3, 1e-4}) {
      FootprintReport report;
      EXPECT_LT(error_of(field, view(30, 20), allowed, &report, 48, 40), allowed) << name;
      EXPECT_GT(report.terms_tables, 4 * report.terms_exact);  // those of which there are few
    }
  }
}

TEST_P(FootprintsOf, KeepTheErrorAtAndNearTheAxes) {
  const auto field = expansion(noise({13, 10, 12}, 3), GetParam(), 1, 200);
  for (const double allowed : {1e-3, 1e-5}) {
    for (const double tilt : {0.0, 6e-8, 6e-5, 0.01, 1.0}) {  // degrees: from 1e-9 radians on
      for (const double azimuth : {0.0, 90.0}) {
        FootprintReport report;
        EXPECT_LT(error_of(field, view(azimuth + tilt, tilt / 3), allowed, &report, 17, 12), allowed + 2e-7)
            << allowed << " " << azimuth << " " << tilt;
        if (tilt == 0) {
          EXPECT_GT(report.terms_products, 0);
        }
      }
    }
  }
}

// Periods shorter than the functions (folded factors, which jump), axes of one sample, one coefficient, none.
TEST(WaveletFootprints, TakeWhatTablesCannotDoExactly) {
  const auto deep = expansion(noise({8, 12, 8}, 4), "coiflet-6", 2, 200);
  FootprintReport report;
  EXPECT_LT(error_of(deep, view(30, 20), 1e-4, &report), 1e-4);
  EXPECT_GT(report.terms_exact, 0);
  const auto flat = expansion(noise({1, 14, 16}, 4), "daubechies-4", 1, 100);
  EXPECT_LT(error_of(flat, view(30, 20), 1e-4, &report), 1e-4);
  EXPECT_LT(error_of(flat, view(90, 0), 1e-4, &report), 1e-4);
  EXPECT_GT(report.terms_products, 0);
  const auto one = expansion(noise({32, 24, 20}, 4), "daubechies-8", 1, 1);
  EXPECT_LT(error_of(one, view(50, -20), 1e-4), 1e-4);
  const auto none = expansion(noise({32, 24, 20}, 4), "daubechies-8", 1, 0);
  WaveletFootprints black(none, view(50, -20), {.width = 8, .height = 8}, 1e-4);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) EXPECT_EQ(black.draw().image.at(x, y, 0), 0);
  }
}

TEST(WaveletFootprints, AreLinearInTheValues) {
  const Scene scene = view(30, 20);
  const RenderOptions options{.width = 20, .height = 20};
  const auto small = expansion(noise({24, 16, 20}, 5), "daubechies-4", 1, 500);
  const auto large = expansion(noise({24, 16, 20}, 5, 1e30), "daubechies-4", 1, 500);
  const auto a = WaveletFootprints(small, scene, options, 1e-3).draw(),
             b = WaveletFootprints(large, scene, options, 1e-3).draw();
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) EXPECT_NEAR(b.image.at(x, y, 0) / 1e30, a.image.at(x, y, 0), 1e-4);
  }
}

TEST(WaveletFootprints, ThreadsDoNotMatter) {
  const RenderOptions options{.width = 40, .height = 75};
  const int before = thread_count();
  for (const char* name : {"haar", "coiflet-6"}) {
    const auto field = expansion(noise({24, 18, 22}, 5), name, 1, 300);
    set_thread_count(1);
    const auto one = WaveletFootprints(field, view(30, 20), options, 1e-3).draw();
    set_thread_count(2);
    const auto two = WaveletFootprints(field, view(30, 20), options, 1e-3).draw();
    EXPECT_TRUE(one.image.pixels == two.image.pixels) << name;
    EXPECT_EQ(one.counts.samples, two.counts.samples);
  }
  set_thread_count(before);
}

// A footprint much higher than the picture: its last rows lie further than 2^31 values away.
TEST(FootprintPhasesOf, HighWindowsHaveOffsetsInRows) {
  FootprintPhases phases;
  phases.rows = 50000;
  for (int row = 0; row < phases.rows; ++row) {
    phases.begin.push_back(row);
    phases.columns.push_back(row % 7);
  }
  phases.begin.push_back(phases.rows);
  const std::int64_t stride = 65536 + 2 * kFootprintPadding;
  const auto offsets = phases.offsets(stride);
  ASSERT_EQ(offsets.size(), 50000U);
  for (int row = 0; row < phases.rows; ++row) {
    EXPECT_EQ(offsets[static_cast<std::size_t>(row)], row * stride + row % 7);
  }
}

// Footprints that reach over all edges of the picture, and pictures of one block of rows, several and many,
// which are added up in other ways.
TEST(WaveletFootprints, ClippedPicturesAndThoseOfManyBlocks) {
  const auto field = expansion(noise({24, 16, 20}, 9), "daubechies-4", 1, 3000);
  const WaveletXray exact(field);
  struct Case {
    double width;  // of the picture, in the volume's largest edges
    RenderOptions options;
  };
  for (const auto& [width, options] :
       {Case{0.5, {.width = 23, .height = 17}}, Case{0.9, {.width = 40, .height = 9}},
        Case{20, {.width = 1100, .height = 150}}, Case{20, {.width = 1100, .height = 1040}}}) {
    Scene scene = view(30, 20);
    scene.view.width = width * 23;
    WaveletFootprints footprints(field, scene, options, 1e-2);
    EXPECT_GT(footprints.report().terms_tables, 0) << width;
    const auto image = footprints.draw().image;
    const ParallelView rays(field.geometry(), scene.view, options.width, options.height);
    Rng rng(1);
    const auto near_middle = [&](int size) {
      const double half = std::min(0.5 * size, 30.0);
      return static_cast<int>(0.5 * size + rng.uniform(-half, half));
    };
    for (int n = 0; n < 500; ++n) {
      const int x = near_middle(options.width), y = near_middle(options.height);
      const auto cast = rays.cast(x, y);
      std::int64_t terms = 0, pieces = 0;
      const double truth = cast ? exact.integral(cast->ray, cast->chord, terms, pieces) : 0;
      EXPECT_NEAR(image.at(x, y, 0), truth, footprints.report().allowed) << width << " " << x << " " << y;
    }
  }
}

TEST(WaveletFootprints, RefusesWhatItCannotDo) {
  const auto field = expansion(noise({8, 8, 8}, 5), "haar", 1, 10);
  const RenderOptions options{.width = 8, .height = 8};
  Scene scene = view(30, 20);
  EXPECT_THROW(WaveletFootprints(field, scene, options, 0), Error);
  EXPECT_THROW(WaveletFootprints(field, scene, options, NAN), Error);
  scene.view.projection = camera::Projection::perspective;
  EXPECT_THROW(WaveletFootprints(field, scene, options, 1e-3), Error);
}

}  // namespace
}  // namespace vol::render
