#include "fourier/projection.h"

#include <sstream>

#include "base/rng.h"
#include "fourier/models.h"
#include "kernels.h"
#include "truth.h"

// Spectra there and back, and slices along an axis against sums of voxels.
namespace vol::stability {
namespace {

using namespace vol::fourier;

volume::Grid<double> noise(const Dims& dims, const Vec3& spacing, double scale, double offset) {
  volume::Grid<double> grid;
  grid.geometry.dims = dims;
  grid.geometry.spacing = spacing;
  grid.voxels = Buffer<double>(static_cast<std::size_t>(grid.geometry.count()));
  Rng rng(10);
  // Values that float holds, so that both precisions transform the same.
  for (double& v : grid.voxels)
    v = static_cast<double>(static_cast<float>(scale * rng.uniform(-1, 1))) + offset;
  return grid;
}

template <class T>
Spectrum<T> spectrum_of(const volume::Grid<double>& f, double padding,
                        const std::string& compensation = "none") {
  SpectrumInfo info;
  info.geometry = f.geometry;
  info.padding = padding;
  info.compensation = compensation;
  for (std::size_t a = 0; a < 3; ++a) info.padded[a] = padded_size(f.dims()[a], padding);
  return transform<T>(info, {[&f](std::int64_t j, std::int64_t k, std::span<double> row) {
                        std::copy_n(&f(0, j, k), row.size(), row.begin());
                      }});
}

/// A transform of N points errs by t eta in the 2-norm, t = log2 N, eta = mu + gamma_4 (sqrt 2 + mu), mu the
/// error of the roots of unity (Higham 2002, theorem 24.2): 7 u. Sizes with large primes take three
/// transforms of the next sizes (Rader 1968) or a sum as it is written (gamma_p); phases are one
/// multiplication an axis more.
double transform_error(const Dims& n, double unit) {
  double steps = 0;
  for (const auto size : n) {
    std::int64_t rest = size;
    for (const std::int64_t p : {2, 3, 5, 7}) {
      while (rest % p == 0) rest /= p;
    }
    const double t = std::log2(std::max<double>(1, static_cast<double>(size)));
    steps += 7 * (rest > 1 ? 3 * (t + 2) : t) + (size > 1 ? 4 : 0);
  }
  return (steps + 4) * unit;
}

template <class T>
void there_and_back(Table& table, const std::string& what, const std::vector<Dims>& sizes, double scale,
                    double offset) {
  Worst back, energy;
  for (const Dims& dims : sizes) {
    const auto f = noise(dims, {1, 1, 1}, scale, offset);
    auto spectrum = spectrum_of<T>(f, 1);
    Real size = 0, total = 0, error = 0;
    for (const double v : f.voxels) size += static_cast<Real>(v) * static_cast<Real>(v);
    const std::int64_t row = spectrum.info.row_length();
    for (std::int64_t n = 0; n < spectrum.info.count(); ++n) {
      const std::int64_t kx = n % row;
      const bool own_mirror = kx == 0 || 2 * kx == dims[0];
      const Real re = spectrum.fields[0][static_cast<std::size_t>(2 * n)],
                 im = spectrum.fields[0][static_cast<std::size_t>(2 * n + 1)];
      total += (own_mirror ? 1 : 2) * (re * re + im * im);
    }
    const double bound = transform_error(dims, kUnit<T>);
    energy.add(
        static_cast<double>(std::abs(std::sqrt(total / static_cast<Real>(f.geometry.count()) / size) - 1)),
        bound);
    const auto g = inverse(spectrum, 0);
    for (std::size_t n = 0; n < g.voxels.size(); ++n) {
      const Real e = static_cast<Real>(g.voxels[n]) - static_cast<Real>(f.voxels[n]);
      error += e * e;
    }
    back.add(static_cast<double>(std::sqrt(error / size)), 2 * bound);
  }
  const char* precision = sizeof(T) == 4 ? "float" : "double";
  table.row(what, "transform, inverse", precision, back, "2 x 7 u log2 N; primes thrice");
  table.row(what, "transform, energy", precision, energy, "Parseval to 7 u log2 N; primes thrice");
}

/// The view along z at the volume's own pixels, against sums of columns.
template <class T>
void slices(Table& table, const std::string& what, const Dims& dims, double scale, double offset,
            const Vec3& spacing, const std::vector<std::string>& filters) {
  const auto f = noise(dims, spacing, scale, offset);
  std::vector<Real> sums;
  Real size = 0;
  for (std::int64_t j = dims[1] - 1; j >= 0; --j) {
    for (std::int64_t i = 0; i < dims[0]; ++i) {
      Real sum = 0;
      for (std::int64_t k = 0; k < dims[2]; ++k) sum += static_cast<Real>(f(i, j, k));
      sums.push_back(sum * static_cast<Real>(spacing.z()));
    }
  }
  for (const double v : f.voxels) size += static_cast<Real>(v) * static_cast<Real>(v);
  // The picture is the transform's mean along z: errors of the volume's norm come down by sqrt(n_z) at most.
  size = std::sqrt(size * static_cast<Real>(dims[2])) * static_cast<Real>(spacing.z());
  for (const std::string& name : filters) {
    const Filter filter(name, 2);
    Dims padded = dims;
    for (auto& n : padded) n = padded_size(n, 2);
    const auto spectrum = spectrum_of<T>(f, 2, filter.interpolates() ? "none" : name);
    const auto source = slice_source(spectrum, filter.taps());
    camera::View view;
    view.width = spacing.x() * static_cast<double>(dims[0]);
    const camera::Camera camera(view, f.geometry.centre(), 1, static_cast<int>(dims[0]),
                                static_cast<int>(dims[1]));
    Projector<T> projector(source, filter);
    const auto planes = projector.project(
        slice_view(spectrum.info, camera, static_cast<int>(dims[0]), static_cast<int>(dims[1]), true),
        {{1.0}});
    Real error = 0;
    for (std::size_t n = 0; n < sums.size(); ++n) {
      const Real e = static_cast<Real>(planes[0][n]) - sums[n];
      error += e * e;
    }
    const double rounding = 2 * transform_error(padded, kUnit<T>);
    double own = 0;
    if (!filter.interpolates() && name.starts_with("es:")) own = 3 * std::pow(10.0, 1 - filter.taps());
    // Compensation raises what rounding leaves; float weights are polynomials to 1e-7 of the largest,
    // on each of three axes.
    const double raised = filter.interpolates() ? 1 : compensation(filter, dims, padded).largest;
    const double polynomial = sizeof(T) == 4 ? 3e-7 : 0;
    std::ostringstream row;
    row << what << ", " << name;
    table.row(
        row.str(), "Projector", sizeof(T) == 4 ? "float" : "double",
        static_cast<double>(std::sqrt(error) / size), rounding * raised + own + polynomial,
        std::string(own > 0 ? "10^(1-N) an axis (Barnett et al. 2019) and 14 u log2 N, raised by compensation"
                            : "exact on grid points: 14 u log2 N") +
            (polynomial > 0 ? "; weights to 1e-7 an axis" : ""));
  }
}

template <class T>
void in_precision(Table& table) {
  there_and_back<T>(table, "sizes 1, 2, 3 and primes",
                    {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {2, 3, 1}, {13, 17, 11}, {31, 1, 37}, {1, 101, 2}}, 1,
                    0);
  there_and_back<T>(table, "1 x 1 x 4096, 4093 x 1 x 1, 64^3", {{1, 1, 4096}, {4093, 1, 1}, {64, 64, 64}}, 1,
                    0);
  there_and_back<T>(table, "values 1e30", {{16, 12, 9}}, 1e30, 0);
  there_and_back<T>(table, "values 1e-30", {{16, 12, 9}}, 1e-30, 0);
  there_and_back<T>(table, "signal 1 on 1e8", {{16, 12, 9}}, 1, 1e8);
  const std::vector<std::string> all{"nearest", "trilinear", "catmull-rom", "sinc:5", "sinc:16", "es:2",
                                     "es:4",    "es:6",      "es:8",        "es:12",  "es:16"};
  slices<T>(table, "along an axis", {16, 15, 9}, 1, 0, {0.8, 0.8, 1.7}, all);
  slices<T>(table, "values 1e30", {12, 12, 7}, 1e30, 0, {1, 1, 1}, {"trilinear", "es:6"});
  slices<T>(table, "values 1e-30", {12, 12, 7}, 1e-30, 0, {1, 1, 1}, {"trilinear", "es:6"});
  slices<T>(table, "signal 1 on 1e8", {12, 12, 7}, 1, 1e8, {1, 1, 1}, {"trilinear", "es:6"});
  slices<T>(table, "spacing ratio 1e4", {12, 12, 7}, 1, 0, {1e-2, 1e-2, 100}, {"trilinear", "es:6"});
  slices<T>(table, "1 x 1 x 4096", {1, 1, 4096}, 1, 0, {1, 1, 1}, {"trilinear", "es:6"});
  slices<T>(table, "primes 13 x 31 x 7", {13, 31, 7}, 1, 0, {1, 1, 1}, {"trilinear", "es:6"});
  const char* precision = sizeof(T) == 4 ? "float" : "double";
  table.refusal("spectra that overflow", "transform", precision, [] {
    (void)spectrum_of<T>(
        noise({8, 8, 8}, {1, 1, 1}, 0, static_cast<double>(std::numeric_limits<T>::max()) / 4), 1);
  });
}

}  // namespace

void fourier(Table& table) {
  in_precision<float>(table);
  in_precision<double>(table);
  table.refusal("a perspective view", "slice_view", "double", [] {
    SpectrumInfo info;
    info.geometry.dims = info.padded = {8, 8, 8};
    camera::View view;
    view.projection = camera::Projection::perspective;
    (void)slice_view(info, camera::Camera(view, Vec3::Zero(), 8, 8, 8), 8, 8, false);
  });
  table.refusal("es:17", "Filter", "double", [] { (void)Filter("es:17", 2); });
}

}  // namespace vol::stability
