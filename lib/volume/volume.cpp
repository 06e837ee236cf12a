#include "volume/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::volume {
namespace {

/// Voxels a task: large against the cost of a task, small against a volume.
constexpr std::int64_t kGrain = 1 << 18;

template <class T>
bool is_finite(T value) {
  if constexpr (std::is_integral_v<T>) {
    return true;
  } else {
    return std::isfinite(static_cast<double>(value));
  }
}

struct Scan {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  std::int64_t bad = 0;
  std::int64_t first_bad = -1;
};

template <class T>
Scan scan(const Grid<T>& grid) {
  return parallel_reduce<Scan>(
      0, grid.geometry.count(), kGrain,
      [&](std::int64_t begin, std::int64_t end) {
        Scan part;
        for (std::int64_t n = begin; n < end; ++n) {
          const T raw = grid.voxels[static_cast<std::size_t>(n)];
          if (!is_finite(raw)) {
            if (part.bad++ == 0) part.first_bad = n;
            continue;
          }
          const double value = static_cast<double>(raw);
          part.min = std::min(part.min, value);
          part.max = std::max(part.max, value);
        }
        return part;
      },
      [](Scan& total, const Scan& part) {
        total.min = std::min(total.min, part.min);
        total.max = std::max(total.max, part.max);
        if (total.bad == 0) total.first_bad = part.first_bad;
        total.bad += part.bad;
      });
}

[[noreturn]] void refuse_non_finite(const Scan& scan, const Dims& dims) {
  const std::int64_t i = scan.first_bad % dims[0];
  const std::int64_t j = scan.first_bad / dims[0] % dims[1];
  const std::int64_t k = scan.first_bad / dims[0] / dims[1];
  throw Error(std::to_string(scan.bad) + " voxel" + (scan.bad == 1 ? " is" : "s are") +
              " NaN or infinite, the first at (" + std::to_string(i) + "," + std::to_string(j) + "," +
              std::to_string(k) + "); give --missing VALUE to replace them");
}

template <class To, class From>
To convert_voxel(From value) {
  if constexpr (std::is_same_v<To, From>) {
    return value;
  } else if constexpr (std::is_integral_v<To>) {
    const double rounded = std::nearbyint(static_cast<double>(value));
    return static_cast<To>(std::clamp(rounded, static_cast<double>(std::numeric_limits<To>::min()),
                                      static_cast<double>(std::numeric_limits<To>::max())));
  } else {
    return static_cast<To>(static_cast<std::conditional_t<std::is_same_v<To, half>, float, To>>(value));
  }
}

}  // namespace

const GridGeometry& Volume::geometry() const {
  return std::visit([](const auto& g) -> const GridGeometry& { return g.geometry; }, grid);
}

GridGeometry& Volume::geometry() {
  return std::visit([](auto& g) -> GridGeometry& { return g.geometry; }, grid);
}

Volume allocate(VoxelType type, const GridGeometry& geometry) {
  geometry.validate();
  return dispatch(type, [&]<class T>() {
    Volume volume;
    const auto too_large = [&] {
      const auto& [nx, ny, nz] = geometry.dims;
      return Error(std::to_string(nx) + "x" + std::to_string(ny) + "x" + std::to_string(nz) +
                   " voxels of type " + std::string(name(type)) + " take " +
                   std::to_string(static_cast<std::int64_t>(static_cast<double>(geometry.count()) *
                                                            sizeof(T) / 0x1p20)) +
                   " MiB, more memory than there is");
    };
    try {
      volume.grid = Grid<T>{geometry, Buffer<T>(static_cast<std::size_t>(geometry.count()))};
    } catch (const std::bad_alloc&) {
      throw too_large();
    } catch (const std::length_error&) {  // more than a pointer reaches
      throw too_large();
    }
    return volume;
  });
}

Range value_range(const Volume& volume) {
  return visit(volume, [](const auto& grid) {
    const Scan found = scan(grid);
    if (found.bad > 0) refuse_non_finite(found, grid.dims());
    return Range{found.min, found.max};
  });
}

void require_finite(Volume& volume, const double* missing) {
  visit(volume, [&](auto& grid) {
    using T = typename std::decay_t<decltype(grid)>::value_type;
    if constexpr (!std::is_integral_v<T>) {
      const Scan found = scan(grid);
      if (found.bad == 0) return;
      if (missing == nullptr) refuse_non_finite(found, grid.dims());
      for (T& voxel : grid.voxels) {
        if (!is_finite(voxel)) voxel = convert_voxel<T>(*missing);
      }
    }
  });
}

template <class T>
Grid<T> converted(const Volume& volume) {
  return visit(volume, [](const auto& grid) {
    Grid<T> result{grid.geometry, Buffer<T>(grid.voxels.size())};
    parallel_for(0, grid.geometry.count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
        result.voxels[n] = convert_voxel<T>(grid.voxels[n]);
      }
    });
    return result;
  });
}

template Grid<std::int8_t> converted(const Volume&);
template Grid<std::uint8_t> converted(const Volume&);
template Grid<std::int16_t> converted(const Volume&);
template Grid<std::uint16_t> converted(const Volume&);
template Grid<std::int32_t> converted(const Volume&);
template Grid<std::uint32_t> converted(const Volume&);
template Grid<half> converted(const Volume&);
template Grid<float> converted(const Volume&);
template Grid<double> converted(const Volume&);

}  // namespace vol::volume
