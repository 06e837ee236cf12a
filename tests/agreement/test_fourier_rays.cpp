#include <gtest/gtest.h>

#include "fourier/projection.h"
#include "generic.h"

namespace vol::agreement {
namespace {

/// Three Gaussians of standard deviation 1 in the world, away from each other and seven and more from every
/// face of the box, which is 22 long: 1e-9 is left of them there.
double blobs(const Vec3& p) {
  const Vec3 q = p - Vec3(-100, 7, 3);
  const auto one = [&](double x, double y, double z) {
    return std::exp(-0.5 * (q - Vec3(x, y, z)).squaredNorm());
  };
  return one(-2, 1.5, 0.5) + 0.7 * one(2.2, -1, 1) - 0.4 * one(0.3, 2, -2.5);
}

volume::Volume blobs_of_spacing(double h) {
  volume::GridGeometry g;
  const auto n = static_cast<std::int64_t>(std::lround(22 / h)) + 1;
  g.dims = {n, n - 1, n + 1};
  g.spacing = Vec3(h, h, h);
  g.direction = Eigen::AngleAxisd(0.4, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  g.origin = Vec3(-100, 7, 3) - g.direction * Vec3(11, 11, 11);
  return sampled(g, blobs);
}

constexpr int kWidth = 24, kHeight = 20;

/// By the central slice of the spectrum; pixels are the sum over samples times world length.
image::Image by_slice(const volume::Volume& volume, const render::Scene& scene, const char* filter_name) {
  const auto& f = std::get<volume::Grid<double>>(volume.grid);
  fourier::SpectrumInfo info;
  info.geometry = f.geometry;
  info.padding = 2;
  info.compensation = filter_name;
  for (std::size_t a = 0; a < 3; ++a) info.padded[a] = fourier::padded_size(f.dims()[a], info.padding);
  const auto spectrum =
      fourier::transform<double>(info, {[&](std::int64_t j, std::int64_t k, std::span<double> row) {
                                   std::copy_n(&f(0, j, k), row.size(), row.begin());
                                 }});
  const fourier::Filter filter(filter_name, info.padding);
  const auto source = fourier::slice_source(spectrum, filter.taps());
  const camera::Camera camera(scene.view, f.geometry.centre(), f.geometry.edge_lengths().maxCoeff(), kWidth,
                              kHeight);
  const auto planes = fourier::Projector<double>(source, filter)
                          .project(fourier::slice_view(info, camera, kWidth, kHeight, false), {{1.0}});
  image::Image picture(kWidth, kHeight, {"R"});
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      picture.at(x, y, 0) = static_cast<float>(planes[0][static_cast<std::size_t>(y * kWidth + x)]);
    }
  }
  return picture;
}

image::Image by_rays(const volume::Volume& volume, const render::Scene& scene) {
  render::RenderOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.reconstruction = volume::Reconstruction::b_spline;
  options.tolerance = 1e-9;
  return render::raycast_reference(volume, scene, options).image;
}

// A Gaussian of s steps has exp(-2 pi^2 s^2 / 4) of itself beyond Nyquist: 3e-9 at the coarser grid's s = 2,
// so that its samples, and with them the sum of them, stand for it to that. A cubic spline through the
// samples is off by at most 5/384 h^4 |f''''| an axis (Hall & Meyer 1976), and |f''''| is at most 3 for a
// Gaussian of amplitude and deviation 1: over 3 axes 0.12 h^4 of each Gaussian's own size, and so of their
// integrals. What remains must fall by 2^4 when h is halved, to a share of 1e-7: es:8 with padding 2 is good
// for 2e-7 of noise (lib/fourier/filter.h), and pixels are float.
TEST(FourierAndRays, DrawTheSameBandLimitedField) {
  const render::Scene scene = oblique_scene(render::Model::xray, 9);
  const double spacings[2] = {0.5, 0.25};
  Difference found[2];
  for (int i = 0; i < 2; ++i) {
    const auto volume = blobs_of_spacing(spacings[i]);
    found[i] = compare(by_slice(volume, scene, "es:8"), by_rays(volume, scene), 0, kWidth, kHeight);
    EXPECT_LT(found[i].largest, 0.12 * std::pow(spacings[i], 4) * found[i].peak) << spacings[i];
  }
  EXPECT_GT(found[0].peak, 2);  // sqrt(2 pi) through one of them
  EXPECT_LT(found[1].largest, found[0].largest / 14 + 5e-7 * found[0].peak) << found[0].largest;
}

}  // namespace
}  // namespace vol::agreement
