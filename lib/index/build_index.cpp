#include "index/build_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::index {
namespace {

/// Voxels before and after the cell's lower corner that the kernel reads at positions in the cell.
struct Footprint {
  std::int64_t before, after;
};

Footprint footprint(volume::Reconstruction reconstruction) {
  switch (reconstruction) {
    case volume::Reconstruction::catmull_rom:
    case volume::Reconstruction::b_spline:
      return {1, 2};
    case volume::Reconstruction::nearest:
    case volume::Reconstruction::trilinear:
      break;
  }
  return {0, 1};
}

/// Numbers first..last; none when last < first.
struct Interval {
  std::int64_t first = 0;
  std::int64_t last = -1;
};

/// The entries along one axis that a coefficient forbids: two intervals where its support wraps around.
using Reach = std::array<Interval, 2>;

/// Along an axis of `voxels` samples: the entries whose cells' kernels, widened by a step, meet one of the
/// voxels first..last. What lies outside the volume does not exist, so that it is cut before it is widened.
Interval entries_that_meet(Interval on, std::int64_t voxels, const Footprint& kernel, std::int64_t step,
                           std::int64_t reduction) {
  on = {std::max<std::int64_t>(on.first, 0), std::min(on.last, voxels - 1)};
  if (on.last < on.first) return {};
  return {std::max<std::int64_t>(on.first - step - kernel.after, 0) / reduction,
          std::min(on.last + step + kernel.before, voxels - 1) / reduction};
}

/// For every coefficient index of level m along an axis.
std::vector<Reach> reaches(const SignificantDetails& details, std::size_t m, std::size_t axis,
                           const Footprint& kernel, std::int64_t step, std::int64_t reduction) {
  const SignificantLevel& level = details.levels[m - 1];
  const std::int64_t voxels = details.dims[axis], period = details.extended_dims[axis];
  std::vector<Reach> result(static_cast<std::size_t>(level.coefficients.dims()[axis]));
  for (std::size_t k = 0; k < result.size(); ++k) {
    const auto entries = [&](std::int64_t first, std::int64_t last) {
      return entries_that_meet({first, last}, voxels, kernel, step, reduction);
    };
    const std::int64_t at = (level.lower[axis] + static_cast<std::int64_t>(k)) << m;
    std::int64_t first = at + level.support.first, last = at + level.support.last;
    if (period == 1) {  // an axis of one sample is not transformed
      result[k][0] = entries(0, 0);
    } else if (details.boundary != wavelet::Boundary::periodic) {
      result[k][0] = entries(first, last);
    } else if (last - first + 1 >= period) {
      result[k][0] = entries(0, period - 1);
    } else {
      const std::int64_t begin = (first % period + period) % period;
      last += begin - first;
      result[k] = {entries(begin, std::min(last, period - 1)), entries(0, last - period)};
    }
  }
  return result;
}

/// The boxes of one level's coefficients.
struct Boxes {
  const BitGrid* coefficients;
  std::array<std::vector<Reach>, 3> reach;
};

/// Sets in `to` the entries along x that the coefficients of a row forbid. \returns whether there are any
bool unite_row(const std::uint64_t* coefficients, std::int64_t words, const std::vector<Reach>& reach,
               std::uint64_t* to) {
  Interval open;  // neighbouring coefficients' intervals overlap: their union is set at once
  bool any = false;
  for (std::int64_t w = 0; w < words; ++w) {
    for (std::uint64_t rest = coefficients[w]; rest != 0; rest &= rest - 1) {
      const auto& [next, wrapped] = reach[static_cast<std::size_t>(64 * w + __builtin_ctzll(rest))];
      if (wrapped.first <= wrapped.last) {
        set_bits(to, wrapped.first, wrapped.last);
        any = true;
      }
      if (next.last < next.first) continue;
      any = true;
      if (open.first <= open.last && next.first >= open.first && next.first <= open.last + 1) {
        open.last = std::max(open.last, next.last);
        continue;
      }
      if (open.first <= open.last) set_bits(to, open.first, open.last);
      open = next;
    }
  }
  if (open.first <= open.last) set_bits(to, open.first, open.last);
  return any;
}

/// For eight entries of a set, the four bytes of their nibbles: two entries a byte, low nibble first.
constexpr auto kNibbles = [] {
  std::array<std::array<std::uint8_t, 4>, 256> masks{};
  for (std::size_t set = 0; set < 256; ++set) {
    for (std::size_t i = 0; i < 8; ++i) {
      if (set >> i & 1) masks[set][i / 2] = static_cast<std::uint8_t>(masks[set][i / 2] | 15 << (i % 2 * 4));
    }
  }
  return masks;
}();

/// Gives the entries of a set, up to 64 in so many bytes, the level.
void raise_entries(std::uint64_t set, std::size_t bytes, int level, std::uint8_t* nibbles) {
  const std::uint32_t levels = static_cast<std::uint32_t>(level) * 0x11111111U;
  const auto raise = [&](std::size_t n) {
    std::uint32_t mask = 0, entries = 0;
    std::memcpy(&mask, kNibbles[set & 255].data(), 4);
    std::memcpy(&entries, nibbles, n);
    entries = (entries & ~mask) | (levels & mask);
    std::memcpy(nibbles, &entries, n);
  };
  for (; bytes >= 4; bytes -= 4, nibbles += 4, set >>= 8) raise(4);
  if (bytes > 0) raise(bytes);
}

/// A slab of entries along z and which of them are forbidden.
class Slab {
 public:
  Slab(const Dims& entries, std::int64_t begin, std::int64_t end)
      : begin_(begin), forbidden_({entries[0], entries[1], end - begin}) {
    row_.resize(static_cast<std::size_t>(forbidden_.words_per_row()));
    plane_.resize(row_.size() * static_cast<std::size_t>(entries[1]));
  }

  /// Forbids the boxes: each plane of coefficients is spread along x and y, then united with the planes that
  /// it reaches along z.
  void forbid(const Boxes& boxes) {
    const BitGrid& coefficients = *boxes.coefficients;
    const Dims& entries = forbidden_.dims();
    for (std::int64_t k = 0; k < coefficients.dims()[2]; ++k) {
      Reach along_z = boxes.reach[2][static_cast<std::size_t>(k)];
      bool here = false;
      for (auto& [first, last] : along_z) {
        first = std::max(first - begin_, std::int64_t{0});
        last = std::min(last - begin_, entries[2] - 1);
        here = here || first <= last;
      }
      if (!here || !spread_plane(coefficients, k, boxes)) continue;
      for (const auto& [first, last] : along_z) {
        for (std::int64_t z = first; z <= last; ++z) {
          std::uint64_t* to = forbidden_.row(0, z);
          for (std::size_t w = 0; w < plane_.size(); ++w) to[w] |= plane_[w];
        }
      }
    }
  }

  /// Raises the entries that are not forbidden to `level`. \returns whether there are any
  bool raise(IndexVolume& index, int level) const {
    const Dims& entries = forbidden_.dims();
    bool any = false;
    for (std::int64_t k = 0; k < entries[2]; ++k) {
      for (std::int64_t j = 0; j < entries[1]; ++j) {
        const std::uint64_t* row = forbidden_.row(j, k);
        std::uint8_t* nibbles = index.nibbles().data() + index.row_bytes() * (j + entries[1] * (begin_ + k));
        for (std::int64_t i = 0; i < entries[0]; i += 64) {
          const std::int64_t count = std::min<std::int64_t>(64, entries[0] - i);
          const std::uint64_t free = ~row[i >> 6] & (~std::uint64_t{0} >> (64 - count));
          if (free == 0) continue;
          any = true;
          raise_entries(free, static_cast<std::size_t>(count + 1) / 2, level, nibbles + (i >> 1));
        }
      }
    }
    return any;
  }

 private:
  bool spread_plane(const BitGrid& coefficients, std::int64_t k, const Boxes& boxes) {
    std::fill(plane_.begin(), plane_.end(), 0);
    bool any = false;
    for (std::int64_t j = 0; j < coefficients.dims()[1]; ++j) {
      std::fill(row_.begin(), row_.end(), 0);
      if (!unite_row(coefficients.row(j, k), coefficients.words_per_row(), boxes.reach[0], row_.data()))
        continue;
      any = true;
      for (const auto& [first, last] : boxes.reach[1][static_cast<std::size_t>(j)]) {
        for (std::int64_t y = first; y <= last; ++y) {
          std::uint64_t* to = plane_.data() + y * forbidden_.words_per_row();
          for (std::size_t w = 0; w < row_.size(); ++w) to[w] |= row_[w];
        }
      }
    }
    return any;
  }

  std::int64_t begin_;
  BitGrid forbidden_;
  std::vector<std::uint64_t> row_, plane_;
};

/// Voxels that a step of a level passes along an index axis: a world vector of length s moves at most
/// s |row of the world-to-index matrix| along it.
std::int64_t step_voxels(const volume::GridGeometry& geometry, const IndexOptions& options, int level,
                         int axis) {
  if (!options.look_ahead) return 0;
  const double step = std::ldexp(options.standard_distance, level);
  return static_cast<std::int64_t>(
      std::min(std::ceil(step * geometry.world_to_index_matrix().row(axis).norm()),
               static_cast<double>(geometry.dims[static_cast<std::size_t>(axis)])));
}

constexpr std::int64_t kSlabPlanes = 16;

}  // namespace

IndexVolume build_index(const SignificantDetails& details, const volume::GridGeometry& geometry,
                        const IndexOptions& options) {
  IndexVolume index(geometry.dims, options.reduction, options.standard_distance);
  if (details.dims != geometry.dims) throw Error("index: the details are of a volume of other dimensions");
  const auto levels = std::min(details.levels.size(), static_cast<std::size_t>(IndexVolume::kMaxLevel));
  std::vector<std::vector<Boxes>> boxes(levels);  // for steps of level L: those of the details of levels 1..L
  for (std::size_t level = 1; level <= levels; ++level) {
    for (std::size_t m = 1; m <= level; ++m) {
      Boxes& b = boxes[level - 1].emplace_back(Boxes{&details.levels[m - 1].coefficients, {}});
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto step = step_voxels(geometry, options, static_cast<int>(level), static_cast<int>(axis));
        b.reach[axis] = reaches(details, m, axis, footprint(options.reconstruction), step, options.reduction);
      }
    }
  }
  const Dims& entries = index.dims();
  parallel_for(0, entries[2], kSlabPlanes, [&](std::int64_t begin, std::int64_t end) {
    Slab slab(entries, begin, end);
    for (std::size_t level = 1; level <= levels; ++level) {
      for (const auto& b : boxes[level - 1]) slab.forbid(b);
      if (!slab.raise(index, static_cast<int>(level)))
        break;  // longer steps are forbidden where shorter ones are
    }
  });
  return index;
}

}  // namespace vol::index
