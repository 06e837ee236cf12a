#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "index/build_index.h"
#include "transfer/opacity.h"
#include "transfer/transfer_function.h"
#include "wavelet/dwt.h"

// The index by whole fields: every step of its definition for all voxels, one after the other. What lib/index
// does in boxes and slabs must give the same entries.
namespace vol::index::whole {

/// Membership of each voxel, x fastest.
struct Voxels {
  Dims dims;
  std::vector<char> in;

  explicit Voxels(const Dims& d) : dims(d), in(static_cast<std::size_t>(d[0] * d[1] * d[2])) {}
  char& at(const Dims& p) { return in[static_cast<std::size_t>(p[0] + dims[0] * (p[1] + dims[1] * p[2]))]; }
  Voxels& operator|=(const Voxels& other) {
    for (std::size_t n = 0; n < in.size(); ++n) in[n] = static_cast<char>(in[n] | other.in[n]);
    return *this;
  }
};

/// The voxels of one axis under the support of coefficient k.
inline std::vector<std::int64_t> voxels_under(std::int64_t k, int level, const RelevantSupport& support,
                                              std::int64_t voxels, std::int64_t extended, bool periodic) {
  if (extended == 1) return {0};
  std::vector<char> in(static_cast<std::size_t>(voxels));
  for (std::int64_t s = support.first; s <= support.last; ++s) {
    std::int64_t v = (k << level) + s;
    if (periodic) v = (v % extended + extended) % extended;
    if (v >= 0 && v < voxels) in[static_cast<std::size_t>(v)] = 1;
  }
  std::vector<std::int64_t> result;
  for (std::int64_t v = 0; v < voxels; ++v) {
    if (in[static_cast<std::size_t>(v)]) result.push_back(v);
  }
  return result;
}

/// For each level the voxels on which a significant detail bears.
template <class T>
std::vector<Voxels> significant_voxels(const wavelet::Decomposition<T>& d,
                                       const SignificanceOptions& options) {
  std::vector<Voxels> levels(static_cast<std::size_t>(d.levels), Voxels(d.geometry.dims));
  const double largest = std::max(std::abs(d.range.min), std::abs(d.range.max));
  for (const auto& band : d.subbands) {
    if (band.orientation == 0) continue;
    const double to_amplitude = std::pow(2.0, 1.5 * band.level);
    double threshold = options.epsilon;
    if (options.rule == Rule::segment) threshold = std::ldexp(threshold, -band.level);
    if (options.normalisation == Normalisation::amplitude) threshold *= to_amplitude;
    threshold = std::max(threshold, 8 * double(std::numeric_limits<T>::epsilon()) * largest * to_amplitude);
    const auto limit = static_cast<T>(std::min(threshold, double(std::numeric_limits<T>::max())));
    const auto support = relevant_support(d.wavelet, band.level, options.energy_share);
    std::array<std::vector<std::vector<std::int64_t>>, 3> under;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::int64_t k = 0; k < band.dims[a]; ++k) {
        under[a].push_back(voxels_under(k + band.lower[a], band.level, support, d.geometry.dims[a],
                                        d.extended_dims[a], d.boundary == wavelet::Boundary::periodic));
      }
    }
    Voxels& set = levels[static_cast<std::size_t>(band.level - 1)];
    std::size_t n = 0;
    for (std::int64_t z = 0; z < band.dims[2]; ++z) {
      for (std::int64_t y = 0; y < band.dims[1]; ++y) {
        for (std::int64_t x = 0; x < band.dims[0]; ++x) {
          if (!(std::abs(band.coefficients[n++]) > limit)) continue;
          for (const auto k : under[2][static_cast<std::size_t>(z)]) {
            for (const auto j : under[1][static_cast<std::size_t>(y)]) {
              for (const auto i : under[0][static_cast<std::size_t>(x)]) set.at({i, j, k}) = 1;
            }
          }
        }
      }
    }
  }
  return levels;
}

/// The classified fields' significant voxels, each field made and transformed as a whole.
inline std::vector<Voxels> significant_classified_voxels(const volume::Volume& volume,
                                                         const transfer::TransferFunction& transfer,
                                                         double reference_length, double standard_distance,
                                                         const wavelet::DwtOptions& dwt,
                                                         const SignificanceOptions& options) {
  std::vector<Voxels> united(static_cast<std::size_t>(dwt.levels), Voxels(volume.geometry().dims));
  for (int field = 0; field < 4; ++field) {  // extinction, then the light of each channel
    volume::Grid<float> grid{volume.geometry(),
                             Buffer<float>(static_cast<std::size_t>(volume.geometry().count()))};
    volume::visit(volume, [&](const auto& from) {
      for (std::size_t n = 0; n < grid.voxels.size(); ++n) {
        const auto value = static_cast<double>(from.voxels[n]);
        const double depth = std::min(
            32.0, transfer::extinction(transfer.opacity(value), reference_length) * standard_distance);
        grid.voxels[n] = static_cast<float>(field == 0 ? depth : depth * transfer.colour(value)[field - 1]);
      }
    });
    volume::Volume classified;
    classified.grid = std::move(grid);
    const auto levels = significant_voxels(
        wavelet::analyze<float>(classified, dwt, volume::value_range(classified)), options);
    for (std::size_t m = 0; m < levels.size(); ++m) united[m] |= levels[m];
  }
  return united;
}

/// { v : some v' of the set with v - before <= v' <= v + after } along one axis.
inline Voxels dilated(Voxels set, std::size_t axis, std::int64_t before, std::int64_t after) {
  Voxels result(set.dims);
  const std::int64_t n = set.dims[axis];
  Dims p{};
  for (p[2] = 0; p[2] < set.dims[2]; ++p[2]) {
    for (p[1] = 0; p[1] < set.dims[1]; ++p[1]) {
      for (p[0] = 0; p[0] < set.dims[0]; ++p[0]) {
        if (!set.at(p)) continue;
        Dims q = p;
        const std::int64_t last = std::min(p[axis] + before, n - 1);
        for (q[axis] = std::max<std::int64_t>(p[axis] - after, 0); q[axis] <= last; ++q[axis])
          result.at(q) = 1;
      }
    }
  }
  return result;
}

inline IndexVolume build_index(const std::vector<Voxels>& significant, const volume::GridGeometry& geometry,
                               const IndexOptions& options) {
  IndexVolume index(geometry.dims, options.reduction, options.standard_distance);
  const bool cubic = options.reconstruction == volume::Reconstruction::catmull_rom ||
                     options.reconstruction == volume::Reconstruction::b_spline;
  Voxels up_to_level(geometry.dims);
  for (int level = 1; level <= static_cast<int>(significant.size()); ++level) {
    up_to_level |= significant[static_cast<std::size_t>(level - 1)];
    Voxels forbidden = up_to_level;
    for (int axis = 0; axis < 3; ++axis) {
      const double step = options.look_ahead ? std::ldexp(options.standard_distance, level) : 0.0;
      const auto reach =
          static_cast<std::int64_t>(std::ceil(step * geometry.world_to_index_matrix().row(axis).norm()));
      forbidden = dilated(forbidden, static_cast<std::size_t>(axis), reach + (cubic ? 1 : 0),
                          reach + (cubic ? 2 : 1));
    }
    const std::int64_t r = options.reduction;
    for (std::int64_t k = 0; k < index.dims()[2]; ++k) {
      for (std::int64_t j = 0; j < index.dims()[1]; ++j) {
        for (std::int64_t i = 0; i < index.dims()[0]; ++i) {
          bool free = true;
          for (std::int64_t z = r * k; z < std::min(r * k + r, geometry.dims[2]); ++z) {
            for (std::int64_t y = r * j; y < std::min(r * j + r, geometry.dims[1]); ++y) {
              for (std::int64_t x = r * i; x < std::min(r * i + r, geometry.dims[0]); ++x) {
                free = free && !forbidden.at({x, y, z});
              }
            }
          }
          if (free) index.set_entry(i, j, k, level);
        }
      }
    }
  }
  return index;
}

}  // namespace vol::index::whole
