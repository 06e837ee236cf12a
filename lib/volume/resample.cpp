#include "volume/resample.h"

#include <array>
#include <string>
#include <vector>

#include "base/checked.h"
#include "base/error.h"
#include "base/parallel.h"
#include "volume/arithmetic.h"
#include "volume/b_spline.h"
#include "volume/kernels.h"

namespace vol::volume {
namespace {

constexpr std::int64_t kSlab = 16;  // slices a task: at most three planes in sixteen are made twice

/// Weights of every new sample along an axis from n to m samples over the same box.
template <Reconstruction kKernel>
std::vector<AxisWeights<taps(kKernel)>> all_weights(std::int64_t n, std::int64_t m) {
  std::vector<AxisWeights<taps(kKernel)>> weights;
  weights.reserve(static_cast<std::size_t>(m));
  for (std::int64_t i = 0; i < m; ++i) {
    const double position =
        m == 1 ? 0.5 * static_cast<double>(n - 1)
               : static_cast<double>(i) * (static_cast<double>(n - 1) / static_cast<double>(m - 1));
    // The last centres coincide; the quotient may have rounded.
    const double x = m > 1 && i == m - 1 ? static_cast<double>(n - 1) : position;
    weights.push_back(axis_weights<kKernel>(clamped_to_axis(x, n), n));
  }
  return weights;
}

template <Reconstruction kKernel, class Sample, class T>
void resample(const Sample* from, const Dims& old_dims, Grid<T>& to) {
  constexpr int kTaps = taps(kKernel);
  const auto [nx, ny, nz] = to.dims();
  const auto wx = all_weights<kKernel>(old_dims[0], nx);
  const auto wy = all_weights<kKernel>(old_dims[1], ny);
  const auto wz = all_weights<kKernel>(old_dims[2], nz);
  const std::int64_t plane_size = nx * ny;

  // Slice k of the old grid, resampled along x and y.
  const auto make_plane = [&](std::int64_t k, Buffer<double>& rows, Buffer<double>& plane) {
    for (std::int64_t j = 0; j < old_dims[1]; ++j) {
      const Sample* line = from + old_dims[0] * (j + old_dims[1] * k);
      for (std::int64_t i = 0; i < nx; ++i) {
        const auto& w = wx[static_cast<std::size_t>(i)];
        double sum = 0;
        for (int t = 0; t < kTaps; ++t) sum += w.w[t] * static_cast<double>(line[w.index[t]]);
        rows[static_cast<std::size_t>(i + nx * j)] = sum;
      }
    }
    for (std::int64_t j = 0; j < ny; ++j) {
      const auto& w = wy[static_cast<std::size_t>(j)];
      for (std::int64_t i = 0; i < nx; ++i) {
        double sum = 0;
        for (int t = 0; t < kTaps; ++t) sum += w.w[t] * rows[static_cast<std::size_t>(i + nx * w.index[t])];
        plane[static_cast<std::size_t>(i + nx * j)] = sum;
      }
    }
  };

  parallel_for(0, nz, kSlab, [&](std::int64_t first, std::int64_t last) {
    Buffer<double> rows(static_cast<std::size_t>(nx * old_dims[1]));
    std::array<Buffer<double>, kTaps> planes;
    std::array<std::int64_t, kTaps>
        held;  // which old slice each plane is; old slice s lives in plane s mod kTaps
    held.fill(-1);
    for (auto& plane : planes) plane.resize(static_cast<std::size_t>(plane_size));
    for (std::int64_t k = first; k < last; ++k) {
      const auto& w = wz[static_cast<std::size_t>(k)];
      std::array<const double*, kTaps> at;
      for (int t = 0; t < kTaps; ++t) {
        const auto slot = static_cast<std::size_t>(w.index[t] % kTaps);
        if (held[slot] != w.index[t]) make_plane(held[slot] = w.index[t], rows, planes[slot]);
        at[t] = planes[slot].data();
      }
      T* out = to.voxels.data() + plane_size * k;
      for (std::int64_t n = 0; n < plane_size; ++n) {
        double sum = 0;
        for (int t = 0; t < kTaps; ++t) sum += w.w[t] * at[t][n];
        out[n] = stored_as<T>(sum);
      }
    }
  });
}

}  // namespace

GridGeometry resampled_geometry(const GridGeometry& geometry, const Dims& dims) {
  (void)checked_count(dims);
  GridGeometry result = geometry;
  result.dims = dims;
  Vec3 first = geometry.index_box().min;  // of the new grid, in old index space
  for (int a = 0; a < 3; ++a) {
    const double edge = geometry.index_box().size()[a];
    if (dims[a] == 1) first[a] += 0.5 * edge;
    if (dims[a] == geometry.dims[a]) {
      first[a] = 0;
      continue;
    }
    result.spacing[a] *= edge / static_cast<double>(dims[a] == 1 ? 1 : dims[a] - 1);
  }
  result.origin = geometry.index_to_world(first);
  return result;
}

Volume resampled(const Volume& volume, const Dims& dims, Reconstruction kernel) {
  const GridGeometry geometry = resampled_geometry(volume.geometry(), dims);
  Volume result = allocate(volume.voxel_type(), geometry);
  result.attributes = volume.attributes;
  visit(volume, [&](const auto& grid) {
    auto& to = std::get<std::decay_t<decltype(grid)>>(result.grid);
    const auto* voxels = grid.voxels.data();
    switch (kernel) {
      case Reconstruction::nearest:
        return resample<Reconstruction::nearest>(voxels, grid.dims(), to);
      case Reconstruction::trilinear:
        return resample<Reconstruction::trilinear>(voxels, grid.dims(), to);
      case Reconstruction::catmull_rom:
        return resample<Reconstruction::catmull_rom>(voxels, grid.dims(), to);
      case Reconstruction::b_spline:
        break;
    }
    const auto coefficients = b_spline_coefficients(grid);
    resample<Reconstruction::b_spline>(coefficients.data(), grid.dims(), to);
  });
  return result;
}

std::string_view name(Reconstruction kernel) {
  switch (kernel) {
    case Reconstruction::nearest:
      return "nearest";
    case Reconstruction::trilinear:
      return "trilinear";
    case Reconstruction::catmull_rom:
      return "catmull-rom";
    case Reconstruction::b_spline:
      break;
  }
  return "b-spline";
}

Reconstruction reconstruction_from_name(std::string_view text) {
  for (const auto kernel : {Reconstruction::nearest, Reconstruction::trilinear, Reconstruction::catmull_rom,
                            Reconstruction::b_spline}) {
    if (name(kernel) == text) return kernel;
  }
  throw Error("no kernel '" + std::string(text) + "'; there are: nearest, trilinear, catmull-rom, b-spline");
}

}  // namespace vol::volume
