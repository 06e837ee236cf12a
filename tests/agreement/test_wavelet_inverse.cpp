#include <gtest/gtest.h>

#include "generic.h"
#include "render/ray_box.h"
#include "render/wavelet_xray.h"
#include "wavelet/dwt.h"
#include "wavelet/prototypes.h"
#include "wavelet/significance.h"

namespace vol::agreement {
namespace {

constexpr int kWidth = 11, kHeight = 9;
constexpr double kFloat = 2e-7;  // pixels are float, of both pictures

render::RenderOptions options() {
  render::RenderOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.tolerance = 1e-10;
  return options;
}

/// The thirty most significant coefficients of noise; 4 divides all sizes, so that the transform's period is
/// the box.
wavelet::Decomposition<double> few_coefficients(const char* wavelet) {
  const auto volume = noise(oblique_geometry({8, 12, 16}), 11);
  auto d = wavelet::analyze<double>(volume, {.wavelet = wavelet, .levels = 2}, volume::value_range(volume));
  wavelet::reject(d, {.keep = 30});
  return d;
}

/// phi at the integers 0 .. n - 1, n-periodic.
std::vector<double> phi_at_integers(const wavelet::PiecewiseCubic& phi, std::int64_t n) {
  std::vector<double> values;
  for (std::int64_t i = 0; i < n; ++i) {
    double sum = 0;
    for (std::int64_t turn = -20; turn <= 20; ++turn) sum += phi.value(static_cast<double>(i + turn * n));
    values.push_back(sum);
  }
  return values;
}

/// f convolved with `kernel` along an axis, both periodic.
void convolve(volume::Grid<double>& f, std::size_t axis, const std::vector<double>& kernel) {
  const auto n = f.dims()[axis];
  const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? f.dims()[0] : f.dims()[0] * f.dims()[1];
  std::vector<double> line(static_cast<std::size_t>(n));
  for (std::int64_t start = 0; start < f.geometry.count(); ++start) {
    if (start / stride % n != 0) continue;
    const auto at = [&](std::int64_t i) -> double& {
      return f.voxels[static_cast<std::size_t>(start + i * stride)];
    };
    for (std::int64_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::int64_t j = 0; j < n; ++j) sum += kernel[static_cast<std::size_t>((i - j + n) % n)] * at(j);
      line[static_cast<std::size_t>(i)] = sum;
    }
    for (std::int64_t i = 0; i < n; ++i) at(i) = line[static_cast<std::size_t>(i)];
  }
}

// The expansion is sum c0[k] phi(x - k), c0 the samples of the inverse transform. phi of battle-lemarie-1 is
// a linear spline on the integers: so the field is the trilinear interpolation of its own values at the
// voxels, which are c0 convolved with phi at the integers. One way integrates thirty basis functions of two
// levels, the other casts rays through a volume.
TEST(WaveletAndInverse, LinearSplinesAreTheTrilinearField) {
  const auto d = few_coefficients("battle-lemarie-1");
  ASSERT_NEAR(wavelet::make_wavelet("battle-lemarie-1").mean, 0, 1e-12);  // phi is not moved
  auto grid = wavelet::synthesize(d);
  const auto phi = wavelet::make_prototypes(wavelet::make_wavelet("battle-lemarie-1"), 1).phi;
  for (std::size_t axis = 0; axis < 3; ++axis) convolve(grid, axis, phi_at_integers(phi, grid.dims()[axis]));
  volume::Volume volume;
  volume.grid = std::move(grid);
  const wavelet::Expansion expansion(d);
  for (const auto projection : {camera::Projection::orthographic, camera::Projection::perspective}) {
    render::Scene scene = oblique_scene(render::Model::xray, 20);
    scene.view.projection = projection;
    const auto found = compare(render::WaveletXray(expansion).draw(scene, options()).image,
                               render::raycast_reference(volume, scene, options()).image, 0, kWidth, kHeight);
    EXPECT_LT(found.largest, kFloat * found.peak);
    EXPECT_GT(found.peak, 0.1);
  }
}

/// Integral along a ray of the field that is constant in the cell around each voxel.
double integral_of_boxes(const volume::Grid<double>& f, const camera::Ray& ray, const render::Chord& chord) {
  const Mat3 to_index = f.geometry.world_to_index_matrix();
  const Vec3 o = f.geometry.world_to_index(ray.origin), step = to_index * ray.direction;
  std::vector<double> cuts = {chord.entry, chord.exit};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::int64_t i = 0; i < f.dims()[a]; ++i) {
      const double t = (static_cast<double>(i) + 0.5 - o[Eigen::Index(a)]) / step[Eigen::Index(a)];
      if (t > chord.entry && t < chord.exit) cuts.push_back(t);
    }
  }
  std::sort(cuts.begin(), cuts.end());
  double sum = 0;
  for (std::size_t n = 1; n < cuts.size(); ++n) {
    const Vec3 p = o + 0.5 * (cuts[n - 1] + cuts[n]) * step;
    sum += (cuts[n] - cuts[n - 1]) * f(std::lround(p[0]), std::lround(p[1]), std::lround(p[2]));
  }
  return sum;
}

// haar's expansion is the inverse transform itself, constant around each voxel.
TEST(WaveletAndInverse, HaarIsTheVoxelsThemselves) {
  const auto d = few_coefficients("haar");
  const auto grid = wavelet::synthesize(d);
  const wavelet::Expansion expansion(d);
  const render::Scene scene = oblique_scene(render::Model::xray, 20);
  const auto picture = render::WaveletXray(expansion).draw(scene, options()).image;
  const camera::Camera camera(scene.view, expansion.bounds().centre(), expansion.bounds().longest_edge(),
                              kWidth, kHeight);
  const render::RayBox box(expansion.bounds());
  int met = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const camera::Ray ray = camera.ray(x + 0.5, y + 0.5);
      const auto chord = box.chord(ray, camera.t_min());
      const double expected = chord ? integral_of_boxes(grid, ray, *chord) : 0;
      EXPECT_NEAR(picture.at(x, y, 0), expected, kFloat * 10)
          << x << ' ' << y;  // values to 1, chords to 10 and more
      met += chord.has_value();
    }
  }
  EXPECT_GT(met, 30);
}

}  // namespace
}  // namespace vol::agreement
