#include <gtest/gtest.h>

#include "base/error.h"
#include "base/parallel.h"
#include "direct.h"
#include "fourier/projection.h"

namespace vol::fourier {
namespace {

using namespace fourier_test;

struct Scene {
  double padding = 2;
  std::string filter = "trilinear", compensation = "none";
  double azimuth = 0, elevation = 0;
  int width = 0, height = 0;
  double pitch = 1;
  bool wrap = true, plain = false;
  Vec3 offset = Vec3::Zero();  // of the camera's target from the centre
};

camera::Camera camera_of(const volume::GridGeometry& g, const Scene& s) {
  camera::View view;
  view.azimuth = s.azimuth;
  view.elevation = s.elevation;
  view.width = s.pitch * s.width;
  view.target = g.centre() + s.offset;
  return {view, g.centre(), 1, s.width, s.height};
}

template <class T>
Picture picture(const volume::Grid<double>& f, const Scene& s) {
  SpectrumInfo info;
  info.geometry = f.geometry;
  info.padding = s.padding;
  info.compensation = s.compensation;
  for (int a = 0; a < 3; ++a) info.padded[a] = padded_size(f.dims()[a], s.padding);
  const auto spectrum = transform<T>(info, {[&](std::int64_t j, std::int64_t k, std::span<double> row) {
                                       std::copy_n(&f(0, j, k), row.size(), row.begin());
                                     }});
  const Filter filter(s.filter, s.padding);
  const auto source = slice_source(spectrum, filter.taps());
  Projector<T> projector(source, filter, s.plain);
  const auto planes =
      projector.project(slice_view(info, camera_of(f.geometry, s), s.width, s.height, s.wrap), {{1.0}});
  return {planes[0].begin(), planes[0].end()};
}

volume::GridGeometry cube(std::int64_t n) {
  volume::GridGeometry g;
  g.dims = {n, n, n};
  return g;
}

// ---- axis-aligned: plain sums
// ------------------------------------------------------------------------------------

// Spacing along x and y alike, so that square pixels can be those of the volume.
volume::GridGeometry square_pixels(const Dims& dims) {
  volume::GridGeometry g;
  g.dims = dims;
  g.spacing = Vec3(0.8, 0.8, 1.7);
  g.origin = Vec3(5, -2, 40);
  return g;
}

Picture sums_along_z(const volume::Grid<double>& f) {
  const Dims& n = f.dims();
  Picture sums;
  for (std::int64_t j = n[1] - 1; j >= 0; --j) {  // row 0 is the top, where y is largest
    for (std::int64_t i = 0; i < n[0]; ++i) {
      double sum = 0;
      for (std::int64_t k = 0; k < n[2]; ++k) sum += f(i, j, k);
      sums.push_back(sum * f.geometry.spacing.z());
    }
  }
  return sums;
}

class AxisAligned : public testing::TestWithParam<Dims> {};

TEST_P(AxisAligned, ViewsAreSumsOfVoxels) {
  auto f = white_noise(square_pixels(GetParam()), 11);
  for (auto& v : f.voxels) v += 3;
  const Picture truth = sums_along_z(f);
  const double range = *std::max_element(truth.begin(), truth.end());
  for (const double padding : {1.0, 2.0, 4.0}) {
    for (const char* filter : {"nearest", "trilinear", "catmull-rom", "sinc:5", "sinc:6"}) {
      for (const bool wrap : {true, false}) {
        Scene s{.padding = padding,
                .filter = filter,
                .width = int(f.dims()[0]),
                .height = int(f.dims()[1]),
                .pitch = 0.8,
                .wrap = wrap};
        EXPECT_LT(largest_difference(picture<double>(f, s), truth), 1e-13 * range)
            << filter << " padding " << padding;
        EXPECT_LT(largest_difference(picture<float>(f, s), truth), 1e-6 * range)
            << filter << " padding " << padding;
        s.plain = true;
        EXPECT_LT(largest_difference(picture<float>(f, s), truth), 1e-6 * range)
            << filter << " padding " << padding;
      }
    }
    // es to its own tolerance, which is what compensation is right to.
    if (padding == 1) continue;
    for (const auto& [filter, bound] :
         {std::pair{"es:4", 2e-3}, {"es:6", 3e-5}, {"es:8", 5e-7}, {"es:12", 1e-10}}) {
      Scene s{.padding = padding,
              .filter = filter,
              .compensation = filter,
              .width = int(f.dims()[0]),
              .height = int(f.dims()[1]),
              .pitch = 0.8};
      EXPECT_LT(relative_l2(picture<double>(f, s), truth), bound) << filter << " padding " << padding;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, AxisAligned,
                         testing::Values(Dims{16, 16, 16}, Dims{15, 12, 9}, Dims{12, 17, 1}, Dims{1, 9, 6},
                                         Dims{13, 1, 7}, Dims{1, 1, 5}, Dims{31, 23, 10}));

// A finer picture has both Nyquist lines of an even size, and pixels on the voxels' columns: interpolation.
TEST(Projection, FinerPicturesPassThroughTheSumsOfVoxels) {
  for (const Dims& dims :
       {Dims{16, 16, 16}, Dims{15, 15, 9}, Dims{12, 10, 7}, Dims{9, 14, 1}, Dims{1, 6, 4}}) {
    const auto f = white_noise(square_pixels(dims), 12);
    const Picture truth = sums_along_z(f);
    for (const double padding : {1.0, 2.0}) {
      for (const auto& [finer_x, finer_y] : {std::pair{3, 3}, {5, 3}, {3, 1}, {1, 3}, {1, 1}}) {
        // Odd factors put a pixel's middle on every voxel's; unequal ones go with unequal steps, so that
        // pixels stay square, and length along z stays as it was.
        auto g = f;
        g.geometry.spacing = Vec3(0.8 * finer_x, 0.8 * finer_y, 1.7);
        const int width = int(dims[0]) * finer_x, height = int(dims[1]) * finer_y;
        Scene s{.padding = padding, .width = width, .height = height, .pitch = 0.8};
        for (const bool in_float : {false, true}) {
          const auto fine = in_float ? picture<float>(g, s) : picture<double>(g, s);
          Picture at_voxels;
          for (std::int64_t j = 0; j < dims[1]; ++j) {
            for (std::int64_t i = 0; i < dims[0]; ++i) {
              const auto x = finer_x / 2 + finer_x * i, y = finer_y / 2 + finer_y * j;
              at_voxels.push_back(fine[static_cast<std::size_t>(y * width + x)]);
            }
          }
          // Rounding, as of the picture of the volume's own size.
          EXPECT_LT(relative_l2(at_voxels, truth), in_float ? 1e-6 : 1e-13)
              << dims[0] << "x" << dims[1] << " padding " << padding << " finer " << finer_x << ","
              << finer_y;
        }
        if (dims[0] * dims[1] < 130) {
          s.filter = s.compensation = "es:12";
          if (padding == 2) {
            EXPECT_LT(relative_l2(picture<double>(g, s),
                                  direct_picture(g, camera_of(g.geometry, s), width, height)),
                      1e-9);  // white noise: as AnyViewOfAnySize
          }
        }
      }
    }
  }
}

// Sizes that a file may claim: the slice's points are far apart, and nearly cancel along one axis.
TEST(Projection, NoPointLiesOutsideTheSpectrum) {
  for (const double width : {1e-11, 1e-13, 1e-14, 1e-15, 3e-16, 1e-17}) {
    SpectrumInfo info;
    info.geometry = cube(8);
    info.geometry.spacing = Vec3(1, 1e-18, 1e-18);
    const double c = 0.70710678128, d = 0.70710678109;
    info.geometry.direction.col(0) = Vec3(c, d, 0);
    info.geometry.direction.col(1) = Vec3(-d, c, 0);
    info.padded = info.geometry.dims;
    SliceSource<float> source(info, 2);
    for (int n = 0; n < 64; ++n)
      std::fill_n(source.row(0, n % 8 - 4, n / 8 - 4), 2 * info.row_length(), 0.0f);
    source.fill_margins();
    camera::View view;
    view.width = width;
    view.projection = camera::Projection::orthographic;
    const auto slice =
        slice_view(info, camera::Camera(view, info.geometry.centre(), 1, 16, 16), 16, 16, true);
    const Filter filter("trilinear", 1);
    Projector<float> projector(source, filter);
    const auto planes = projector.project(slice, {{1.0}});
    for (const float v : planes[0]) ASSERT_EQ(v, 0);  // every number that is read is one of the spectrum's
  }
}

TEST(Projection, ConstantOnALargeOffsetStaysConstant) {
  auto f = grid_of(square_pixels({24, 24, 24}));
  std::fill(f.voxels.begin(), f.voxels.end(), 1e6);
  f(3, 4, 5) += 1;  // a small signal: 4e-8 of the sum, which double must show
  const Picture truth = sums_along_z(f);
  Scene s{.padding = 2, .filter = "catmull-rom", .width = 24, .height = 24, .pitch = 0.8};
  EXPECT_LT(largest_difference(picture<double>(f, s), truth), 1e-13 * truth[0]);
  EXPECT_LT(largest_difference(picture<float>(f, s), truth), 1e-6 * truth[0]);
}

// ---- against the direct sum
// --------------------------------------------------------------------------------------

TEST(Projection, AnyViewOfAnySizeIsTheDirectSumToTheFiltersTolerance) {
  struct Case {
    Dims dims;
    int width, height;
    double pitch;
  };
  for (const Case& c : {Case{{7, 11, 13}, 17, 20, 1.1},
                        {{8, 6, 10}, 16, 12, 1.6},
                        {{9, 4, 5}, 12, 15, 0.7},
                        {{1, 9, 6}, 14, 14, 1.3},
                        {{5, 1, 8}, 13, 18, 1.2},
                        {{1, 1, 1}, 8, 6, 0.3}}) {
    const auto f = white_noise(oblique_geometry(c.dims), 7);
    for (const auto& [azimuth, elevation] : {std::pair{0.0, 0.0}, {25.0, 40.0}, {-130.0, 90.0}}) {
      Scene s{.padding = 2,
              .filter = "es:12",
              .compensation = "es:12",
              .azimuth = azimuth,
              .elevation = elevation,
              .width = c.width,
              .height = c.height,
              .pitch = c.pitch,
              .offset = Vec3(0.4, -0.2, 0.9)};
      const Picture truth = direct_picture(f, camera_of(f.geometry, s), c.width, c.height);
      // Noise up to Nyquist meets the kernel's margin at its worst: ten times the tolerance of band-limited
      // noise.
      EXPECT_LT(relative_l2(picture<double>(f, s), truth), 1e-9)
          << c.dims[0] << "x" << c.dims[1] << "x" << c.dims[2] << " view " << azimuth << "," << elevation;
    }
  }
}

/// Noise without frequencies above `share` of Nyquist along any axis.
volume::Grid<double> band_limited_noise(std::int64_t n, double share) {
  auto f = white_noise(cube(n), 1);
  const auto top = static_cast<int>(share * static_cast<double>(n) / 2);
  std::vector<double> low(static_cast<std::size_t>(n));  // periodic kernel
  for (std::int64_t i = 0; i < n; ++i) {
    for (int k = -top; k <= top; ++k)
      low[i] += std::cos(2 * std::numbers::pi * k * double(i) / double(n)) / double(n);
  }
  const std::int64_t strides[3] = {1, n, n * n};
  std::vector<double> line(static_cast<std::size_t>(n));
  for (const std::int64_t stride : strides) {
    for (std::int64_t start = 0; start < n * n * n; ++start) {
      if (start / stride % n != 0) continue;
      for (std::int64_t i = 0; i < n; ++i) {
        line[i] = 0;
        for (std::int64_t j = 0; j < n; ++j) line[i] += low[(i - j + n) % n] * f.voxels[start + j * stride];
      }
      for (std::int64_t i = 0; i < n; ++i) f.voxels[start + i * stride] = line[i];
    }
  }
  return f;
}

// The figures of the literature's kernel and of the kernels before it, on one oblique view, over the whole
// picture.
TEST(Projection, BandLimitedNoiseSeenObliquely) {
  const auto f = band_limited_noise(64, 0.8);
  Scene s{.padding = 2, .azimuth = 33, .elevation = 21, .width = 64, .height = 64};
  const Picture truth = direct_picture(f, camera_of(f.geometry, s), 64, 64);
  struct Case {
    const char *filter, *compensation;
    double bound, float_bound;
  };
  for (const Case& c : {Case{"es:4", "es:4", 2e-3, 2e-3},
                        {"es:6", "es:6", 3e-5, 3e-5},
                        {"es:8", "es:8", 5e-7, 5e-7},
                        {"es:12", "es:12", 1e-10, 2e-6},  // float's own rounding
                        {"trilinear", "none", 0.22, 0.22},
                        {"trilinear", "trilinear", 0.1, 0.1},
                        {"catmull-rom", "none", 0.07, 0.07},
                        {"catmull-rom", "catmull-rom", 0.05, 0.05},
                        {"sinc:5", "none", 0.027, 0.027},
                        {"sinc:5", "sinc:5", 0.02, 0.02}}) {
    s.filter = c.filter;
    s.compensation = c.compensation;
    const double error = relative_l2(picture<double>(f, s), truth),
                 float_error = relative_l2(picture<float>(f, s), truth);
    std::printf("%-12s compensated for %-12s relative L2 %.2e, float %.2e\n", c.filter, c.compensation, error,
                float_error);
    EXPECT_LT(error, c.bound) << c.filter << " " << c.compensation;
    EXPECT_LT(float_error, c.float_bound) << c.filter << " " << c.compensation;
  }
}

// ---- closed form
// --------------------------------------------------------------------------------------------------

// A Gaussian of sigma = 1.6 steps has exp(-2 pi^2 1.6^2 / 4) = 3e-6 of itself beyond Nyquist, and one five
// sigma from the rim exp(-25/2) = 4e-6 outside: the sum over samples is the integral to that.
TEST(Projection, GaussiansAtAnyAngleAreTheirClosedForm) {
  volume::GridGeometry g;
  g.dims = {32, 30, 35};
  g.spacing = Vec3(1, 1, 1);
  g.origin = Vec3(-100, 7, 3);
  auto f = grid_of(g);
  const double sigma = 1.6;
  const Vec3 at = g.centre() + Vec3(4, -3, 5);
  for (std::int64_t k = 0; k < g.dims[2]; ++k) {
    for (std::int64_t j = 0; j < g.dims[1]; ++j) {
      for (std::int64_t i = 0; i < g.dims[0]; ++i) {
        const Vec3 p = g.index_to_world(Vec3(double(i), double(j), double(k)));
        f(i, j, k) = std::exp(-(p - at).squaredNorm() / (2 * sigma * sigma));
      }
    }
  }
  for (const auto& [azimuth, elevation] :
       {std::pair{0.0, 0.0}, {90.0, 0.0}, {0.0, 90.0}, {37.0, -22.0}, {200.0, 61.0}}) {
    Scene s{.padding = 2,
            .filter = "es:8",
            .compensation = "es:8",
            .azimuth = azimuth,
            .elevation = elevation,
            .width = 51,
            .height = 40,
            .pitch = 0.9,
            .wrap = false,
            .offset = Vec3(1, 2, 3)};
    const auto camera = camera_of(g, s);
    Picture truth;
    for (int y = 0; y < s.height; ++y) {
      for (int x = 0; x < s.width; ++x) {
        const auto ray = camera.ray(x + 0.5, y + 0.5);
        const Vec3 off = at - ray.origin;
        const double d2 = (off - off.dot(ray.direction) * ray.direction).squaredNorm();
        truth.push_back(std::sqrt(2 * std::numbers::pi) * sigma * std::exp(-d2 / (2 * sigma * sigma)));
      }
    }
    const double peak = *std::max_element(truth.begin(), truth.end());
    EXPECT_LT(largest_difference(picture<double>(f, s), truth), 2e-5 * peak) << azimuth << "," << elevation;
    EXPECT_LT(largest_difference(picture<float>(f, s), truth), 2e-5 * peak) << azimuth << "," << elevation;
  }
}

// ---- the fast path
// -----------------------------------------------------------------------------------------------

TEST(Projection, TheFastSliceIsThePlainOne) {
  const auto f = white_noise(oblique_geometry({21, 18, 25}), 13);
  for (const char* filter :
       {"nearest", "trilinear", "catmull-rom", "catmull-rom-fast", "sinc:5", "sinc:8", "sinc:16", "es:4",
        "es:5", "es:6", "es:7", "es:8", "es:10", "es:11", "es:12", "es:13", "es:16"}) {
    Scene s{.padding = 1.5,
            .filter = filter,
            .azimuth = 17,
            .elevation = -48,
            .width = 40,
            .height = 33,
            .pitch = 1.1};
    if (!Filter(filter, 1.5).interpolates()) s.compensation = filter;
    const auto fast = picture<float>(f, s);
    s.plain = true;
    const auto plain = picture<float>(f, s);
    // Some roundings of float, 6e-8 each: white in the spectrum, so evenly spread over the volume, where
    // compensation has raised each sample by W(0)/W; and what polynomials() promises of es.
    const Filter w(filter, 1.5);
    double raised = 0;
    for (int i = 0; i < 25; ++i) raised += std::pow(w.transform(0) / w.transform((i - 12) / 37.5), 2) / 25;
    EXPECT_LT(relative_l2(fast, plain),
              5e-7 * std::pow(raised, 1.5) + (w.beta() > 0 ? std::exp(-w.beta()) : 0))
        << filter;
  }
}

TEST(Projection, ThreadsDoNotCount) {
  const auto f = white_noise(oblique_geometry({21, 18, 25}), 14);
  Scene s{.filter = "catmull-rom", .azimuth = 17, .elevation = -48, .width = 64, .height = 65, .pitch = 1.1};
  set_thread_count(1);
  const auto one = picture<float>(f, s);
  set_thread_count(3);
  EXPECT_EQ(picture<float>(f, s), one);
  set_thread_count(0);
}

// A picture of a part of the volume: what lies outside comes in from the other side if the slice is not
// widened.
TEST(Projection, APartOfTheVolumeIsAPartOfThePicture) {
  auto f = grid_of(cube(24));
  Rng rng(15);
  for (int blob = 0; blob < 12; ++blob) {
    const Vec3 at(rng.uniform(4, 19), rng.uniform(4, 19), rng.uniform(4, 19));
    for (std::int64_t n = 0; n < 24 * 24 * 24; ++n) {
      const Vec3 p(double(n % 24), double(n / 24 % 24), double(n / 576));
      f.voxels[static_cast<std::size_t>(n)] += std::exp(-(p - at).squaredNorm() / (2 * 1.6 * 1.6));
    }
  }
  Scene s{.padding = 2,
          .filter = "es:8",
          .compensation = "es:8",
          .azimuth = 30,
          .elevation = 20,
          .width = 60,
          .height = 60,
          .wrap = false};
  const auto whole = picture<double>(f, s);
  s.width = s.height = 12;
  const auto part = picture<double>(f, s);
  Picture cut;
  for (int y = 24; y < 36; ++y) {
    for (int x = 24; x < 36; ++x) cut.push_back(whole[static_cast<std::size_t>(60 * y + x)]);
  }
  // Four steps from the rim the blobs are down to exp(-3), and what is cut there rings beyond the box.
  EXPECT_LT(relative_l2(part, cut), 3e-3);
  s.wrap = true;
  EXPECT_GT(relative_l2(picture<double>(f, s), cut), 0.3);
}

TEST(Projection, PerspectiveAndHugeSlicesAreRefused) {
  SpectrumInfo info;
  info.geometry = cube(16);
  info.padded = {16, 16, 16};
  camera::View view;
  view.projection = camera::Projection::perspective;
  EXPECT_THROW((void)slice_view(info, camera::Camera(view, info.geometry.centre(), 15, 8, 8), 8, 8, false),
               Error);
  view.projection = camera::Projection::orthographic;
  view.width = 1e-6;
  const camera::Camera close(view, info.geometry.centre(), 15, 8, 8);
  EXPECT_THROW((void)slice_view(info, close, 8, 8, false), Error);
  EXPECT_NO_THROW((void)slice_view(info, close, 8, 8, true));
}

}  // namespace
}  // namespace vol::fourier
