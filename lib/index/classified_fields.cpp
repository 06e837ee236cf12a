#include "index/classified_fields.h"

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

#include "base/error.h"
#include "base/parallel.h"
#include "transfer/opacity.h"
#include "wavelet/layout.h"

namespace vol::index {
namespace {

constexpr double kDeepest = 32;  // e^-32 is below half an ulp of a float colour of 1
constexpr std::int64_t kGrain = 1 << 17;
constexpr std::size_t kMostFields = 4;

template <class V>
constexpr bool has_table = std::is_integral_v<V> && sizeof(V) <= 2;

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

ClassifiedFields::ClassifiedFields(const volume::Volume& volume, const transfer::TransferFunction& transfer,
                                   double reference_length, double standard_distance)
    : volume_(volume),
      transfer_(transfer),
      reference_length_(reference_length),
      standard_distance_(standard_distance),
      channels_(distinct_channels(transfer)) {
  if (!(reference_length > 0 && standard_distance > 0))
    throw Error("index: a length of the scene is not positive");
  volume::visit(volume, [&](const auto& grid) {
    using V = typename std::decay_t<decltype(grid)>::value_type;
    if constexpr (has_table<V>) {
      constexpr auto size = std::size_t{1} << (8 * sizeof(V));
      tables_.assign(count(), std::vector<float>(size));
      std::array<float, kMostFields> fields{};
      for (std::size_t n = 0; n < size; ++n) {
        classify(static_cast<double>(std::numeric_limits<V>::min()) + static_cast<double>(n), fields.data());
        for (std::size_t f = 0; f < count(); ++f) tables_[f][n] = fields[f];
      }
    }
  });
}

void ClassifiedFields::classify(double value, float* to) const {
  const double depth = std::min(
      kDeepest, transfer::extinction(transfer_.opacity(value), reference_length_) * standard_distance_);
  to[0] = static_cast<float>(depth);
  if (depth == 0) {
    for (std::size_t c = 1; c < count(); ++c) to[c] = 0;
    return;
  }
  const Vec3 colour = transfer_.colour(value);
  for (std::size_t c = 1; c < count(); ++c) {
    to[c] = static_cast<float>(depth * colour[channels_[c - 1]]);
  }
}

template <class V>
void ClassifiedFields::classify_row(const V* from, std::int64_t n, float* const* to) const {
  if constexpr (has_table<V>) {
    for (std::size_t f = 0; f < count(); ++f) {
      const float* zero = tables_[f].data() - std::numeric_limits<V>::min();
      for (std::int64_t i = 0; i < n; ++i) to[f][i] = zero[from[i]];
    }
  } else {
    std::array<float, kMostFields> fields{};
    for (std::int64_t i = 0; i < n; ++i) {
      classify(static_cast<double>(from[i]), fields.data());
      for (std::size_t f = 0; f < count(); ++f) to[f][i] = fields[f];
    }
  }
}

double ClassifiedFields::bound(std::size_t field) const {
  double opacity = 0, colour = 1;
  for (const auto& point : transfer_.opacities()) opacity = std::max(opacity, point.opacity);
  if (field > 0) {
    colour = 0;
    for (const auto& point : transfer_.colours()) colour = std::max(colour, point.rgb[channels_[field - 1]]);
  }
  const double depth =
      std::min(kDeepest, transfer::extinction(opacity, reference_length_) * standard_distance_);
  return 2 * depth * colour;  // twice: beyond what rounding adds between the points
}

std::vector<float> ClassifiedFields::largest() const {
  using Fields = std::array<float, kMostFields>;
  const Fields most = volume::visit(volume_, [&](const auto& grid) {
    return parallel_reduce<Fields>(
        0, grid.geometry.count(), kGrain,
        [&](std::int64_t begin, std::int64_t end) {
          constexpr std::int64_t kPiece = 1024;  // stays in the first-level cache
          std::array<std::array<float, kPiece>, kMostFields> values;
          std::array<float*, kMostFields> to{};
          for (std::size_t f = 0; f < kMostFields; ++f) to[f] = values[f].data();
          Fields result{};
          for (std::int64_t at = begin; at < end; at += kPiece) {
            const std::int64_t n = std::min(kPiece, end - at);
            classify_row(grid.voxels.data() + at, n, to.data());
            for (std::size_t f = 0; f < count(); ++f) {
              for (std::int64_t i = 0; i < n; ++i) result[f] = std::max(result[f], to[f][i]);
            }
          }
          return result;
        },
        [](Fields& total, const Fields& part) {
          for (std::size_t f = 0; f < kMostFields; ++f) total[f] = std::max(total[f], part[f]);
        });
  });
  return {most.begin(), most.begin() + static_cast<std::ptrdiff_t>(count())};
}

void ClassifiedFields::fill(const Dims& begin, const Dims& box, wavelet::Extension extension,
                            std::span<float* const> fields) const {
  const Dims& dims = volume_.geometry().dims;
  const std::int64_t inside = std::min(box[0], dims[0] - begin[0]);
  volume::visit(volume_, [&](const auto& grid) {
    parallel_for(
        0, box[1] * box[2], std::max<std::int64_t>(1, kGrain / box[0]),
        [&](std::int64_t from, std::int64_t to) {
          std::array<float*, kMostFields> row{};
          for (std::int64_t r = from; r < to; ++r) {
            for (std::size_t f = 0; f < count(); ++f) row[f] = fields[f] + r * box[0];
            const std::int64_t y = wavelet::extension_source(extension, begin[1] + r % box[1], dims[1]);
            const std::int64_t z = wavelet::extension_source(extension, begin[2] + r / box[1], dims[2]);
            if (y < 0 || z < 0) {
              for (std::size_t f = 0; f < count(); ++f) std::fill_n(row[f], box[0], 0.0F);
              continue;
            }
            classify_row(grid.voxels.data() + grid.offset(begin[0], y, z), inside, row.data());
            for (std::int64_t i = inside; i < box[0]; ++i) {
              const std::int64_t x = wavelet::extension_source(extension, begin[0] + i, dims[0]) - begin[0];
              for (std::size_t f = 0; f < count(); ++f) row[f][i] = x < 0 ? 0.0F : row[f][x];
            }
          }
        });
  });
}

}  // namespace vol::index
