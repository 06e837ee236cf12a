#include "render/weighted_field.h"

#include <limits>
#include <type_traits>

#include "base/parallel.h"

namespace vol::render {
namespace {

constexpr std::int64_t kGrain = 1 << 14;

template <class To, class From>
volume::Grid<To> weighted(const volume::Grid<From>& grid, const transfer::BezierTransfer& bezier,
                          int channel) {
  volume::Grid<To> result{grid.geometry, Buffer<To>(grid.voxels.size())};
  // Of narrow integers each value is weighted once.
  constexpr bool kNarrow = std::is_integral_v<From> && sizeof(From) <= 2;
  std::vector<To> table;
  if constexpr (kNarrow) {
    constexpr int kLeast = std::numeric_limits<From>::min(), kMost = std::numeric_limits<From>::max();
    for (int f = kLeast; f <= kMost; ++f) table.push_back(static_cast<To>(bezier.weighted(f, channel)));
  }
  parallel_for(
      0, static_cast<std::int64_t>(grid.voxels.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          if constexpr (kNarrow) {
            result.voxels[i] =
                table[static_cast<std::size_t>(grid.voxels[i] - std::numeric_limits<From>::min())];
          } else {
            result.voxels[i] = static_cast<To>(bezier.weighted(static_cast<double>(grid.voxels[i]), channel));
          }
        }
      });
  return result;
}

}  // namespace

volume::Volume weighted_volume(const volume::Volume& volume, const transfer::BezierTransfer& bezier,
                               int channel) {
  bezier.validate();
  volume::Volume result;
  result.attributes = volume.attributes;
  volume::visit(volume, [&](const auto& grid) {
    using From = typename std::decay_t<decltype(grid)>::value_type;
    using To = std::conditional_t<std::is_same_v<From, double>, double, float>;
    result.grid = weighted<To>(grid, bezier, channel);
  });
  return result;
}

}  // namespace vol::render
