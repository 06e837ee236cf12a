#pragma once
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "base/rng.h"
#include "camera/camera.h"
#include "volume/volume.h"

// The sums of lib/README.md as they are written, without a fast transform: what everything here is held
// against.
namespace vol::fourier_test {

using Complex = std::complex<double>;
using Picture = std::vector<double>;

inline volume::Grid<double> grid_of(const volume::GridGeometry& geometry) {
  return {geometry, Buffer<double>(static_cast<std::size_t>(geometry.count()), 0.0)};
}

inline volume::Grid<double> white_noise(const volume::GridGeometry& geometry, std::uint64_t seed) {
  auto grid = grid_of(geometry);
  Rng rng(seed);
  for (auto& v : grid.voxels) v = rng.normal();
  return grid;
}

/// Unequal steps, oblique axes, an origin away from 0.
inline volume::GridGeometry oblique_geometry(const Dims& dims) {
  volume::GridGeometry g;
  g.dims = dims;
  g.spacing = Vec3(0.7, 1.1, 1.9);
  g.origin = Vec3(3, -20, 11);
  g.direction = (Eigen::AngleAxisd(0.4, Vec3(1, 2, -1).normalized())).toRotationMatrix();
  return g;
}

/// sum f[i] exp(-2 pi i kappa . (i - c)), kappa in cycles a sample.
inline Complex direct_sum(const volume::Grid<double>& f, const Vec3& kappa) {
  const Dims& n = f.dims();
  std::vector<Complex> e[3];
  for (int a = 0; a < 3; ++a) {
    for (std::int64_t i = 0; i < n[a]; ++i) {
      const double at = static_cast<double>(i) - 0.5 * static_cast<double>(n[a] - 1);
      e[a].push_back(std::polar(1.0, -2 * std::numbers::pi * kappa[a] * at));
    }
  }
  Complex sum = 0;
  for (std::int64_t k = 0; k < n[2]; ++k) {
    Complex slab = 0;
    for (std::int64_t j = 0; j < n[1]; ++j) {
      const double* row = &f(0, j, k);
      double re = 0, im = 0;
      for (std::int64_t i = 0; i < n[0]; ++i) {
        re += row[i] * e[0][i].real();
        im += row[i] * e[0][i].imag();
      }
      slab += e[1][j] * Complex(re, im);
    }
    sum += e[2][k] * slab;
  }
  return sum;
}

/// The picture that the projection-slice theorem defines: every frequency of the picture by direct_sum, 0
/// beyond the Nyquist box, half of it for each axis on whose face it lies, the real part of the complex
/// inverse sum. For an even size that sum holds only -size/2 of both Nyquist lines, and in full: where the
/// line lies in a face, that is the face's half from either side.
inline Picture direct_picture(const volume::Grid<double>& f, const camera::Camera& camera, int width,
                              int height) {
  const auto& g = f.geometry;
  const Mat3 steps = g.direction * g.spacing.asDiagonal();
  const double pitch = camera.width() / width;
  const Vec3 down = -camera.up(), offset = camera.eye() - g.centre();
  const double x0 = offset.dot(camera.right()), y0 = offset.dot(down);
  std::vector<Complex> rows(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));  // ky, x
  for (int b = 0; b < height; ++b) {
    const double ny = (b - height / 2) / (height * pitch);
    for (int a = 0; a < width; ++a) {
      const double nx = (a - width / 2) / (width * pitch);
      const Vec3 kappa = steps.transpose() * (nx * camera.right() + ny * down);
      if (kappa.cwiseAbs().maxCoeff() > 0.5 * (1 + 1e-12)) continue;
      double share = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 x_axis = steps.transpose() * camera.right(), y_axis = steps.transpose() * down;
        const bool line_x = a == 0 && width % 2 == 0 && std::abs(y_axis[axis]) < 1e-12 * g.spacing[axis] &&
                            std::abs(std::abs(nx * x_axis[axis]) - 0.5) < 1e-10;
        const bool line_y = b == 0 && height % 2 == 0 && std::abs(x_axis[axis]) < 1e-12 * g.spacing[axis] &&
                            std::abs(std::abs(ny * y_axis[axis]) - 0.5) < 1e-10;
        if (std::abs(std::abs(kappa[axis]) - 0.5) < 1e-10 && !line_x && !line_y) share *= 0.5;
      }
      const Complex s = share * direct_sum(f, kappa);
      for (int x = 0; x < width; ++x) {
        const double at = x0 + (x + 0.5 - 0.5 * width) * pitch;
        rows[static_cast<std::size_t>(b * width + x)] += s * std::polar(1.0, 2 * std::numbers::pi * nx * at);
      }
    }
  }
  const double scale = std::abs(steps.determinant()) / (pitch * pitch * width * height);
  Picture picture(rows.size());
  for (int y = 0; y < height; ++y) {
    const double at = y0 + (y + 0.5 - 0.5 * height) * pitch;
    for (int x = 0; x < width; ++x) {
      Complex sum = 0;
      for (int b = 0; b < height; ++b) {
        const double ny = (b - height / 2) / (height * pitch);
        sum +=
            rows[static_cast<std::size_t>(b * width + x)] * std::polar(1.0, 2 * std::numbers::pi * ny * at);
      }
      picture[static_cast<std::size_t>(y * width + x)] = scale * sum.real();
    }
  }
  return picture;
}

template <class A, class B>
double relative_l2(const A& picture, const B& truth) {
  double difference = 0, norm = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    difference += (picture[i] - truth[i]) * (picture[i] - truth[i]);
    norm += truth[i] * truth[i];
  }
  return std::sqrt(difference / norm);
}

template <class A, class B>
double largest_difference(const A& picture, const B& truth) {
  double largest = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    largest = std::max(largest, std::abs(picture[i] - double(truth[i])));
  return largest;
}

}  // namespace vol::fourier_test
