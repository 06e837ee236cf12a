#include "index/classify.h"

#include <algorithm>

#include "base/error.h"
#include "base/parallel.h"
#include "transfer/opacity.h"
#include "wavelet/dwt.h"

namespace vol::index {
namespace {

constexpr double kDeepest = 32;  // e^-32 is below half an ulp of a float colour of 1

/// Colour channels that are not copies of an earlier one.
std::vector<int> distinct_channels(const transfer::TransferFunction& transfer) {
  std::vector<int> channels;
  for (int c = 0; c < 3; ++c) {
    const bool copy = std::any_of(channels.begin(), channels.end(), [&](int earlier) {
      return std::all_of(transfer.colours().begin(), transfer.colours().end(),
                         [&](const auto& point) { return point.rgb[c] == point.rgb[earlier]; });
    });
    if (!copy) channels.push_back(c);
  }
  return channels;
}

}  // namespace

std::vector<volume::Grid<float>> classified_fields(const volume::Volume& volume,
                                                   const transfer::TransferFunction& transfer,
                                                   double reference_length, double standard_distance) {
  if (!(reference_length > 0 && standard_distance > 0))
    throw Error("index: a length of the scene is not positive");
  const auto channels = distinct_channels(transfer);
  std::vector<volume::Grid<float>> fields(1 + channels.size());
  const auto count = static_cast<std::size_t>(volume.geometry().count());
  for (auto& field : fields) field = {volume.geometry(), Buffer<float>(count)};
  volume::visit(volume, [&](const auto& grid) {
    parallel_for(0, grid.geometry.count(), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
      for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
        const double value = static_cast<double>(grid.voxels[n]);
        const double depth = std::min(
            kDeepest, transfer::extinction(transfer.opacity(value), reference_length) * standard_distance);
        fields[0].voxels[n] = static_cast<float>(depth);
        if (depth == 0) {
          for (std::size_t c = 0; c < channels.size(); ++c) fields[c + 1].voxels[n] = 0;
          continue;
        }
        const Vec3 colour = transfer.colour(value);
        for (std::size_t c = 0; c < channels.size(); ++c) {
          fields[c + 1].voxels[n] = static_cast<float>(depth * colour[channels[c]]);
        }
      }
    });
  });
  return fields;
}

std::vector<BitGrid> significant_classified_details(const volume::Volume& volume,
                                                    const transfer::TransferFunction& transfer,
                                                    double reference_length, double standard_distance,
                                                    const wavelet::DwtOptions& dwt,
                                                    const SignificanceOptions& options) {
  auto fields = classified_fields(volume, transfer, reference_length, standard_distance);
  std::vector<BitGrid> united;
  for (auto& field : fields) {
    volume::Volume classified;
    classified.grid = std::move(field);
    const auto levels = significant_details(
        wavelet::analyze<float>(classified, dwt, volume::value_range(classified)), options);
    if (united.empty()) united.assign(levels.size(), BitGrid(volume.geometry().dims));
    for (std::size_t m = 0; m < levels.size(); ++m) united[m] |= levels[m];
  }
  return united;
}

template <class T>
std::vector<BitGrid> significant_classified_details(const wavelet::Decomposition<T>& decomposition,
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

template std::vector<BitGrid> significant_classified_details(const wavelet::Decomposition<float>&,
                                                             const transfer::TransferFunction&, double,
                                                             double, const SignificanceOptions&);
template std::vector<BitGrid> significant_classified_details(const wavelet::Decomposition<double>&,
                                                             const transfer::TransferFunction&, double,
                                                             double, const SignificanceOptions&);

}  // namespace vol::index
