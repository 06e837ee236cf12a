#include "wavelet/layout.h"

#include <algorithm>
#include <set>
#include <string>

#include "base/checked.h"
#include "base/error.h"

namespace vol::wavelet {
namespace {

Dims rounded_up(const Dims& dims, int levels) {
  const std::int64_t unit = std::int64_t{1} << levels;
  Dims result = dims;
  for (auto& n : result) {
    if (n > 1) n = (n + unit - 1) / unit * unit;
  }
  return result;
}

bool affordable(const Dims& dims, int levels) {
  const Dims extended = rounded_up(dims, levels);
  double growth = 1, count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    growth *= static_cast<double>(extended[a]) / static_cast<double>(dims[a]);
    count *= static_cast<double>(extended[a]);
  }
  return growth <= 8 || count <= 0x1p24;
}

std::string text(const Dims& d) {
  return std::to_string(d[0]) + "x" + std::to_string(d[1]) + "x" + std::to_string(d[2]);
}

std::int64_t floor_half(std::int64_t x) {
  return x >= 0 ? x / 2 : -((1 - x) / 2);
}

}  // namespace

std::string orientation_name(int orientation) {
  std::string name = "LLL";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (orientation >> axis & 1) name[axis] = 'H';
  }
  return name;
}

Dims extended_dims(const Dims& dims, int levels) {
  (void)checked_count(dims);
  if (levels < 0 || levels > kMaxLevels) {
    throw Error("levels is " + std::to_string(levels) + "; expected 0 to " + std::to_string(kMaxLevels));
  }
  if (!affordable(dims, levels)) {
    int most = levels;
    while (!affordable(dims, most)) --most;
    throw Error(std::to_string(levels) + " levels would extend " + text(dims) + " voxels to " +
                text(rounded_up(dims, levels)) + "; give at most " + std::to_string(most) + " levels");
  }
  const Dims extended = rounded_up(dims, levels);
  (void)checked_count(extended);
  return extended;
}

std::vector<std::array<IndexRange, 3>> layout(const Wavelet& wavelet, Boundary boundary, const Dims& extended,
                                              int levels) {
  std::vector<std::array<IndexRange, 3>> ranges(static_cast<std::size_t>(levels) + 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    IndexRange r{0, extended[axis]};
    for (auto& level : ranges) {
      level[axis] = r;
      if (extended[axis] == 1) continue;
      if (boundary == Boundary::periodic) {
        r.count /= 2;
      } else {
        const std::int64_t lower = -floor_half(wavelet.bank.last() - r.lower);
        const std::int64_t upper = floor_half(r.lower + r.count - 1 - wavelet.bank.first);
        r = {lower, upper - lower + 1};
      }
    }
  }
  return ranges;
}

double coefficient_count(const Wavelet& wavelet, Boundary boundary, const Dims& dims, int levels) {
  const auto ranges = layout(wavelet, boundary, extended_dims(dims, levels), levels);
  double sum = 0;
  for (std::size_t level = 0; level < ranges.size(); ++level) {
    double count = 1, bands = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      count *= static_cast<double>(ranges[level][axis].count);
      bands *= dims[axis] > 1 ? 2 : 1;
    }
    if (level > 0) sum += (bands - 1) * count;
    if (level + 1 == ranges.size()) sum += count;
  }
  return sum;
}

std::int64_t wrapped_index(Boundary boundary, std::int64_t p, std::int64_t n) {
  if (boundary == Boundary::periodic) return (p % n + n) % n;
  const std::int64_t q = (p % (2 * n) + 2 * n) % (2 * n);
  return q < n ? q : 2 * n - 1 - q;
}

std::int64_t extension_source(Extension extension, std::int64_t p, std::int64_t n) {
  if (p < n) return p;
  switch (extension) {
    case Extension::replicate:
      return n - 1;
    case Extension::mirror:
      return wrapped_index(Boundary::symmetric, p, n);
    case Extension::zero:
      break;
  }
  return -1;
}

template <class T>
void validate(const Decomposition<T>& d) {
  const Wavelet wavelet = make_wavelet(d.wavelet);
  d.geometry.validate();
  if (extended_dims(d.geometry.dims, d.levels) != d.extended_dims) {
    throw Error("coefficients of a box of " + text(d.extended_dims) + " do not belong to " +
                std::to_string(d.levels) + " levels of a volume of " + text(d.geometry.dims));
  }
  if (d.initialisation == Initialisation::interpolate && d.boundary != Boundary::periodic) {
    throw Error("coefficients that interpolate have the periodic boundary; these have another");
  }
  const auto ranges = layout(wavelet, d.boundary, d.extended_dims, d.levels);
  std::set<std::pair<int, int>> seen;
  for (const auto& band : d.subbands) {
    const std::string label =
        "subband level" + std::to_string(band.level) + "." + orientation_name(band.orientation);
    if (band.level < 0 || band.level > d.levels || band.orientation < 0 || band.orientation > 7 ||
        (band.orientation == 0) != (band.level == d.levels && band.orientation == 0) ||
        (band.level == 0 && d.levels > 0)) {
      throw Error(label + " does not belong to a transform of " + std::to_string(d.levels) + " levels");
    }
    std::int64_t count = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto& r = ranges[static_cast<std::size_t>(band.level)][axis];
      if (band.lower[axis] != r.lower || band.dims[axis] != r.count ||
          (d.extended_dims[axis] == 1 && (band.orientation >> axis & 1) != 0)) {
        throw Error(label + " has " + text(band.dims) + " coefficients from " + text(band.lower) +
                    ", which is not what " + d.wavelet + " makes of this volume");
      }
      count = checked_product(count, band.dims[axis]);
    }
    if (static_cast<std::int64_t>(band.coefficients.size()) != count) {
      throw Error(label + " holds " + std::to_string(band.coefficients.size()) + " of " +
                  std::to_string(count) + " coefficients");
    }
    if (!seen.insert({band.level, band.orientation}).second) throw Error(label + " comes twice");
  }
  int transformed = 0;
  for (const auto n : d.extended_dims) transformed += n > 1;
  const std::size_t expected = 1 + static_cast<std::size_t>(d.levels * ((1 << transformed) - 1));
  if (seen.size() != expected) {
    throw Error(std::to_string(seen.size()) + " of " + std::to_string(expected) + " subbands are there");
  }
}

template void validate(const Decomposition<float>&);
template void validate(const Decomposition<double>&);

}  // namespace vol::wavelet
