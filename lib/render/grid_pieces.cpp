#include <algorithm>
#include <cmath>
#include <limits>

#include "render/ray_polynomial.h"
#include "volume/b_spline.h"
#include "volume/kernels.h"

namespace vol::render {
namespace {

using volume::Reconstruction;

/// Cubic by value and slope at u = 0 and u = 1/2, both of which lie in the cell for certain.
void cubic_through(double w0, double d0, double wh, double dh, double* power) {
  const double secant = 2 * (wh - w0);
  power[0] = w0;
  power[1] = d0;
  power[2] = 2 * (3 * secant - 2 * d0 - dh);
  power[3] = 4 * (dh + d0 - 2 * secant);
}

/// Bernstein coefficients over [u0, u1] of a cubic given by powers: its polar form (blossom).
void restricted(const double* c, double u0, double u1, double* b) {
  const auto polar = [&](double x, double y, double z) {
    return c[0] + c[1] * ((x + y + z) / 3) + c[2] * ((x * y + y * z + z * x) / 3) + c[3] * (x * y * z);
  };
  b[0] = polar(u0, u0, u0);
  b[1] = polar(u0, u0, u1);
  b[2] = polar(u0, u1, u1);
  b[3] = polar(u1, u1, u1);
}

/// Whether all eight samples of a cell are at least `value`, or none; of an axis of one sample there are two
/// the same.
template <class T>
std::optional<bool> side_of_cell(const void* samples, const Dims& dims,
                                 const std::array<std::int64_t, 3>& cell, double value) {
  const std::int64_t x = dims[0] > 1;
  const std::int64_t y = dims[1] > 1 ? dims[0] : 0;
  const std::int64_t z = dims[2] > 1 ? dims[0] * dims[1] : 0;
  const T* first = static_cast<const T*>(samples) + cell[0] + dims[0] * (cell[1] + dims[1] * cell[2]);
  int above = 0;
  for (const std::int64_t row : {std::int64_t{0}, y, z, y + z}) {
    above += static_cast<double>(first[row]) >= value;
    above += static_cast<double>(first[row + x]) >= value;
  }
  if (above != 0 && above != 8) return std::nullopt;
  return above == 8;
}

constexpr double kBinomial[4][10] = {
    {1}, {1, 3, 3, 1}, {1, 6, 15, 20, 15, 6, 1}, {1, 9, 36, 84, 126, 126, 84, 36, 9, 1}};

}  // namespace

GridPieces::GridPieces(const volume::Volume& volume, Reconstruction reconstruction,
                       std::optional<double> less)
    : geometry_(volume.geometry()),
      world_to_index_(geometry_.world_to_index_matrix()),
      reconstruction_(reconstruction),
      taps_(volume::taps(reconstruction)),
      less_(less.value_or(0)),
      shifted_(less.has_value()) {
  volume::visit(volume, [&](const auto& grid) {
    using T = typename std::decay_t<decltype(grid)>::value_type;
    if (reconstruction == Reconstruction::b_spline) {
      if (less_ == 0) {
        coefficients_ = volume::b_spline_coefficients(grid);
      } else {
        volume::Grid<double> shifted;
        shifted.geometry = grid.geometry;
        shifted.voxels = Buffer<double>(grid.voxels.size());
        std::transform(grid.voxels.begin(), grid.voxels.end(), shifted.voxels.begin(),
                       [this](T value) { return static_cast<double>(value) - less_; });
        coefficients_ = volume::b_spline_coefficients(shifted);
        less_ = 0;  // the coefficients have it already
      }
      samples_ = coefficients_.data();
      load_ = [](const void* p, std::int64_t i) { return static_cast<const double*>(p)[i]; };
    } else {
      samples_ = grid.voxels.data();
      load_ = [](const void* p, std::int64_t i) { return static_cast<double>(static_cast<const T*>(p)[i]); };
      side_ = side_of_cell<T>;
    }
  });
}

GridPieces::AxisKernel GridPieces::kernel(int axis, std::int64_t cell) const {
  const std::int64_t n = geometry_.dims[axis];
  AxisKernel k{};
  const auto fill = [&](const auto& at_0, const auto& at_half) {
    for (int t = 0; t < taps_; ++t) {
      k.index[t] = at_0.index[t];
      cubic_through(at_0.w[t], at_0.dw[t], at_half.w[t], at_half.dw[t], k.power[t]);
    }
  };
  const auto x = static_cast<double>(cell);
  const double half = n == 1 ? x : x + 0.5;
  switch (reconstruction_) {
    case Reconstruction::nearest:
      k.index[0] = cell;
      k.power[0][0] = 1;
      break;
    case Reconstruction::trilinear: {
      const auto w = volume::linear_weights(x, n);
      for (int t = 0; t < 2; ++t) {
        k.index[t] = w.index[t];
        k.power[t][0] = w.w[t];
        k.power[t][1] = w.dw[t];
      }
      break;
    }
    case Reconstruction::catmull_rom:
      fill(volume::catmull_rom_weights(x, n), volume::catmull_rom_weights(half, n));
      break;
    case Reconstruction::b_spline:
      fill(volume::b_spline_weights(x, n), volume::b_spline_weights(half, n));
      break;
  }
  return k;
}

Bernstein GridPieces::polynomial(const std::array<std::int64_t, 3>& cell, const Vec3& from,
                                 const Vec3& to) const {
  AxisKernel axis[3];
  for (int a = 0; a < 3; ++a) axis[a] = kernel(a, cell[static_cast<std::size_t>(a)]);
  const std::int64_t nx = geometry_.dims[0], ny = geometry_.dims[1];
  const auto sample = [&](int i, int j, int k) {
    return load_(samples_, axis[0].index[i] + nx * (axis[1].index[j] + ny * axis[2].index[k])) - less_;
  };
  Bernstein p;
  if (taps_ == 1) {
    p.b[0] = sample(0, 0, 0);
    return p;
  }
  // Weights as scaled Bernstein polynomials of t, w[k] C(d, k), whose products are plain convolutions. The
  // field is taken relative to `less`, or to one sample: constant cells come out constant, small signals keep
  // their digits.
  const int d = taps_ == 2 ? 1 : 3;
  double weight[3][4][4];
  for (int a = 0; a < 3; ++a) {
    for (int t = 0; t < taps_; ++t) {
      if (d == 1) {
        weight[a][t][0] = axis[a].power[t][0] + axis[a].power[t][1] * from[a];
        weight[a][t][1] = axis[a].power[t][0] + axis[a].power[t][1] * to[a];
      } else {
        restricted(axis[a].power[t], from[a], to[a], weight[a][t]);
        for (int k = 0; k <= 3; ++k) weight[a][t][k] *= kBinomial[1][k];
      }
    }
  }
  const double base = shifted_ ? 0 : sample(taps_ / 4, taps_ / 4, taps_ / 4);
  double sum[10] = {};
  for (int c = 0; c < taps_; ++c) {
    double plane[7] = {};
    for (int b = 0; b < taps_; ++b) {
      double line[4] = {};
      for (int a = 0; a < taps_; ++a) {
        const double v = sample(a, b, c) - base;
        for (int k = 0; k <= d; ++k) line[k] += weight[0][a][k] * v;
      }
      for (int m = 0; m <= d; ++m) {
        for (int k = 0; k <= d; ++k) plane[k + m] += weight[1][b][m] * line[k];
      }
    }
    for (int m = 0; m <= d; ++m) {
      for (int k = 0; k <= 2 * d; ++k) sum[k + m] += weight[2][c][m] * plane[k];
    }
  }
  p.degree = 3 * d;
  const double* binomial = kBinomial[d];
  for (int k = 0; k <= p.degree; ++k) p.b[k] = base + sum[k] / binomial[k];
  return p;
}

Vec3 GridPieces::local(const std::array<std::int64_t, 3>& cell, const Vec3& o, const Vec3& d,
                       double t) const {
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  Vec3 u = Vec3::Zero();
  for (int a = 0; a < 3; ++a) {
    if (geometry_.dims[static_cast<std::size_t>(a)] == 1) continue;
    const double x = o[a] + t * d[a] - static_cast<double>(cell[static_cast<std::size_t>(a)]);
    const double rounding = kRounding * (1 + std::abs(o[a]) + std::abs(t * d[a]));
    u[a] = x <= rounding ? 0 : x >= 1 - rounding ? 1 : x;
  }
  return u;
}

Vec3 GridPieces::gradient(const camera::Ray& ray, const RayPiece& piece, double t) const {
  const Vec3 u = local(piece.cell, world_to_index_ * (ray.origin - geometry_.origin),
                       world_to_index_ * ray.direction, t);
  AxisKernel axis[3];
  double w[3][4], dw[3][4];
  for (int a = 0; a < 3; ++a) {
    axis[a] = kernel(a, piece.cell[static_cast<std::size_t>(a)]);
    for (int n = 0; n < taps_; ++n) {
      const double* c = axis[a].power[n];
      w[a][n] = c[0] + u[a] * (c[1] + u[a] * (c[2] + u[a] * c[3]));
      dw[a][n] = c[1] + u[a] * (2 * c[2] + u[a] * 3 * c[3]);
    }
  }
  const auto sample = [&](int i, int j, int k) {
    return load_(samples_, axis[0].index[i] +
                               geometry_.dims[0] * (axis[1].index[j] + geometry_.dims[1] * axis[2].index[k]));
  };
  const double base = sample(0, 0, 0);  // so that where all are equal the gradient is 0
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < taps_; ++k) {
    for (int j = 0; j < taps_; ++j) {
      for (int i = 0; i < taps_; ++i) {
        const double v = sample(i, j, k) - base;
        sum += v *
               Vec3(dw[0][i] * w[1][j] * w[2][k], w[0][i] * dw[1][j] * w[2][k], w[0][i] * w[1][j] * dw[2][k]);
      }
    }
  }
  return world_to_index_.transpose() * sum;
}

RayPiece GridPieces::piece(const camera::Ray& ray, const CellSpan& span) const {
  const Vec3 o = world_to_index_ * (ray.origin - geometry_.origin);
  const Vec3 d = world_to_index_ * ray.direction;
  return {span.t0, span.t1,
          polynomial(span.cell, local(span.cell, o, d, span.t0), local(span.cell, o, d, span.t1)), span.cell};
}

void GridPieces::operator()(const camera::Ray& ray, const Chord& chord, const PieceSink& sink) const {
  const Vec3 o = world_to_index_ * (ray.origin - geometry_.origin);
  const Vec3 d = world_to_index_ * ray.direction;
  for_cells(ray, chord, [&](const CellSpan& s) {
    return sink(
        {s.t0, s.t1, polynomial(s.cell, local(s.cell, o, d, s.t0), local(s.cell, o, d, s.t1)), s.cell});
  });
}

}  // namespace vol::render
