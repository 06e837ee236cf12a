#include "index/classify.h"

#include <algorithm>
#include <bit>

#include "base/parallel.h"
#include "index/classified_fields.h"
#include "wavelet/filters.h"
#include "wavelet/layout.h"

namespace vol::index {
namespace {

// A field and its coefficients are 1 MiB then, in the second-level cache.
constexpr std::int64_t kBoxVoxels = 1 << 17;

/// Boxes whose transforms are the whole's, whatever lies around them.
Dims box_dims(const Dims& extended, const wavelet::DwtOptions& dwt) {
  const auto bank = wavelet::make_wavelet(dwt.wavelet).bank;
  if (bank.first != 0 || bank.taps() != 2) return extended;
  const std::int64_t unit = std::int64_t{1} << dwt.levels;
  Dims box = {extended[0], std::min(extended[1], unit), std::min(extended[2], unit)};
  const auto grows = [&](std::size_t axis) {
    return box[axis] < extended[axis] && 2 * box[0] * box[1] * box[2] <= kBoxVoxels;
  };
  while (grows(1) || grows(2)) {
    for (const std::size_t axis : {1, 2}) {
      if (grows(axis)) box[axis] = std::min(2 * box[axis], extended[axis]);
    }
  }
  return box;
}

/// Largest value of each field as far as the thresholds depend on it: the volume is searched for it only
/// where epsilon is so small that the transform's rounding counts.
std::vector<double> largest_values(const ClassifiedFields& fields, const SignificanceOptions& options,
                                   int levels) {
  std::vector<double> largest(fields.count());
  bool matters = false;
  for (std::size_t f = 0; f < fields.count(); ++f) {
    largest[f] = fields.bound(f);
    matters = matters || significance_thresholds<float>(options, levels, largest[f]) !=
                             significance_thresholds<float>(options, levels, 0);
  }
  if (!matters) return largest;
  const auto found = fields.largest();
  return {found.begin(), found.end()};
}

bool is_zero(const Buffer<float>& values) {
  std::uint32_t bits = 0;
  for (const float v : values) bits |= std::bit_cast<std::uint32_t>(v);
  return bits == 0;
}

}  // namespace

SignificantDetails significant_classified_details(const volume::Volume& volume,
                                                  const transfer::TransferFunction& transfer,
                                                  double reference_length, double standard_distance,
                                                  const wavelet::DwtOptions& dwt,
                                                  const SignificanceOptions& options) {
  const ClassifiedFields fields(volume, transfer, reference_length, standard_distance);
  SignificantDetails details(volume.geometry().dims, dwt, options.energy_share);
  if (dwt.levels == 0) return details;
  const auto largest = largest_values(fields, options, dwt.levels);
  std::vector<std::vector<float>> thresholds;
  for (const double most : largest)
    thresholds.push_back(significance_thresholds<float>(options, dwt.levels, most));

  const Dims& extended = details.extended_dims;
  const Dims box = box_dims(extended, dwt);
  const std::int64_t along_y = (extended[1] + box[1] - 1) / box[1];
  const std::int64_t along_z = (extended[2] + box[2] - 1) / box[2];
  parallel_for(0, along_y * along_z, 1, [&](std::int64_t n, std::int64_t) {
    const Dims begin = {0, n % along_y * box[1], n / along_y * box[2]};
    volume::GridGeometry geometry;
    geometry.dims = {box[0], std::min(box[1], extended[1] - begin[1]),
                     std::min(box[2], extended[2] - begin[2])};
    std::vector<volume::Volume> parts(fields.count());
    std::vector<float*> voxels;
    for (auto& part : parts) {
      auto& grid = part.grid.emplace<volume::Grid<float>>(
          volume::Grid<float>{geometry, Buffer<float>(static_cast<std::size_t>(geometry.count()))});
      voxels.push_back(grid.voxels.data());
    }
    fields.fill(begin, geometry.dims, dwt.extension, voxels);
    for (std::size_t f = 0; f < parts.size(); ++f) {
      if (is_zero(std::get<volume::Grid<float>>(parts[f].grid).voxels)) continue;  // and so are its details
      const auto transformed = wavelet::analyze<float>(parts[f], dwt, {0, largest[f]});
      parts[f] = {};
      add_significant(transformed, thresholds[f], begin, details);
    }
  });
  return details;
}

template <class T>
SignificantDetails significant_classified_details(const wavelet::Decomposition<T>& decomposition,
                                                  const transfer::TransferFunction& transfer,
                                                  double reference_length, double standard_distance,
                                                  const SignificanceOptions& options) {
  volume::Volume volume;
  volume.grid = wavelet::synthesize(decomposition);
  return significant_classified_details(
      volume, transfer, reference_length, standard_distance,
      {decomposition.wavelet, decomposition.levels, decomposition.boundary, decomposition.extension},
      options);
}

template SignificantDetails significant_classified_details(const wavelet::Decomposition<float>&,
                                                           const transfer::TransferFunction&, double, double,
                                                           const SignificanceOptions&);
template SignificantDetails significant_classified_details(const wavelet::Decomposition<double>&,
                                                           const transfer::TransferFunction&, double, double,
                                                           const SignificanceOptions&);

}  // namespace vol::index
