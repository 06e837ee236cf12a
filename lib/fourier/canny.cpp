#include "fourier/canny.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::fourier {
namespace {

constexpr std::uint8_t kWeak = 1, kStrong = 2;

/// A box of floats read with its border replicated.
struct Box {
  Dims n;
  Buffer<float> v;
  explicit Box(const Dims& dims) : n(dims), v(static_cast<std::size_t>(dims[0] * dims[1] * dims[2])) {}
  [[nodiscard]] std::size_t at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>(i + n[0] * (j + n[1] * k));
  }
  [[nodiscard]] double clamped(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return v[at(std::clamp<std::int64_t>(i, 0, n[0] - 1), std::clamp<std::int64_t>(j, 0, n[1] - 1),
                std::clamp<std::int64_t>(k, 0, n[2] - 1))];
  }
  [[nodiscard]] double trilinear(const Vec3& p) const {
    const Vec3 base(std::floor(p.x()), std::floor(p.y()), std::floor(p.z()));
    const Vec3 f = p - base;
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      const int x = c & 1, y = c >> 1 & 1, z = c >> 2;
      sum += (x ? f.x() : 1 - f.x()) * (y ? f.y() : 1 - f.y()) * (z ? f.z() : 1 - f.z()) *
             clamped(static_cast<std::int64_t>(base.x()) + x, static_cast<std::int64_t>(base.y()) + y,
                     static_cast<std::int64_t>(base.z()) + z);
    }
    return sum;
  }
  template <class F>
  void fill(const F& f) {
    parallel_for(0, n[2], 1, [&](std::int64_t begin, std::int64_t end) {
      for (auto k = begin; k < end; ++k) {
        for (std::int64_t j = 0; j < n[1]; ++j) {
          for (std::int64_t i = 0; i < n[0]; ++i) v[at(i, j, k)] = static_cast<float>(f(i, j, k));
        }
      }
    });
  }
};

Box smoothed(const volume::Volume& volume, double sigma) {
  const Dims& n = volume.geometry().dims;
  Box box(n);
  volume::visit(volume, [&](const auto& grid) {
    box.fill([&](auto i, auto j, auto k) { return static_cast<double>(grid(i, j, k)); });
  });
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  if (radius == 0) return box;
  std::vector<double> kernel;
  double sum = 0;
  for (int d = -radius; d <= radius; ++d)
    sum += kernel.emplace_back(std::exp(-0.5 * d * d / (sigma * sigma)));
  for (int axis = 0; axis < 3; ++axis) {
    Box next(n);
    next.fill([&](std::int64_t i, std::int64_t j, std::int64_t k) {
      double value = 0;
      for (int d = -radius; d <= radius; ++d) {
        value += kernel[static_cast<std::size_t>(d + radius)] / sum *
                 box.clamped(i + (axis == 0 ? d : 0), j + (axis == 1 ? d : 0), k + (axis == 2 ? d : 0));
      }
      return value;
    });
    std::swap(box.v, next.v);
  }
  return box;
}

Vec3 gradient(const Box& f, const Mat3& to_world, std::int64_t i, std::int64_t j, std::int64_t k) {
  const auto quotient = [](double difference, std::int64_t at, std::int64_t n) {
    return n == 1 ? 0.0 : difference / (at > 0 && at < n - 1 ? 2.0 : 1.0);
  };
  return to_world * Vec3(quotient(f.clamped(i + 1, j, k) - f.clamped(i - 1, j, k), i, f.n[0]),
                         quotient(f.clamped(i, j + 1, k) - f.clamped(i, j - 1, k), j, f.n[1]),
                         quotient(f.clamped(i, j, k + 1) - f.clamped(i, j, k - 1), k, f.n[2]));
}

/// Strong voxels, and weak ones joined to them.
Buffer<std::uint8_t> joined(const Buffer<std::uint8_t>& kind, const Dims& n) {
  Buffer<std::uint8_t> edges(kind.size(), 0);
  std::vector<std::size_t> open;
  for (std::size_t v = 0; v < kind.size(); ++v) {
    if (kind[v] != kStrong) continue;
    edges[v] = 1;
    open.push_back(v);
  }
  while (!open.empty()) {
    const auto v = static_cast<std::int64_t>(open.back());
    open.pop_back();
    const std::int64_t i = v % n[0], j = v / n[0] % n[1], k = v / n[0] / n[1];
    for (std::int64_t c = std::max<std::int64_t>(0, k - 1); c <= std::min(n[2] - 1, k + 1); ++c) {
      for (std::int64_t b = std::max<std::int64_t>(0, j - 1); b <= std::min(n[1] - 1, j + 1); ++b) {
        for (std::int64_t a = std::max<std::int64_t>(0, i - 1); a <= std::min(n[0] - 1, i + 1); ++a) {
          const auto w = static_cast<std::size_t>(a + n[0] * (b + n[1] * c));
          if (kind[w] == 0 || edges[w] != 0) continue;
          edges[w] = 1;
          open.push_back(w);
        }
      }
    }
  }
  return edges;
}

}  // namespace

Buffer<std::uint8_t> canny_edges(const volume::Volume& volume, const CannyOptions& options) {
  if (!(options.sigma >= 0 && options.sigma <= 100)) throw Error("edges: sigma is between 0 and 100 voxels");
  if (!(0 <= options.low && options.low <= options.high && options.high <= 1)) {
    throw Error("edges: thresholds are shares of the largest gradient, the lower one first");
  }
  const volume::GridGeometry& g = volume.geometry();
  const Mat3 to_index = g.world_to_index_matrix(), to_world = to_index.transpose();
  const double reach = g.spacing.minCoeff();
  const Box f = smoothed(volume, options.sigma);
  Box magnitude(g.dims);
  magnitude.fill([&](auto i, auto j, auto k) { return gradient(f, to_world, i, j, k).stableNorm(); });
  const double largest = *std::max_element(magnitude.v.begin(), magnitude.v.end());
  Buffer<std::uint8_t> kind(magnitude.v.size(), 0);
  parallel_for(0, g.dims[2], 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto k = begin; k < end; ++k) {
      for (std::int64_t j = 0; j < g.dims[1]; ++j) {
        for (std::int64_t i = 0; i < g.dims[0]; ++i) {
          const double here = magnitude.v[magnitude.at(i, j, k)];
          if (!(here > 0) || here < options.low * largest) continue;
          const Vec3 along = to_index * (reach * gradient(f, to_world, i, j, k).stableNormalized());
          const Vec3 p(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
          if (magnitude.trilinear(p + along) > here || magnitude.trilinear(p - along) > here) continue;
          kind[magnitude.at(i, j, k)] = here >= options.high * largest ? kStrong : kWeak;
        }
      }
    }
  });
  return joined(kind, g.dims);
}

}  // namespace vol::fourier
