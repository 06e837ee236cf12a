#include <gtest/gtest.h>

#include "curves.h"
#include "fourier/direct.h"
#include "fourier/models.h"
#include "fourier/projection.h"

namespace vol::fit {
namespace {

using fourier_test::Picture;

double relative_l2(const Picture& a, const Picture& truth) {
  double off = 0, all = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    off += (a[i] - truth[i]) * (a[i] - truth[i]);
    all += truth[i] * truth[i];
  }
  return std::sqrt(off / all);
}

Picture drawn(const volume::GridGeometry& geometry, const fourier::Model& model,
              const std::vector<double>& weights, const camera::Camera& camera, const char* filter_name) {
  fourier::SpectrumInfo info;
  info.geometry = geometry;
  info.padding = 2;
  for (int a = 0; a < 3; ++a) info.padded[a] = fourier::padded_size(geometry.dims[a], 2);
  info.compensation = filter_name;
  info.model = model.name;
  info.names = model.spectra;
  const fourier::Filter filter(filter_name, 2);
  const auto source = fourier::slice_source(fourier::transform<double>(info, model.sources), filter.taps());
  fourier::Projector<double> projector(source, filter);
  const auto planes = projector.project(fourier::slice_view(info, camera, 40, 40, true), {weights});
  return {planes[0].begin(), planes[0].end()};
}

// Pictures of the spectra of v b_i(v), weighed by fitted points, are the projections of the voxels v B(v): to
// the error that the slice's filter makes of any volume, es:8's and es:12's (test_projection.cpp, with the
// same bounds), and to rounding what the same filter makes of the weighted voxels themselves.
TEST(Pictures, OfFittedPointsAreTheProjectionsOfTheWeightedVoxels) {
  volume::GridGeometry g;
  g.dims = {21, 18, 24};
  g.spacing = Vec3(1, 1.2, 0.9);
  auto f = fourier_test::grid_of(g);
  Rng rng(31);
  for (auto& value : f.voxels) value = rng.uniform(0, 1) < 0.7 ? rng.uniform(0, 20) : rng.uniform(20, 100);
  volume::Volume volume;
  volume.grid = f;
  const volume::Range range{0, 100};
  const Samples samples = histogram_samples(volume, range, 256, Weighting::histogram);
  const auto target = samples.targets([](double value) { return fit_test::stepped(value / 100); });
  camera::View view;
  view.azimuth = 33;
  view.elevation = 21;
  view.width = 44;
  const camera::Camera camera(view, g.centre(), 1, 40, 40);
  for (const int n : {6, 21}) {
    FitOptions o;
    o.points = n;
    const auto curve = fit_bezier(samples, {target}, o).curves[0];
    volume::Volume weighted = volume;
    auto& voxels = std::get<volume::Grid<double>>(weighted.grid).voxels;
    for (auto& value : voxels) value = value / 100 * curve.value(value / 100);
    const Picture truth =
        fourier_test::direct_picture(std::get<volume::Grid<double>>(weighted.grid), camera, 40, 40);
    for (const auto& [filter, bound] : {std::pair{"es:8", 5e-7}, {"es:12", 1e-10}}) {
      const Picture fitted =
          drawn(g, fourier::bezier_model(volume, n, range), curve.ordinates(), camera, filter);
      const Picture itself = drawn(g, fourier::plain_model(weighted), {1}, camera, filter);
      EXPECT_LT(relative_l2(fitted, truth), bound) << n << " " << filter;
      EXPECT_LT(relative_l2(fitted, itself), 1e-12) << n << " " << filter;
    }
  }
}

}  // namespace
}  // namespace vol::fit
