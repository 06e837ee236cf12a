#include "volume/arithmetic.h"

#include <algorithm>
#include <string>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::volume {
namespace {

constexpr std::int64_t kGrain = 1 << 18;

std::string text(const Dims& dims) {
  return std::to_string(dims[0]) + "x" + std::to_string(dims[1]) + "x" + std::to_string(dims[2]);
}

VoxelType difference_type(VoxelType f, VoxelType g) {
  const auto within = [&](std::initializer_list<VoxelType> types) {
    return std::find(types.begin(), types.end(), f) != types.end() &&
           std::find(types.begin(), types.end(), g) != types.end();
  };
  using enum VoxelType;
  if (within({i8, u8})) return i16;
  return within({i8, u8, i16, u16, f16, f32}) ? f32 : f64;
}

}  // namespace

Volume as_type(Volume volume, VoxelType type) {
  if (volume.voxel_type() == type) return volume;
  return dispatch(type, [&]<class T>() {
    Volume result;
    result.grid = converted<T>(volume);
    result.attributes = std::move(volume.attributes);
    return result;
  });
}

Volume scaled(const Volume& volume, double a, double b, VoxelType type) {
  if (!std::isfinite(a) || !std::isfinite(b)) throw Error("scale and offset must be finite");
  Grid<double> wide = converted<double>(volume);
  parallel_for(0, wide.geometry.count(), kGrain, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t n = first; n < last; ++n) {
      double& voxel = wide.voxels[static_cast<std::size_t>(n)];
      voxel = a * voxel + b;
    }
  });
  Volume result;
  result.grid = std::move(wide);
  result.attributes = volume.attributes;
  return as_type(std::move(result), type);
}

Volume rescaled(const Volume& volume, double lo, double hi, VoxelType type) {
  const Range range = value_range(volume);
  const double extent = range.max - range.min;
  const double a = extent > 0 ? (hi - lo) / extent : 0;
  return scaled(volume, a, lo - a * range.min, type);
}

Volume difference(const Volume& f, const Volume& g) {
  if (f.geometry().dims != g.geometry().dims) {
    throw Error("cannot subtract " + text(g.geometry().dims) + " voxels from " + text(f.geometry().dims));
  }
  Grid<double> wide = converted<double>(f);
  visit(g, [&](const auto& other) {
    parallel_for(0, wide.geometry.count(), kGrain, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t n = first; n < last; ++n) {
        const auto at = static_cast<std::size_t>(n);
        wide.voxels[at] -= static_cast<double>(other.voxels[at]);
      }
    });
  });
  Volume result;
  result.grid = std::move(wide);
  result.attributes = f.attributes;
  return as_type(std::move(result), difference_type(f.voxel_type(), g.voxel_type()));
}

}  // namespace vol::volume
