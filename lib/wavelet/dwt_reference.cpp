#include "wavelet/dwt_reference.h"

#include <algorithm>

#include "base/error.h"
#include "wavelet/layout.h"

namespace vol::wavelet {
namespace {

using Line = std::vector<double>;

/// Filters that are exact for the line at hand: on a period shorter than an infinite filter, its wrapped
/// taps.
FilterBank line_filters(const Wavelet& wavelet, Boundary boundary, std::int64_t n) {
  return boundary == Boundary::periodic && !wavelet.compact ? periodised(wavelet, n) : wavelet.bank;
}

/// c'[k] = sum_n h[n] c[2k + n], k in `out`; c is given on `in` and continued beyond.
void analyze_line(const FilterBank& f, Boundary boundary, const Line& c, const IndexRange& in,
                  const IndexRange& out, Line& low, Line& high) {
  low.assign(static_cast<std::size_t>(out.count), 0);
  high = low;
  for (std::int64_t k = 0; k < out.count; ++k) {
    for (std::int64_t i = 0; i < f.taps(); ++i) {
      const std::int64_t m = 2 * (out.lower + k) + f.first + i;
      const double x = c[static_cast<std::size_t>(wrapped_index(boundary, m - in.lower, in.count))];
      low[static_cast<std::size_t>(k)] += f.h[static_cast<std::size_t>(i)] * x;
      high[static_cast<std::size_t>(k)] += f.g[static_cast<std::size_t>(i)] * x;
    }
  }
}

/// c[m] = sum_k h[m - 2k] c'[k] + g[m - 2k] d[k], by scattering.
Line synthesize_line(const FilterBank& f, Boundary boundary, const Line& low, const Line& high,
                     const IndexRange& in, const IndexRange& out) {
  Line c(static_cast<std::size_t>(out.count), 0);
  for (std::int64_t k = 0; k < in.count; ++k) {
    for (std::int64_t i = 0; i < f.taps(); ++i) {
      std::int64_t m = 2 * (in.lower + k) + f.first + i - out.lower;
      if (boundary == Boundary::periodic) m = wrapped_index(boundary, m, out.count);
      if (m < 0 || m >= out.count) continue;
      c[static_cast<std::size_t>(m)] += f.h[static_cast<std::size_t>(i)] * low[static_cast<std::size_t>(k)] +
                                        f.g[static_cast<std::size_t>(i)] * high[static_cast<std::size_t>(k)];
    }
  }
  return c;
}

struct Box {
  Dims dims{1, 1, 1};
  Line values;
  [[nodiscard]] double& at(std::int64_t i, std::int64_t j, std::int64_t k) {
    return values[static_cast<std::size_t>(i + dims[0] * (j + dims[1] * k))];
  }
};

Box make_box(const Dims& dims) {
  return {dims, Line(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]))};
}

/// Calls f(get, put index) for every line along `axis`: f receives a function from position to element.
template <class F>
void for_each_line(const Dims& dims, std::size_t axis, const F& f) {
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (std::int64_t a = 0; a < dims[u]; ++a) {
    for (std::int64_t b = 0; b < dims[v]; ++b) {
      f([&, a, b](Box& box, std::int64_t p) -> double& {
        std::array<std::int64_t, 3> at{};
        at[axis] = p;
        at[u] = a;
        at[v] = b;
        return box.at(at[0], at[1], at[2]);
      });
    }
  }
}

std::array<Box, 2> split(Box& box, std::size_t axis, const Wavelet& wavelet, Boundary boundary,
                         const IndexRange& in, const IndexRange& out) {
  Dims dims = box.dims;
  dims[axis] = out.count;
  std::array<Box, 2> bands{make_box(dims), make_box(dims)};
  const FilterBank f = line_filters(wavelet, boundary, in.count);
  Line line(static_cast<std::size_t>(in.count)), low, high;
  for_each_line(box.dims, axis, [&](const auto& element) {
    for (std::int64_t p = 0; p < in.count; ++p) line[static_cast<std::size_t>(p)] = element(box, p);
    analyze_line(f, boundary, line, in, out, low, high);
    for (std::int64_t p = 0; p < out.count; ++p) {
      element(bands[0], p) = low[static_cast<std::size_t>(p)];
      element(bands[1], p) = high[static_cast<std::size_t>(p)];
    }
  });
  return bands;
}

Box join(Box& low_box, Box& high_box, std::size_t axis, const Wavelet& wavelet, Boundary boundary,
         const IndexRange& in, const IndexRange& out) {
  Dims dims = low_box.dims;
  dims[axis] = out.count;
  Box box = make_box(dims);
  const FilterBank f = line_filters(wavelet, boundary, out.count);
  Line low(static_cast<std::size_t>(in.count)), high = low;
  for_each_line(box.dims, axis, [&](const auto& element) {
    for (std::int64_t p = 0; p < in.count; ++p) {
      low[static_cast<std::size_t>(p)] = element(low_box, p);
      high[static_cast<std::size_t>(p)] = element(high_box, p);
    }
    const Line line = synthesize_line(f, boundary, low, high, in, out);
    for (std::int64_t p = 0; p < out.count; ++p) element(box, p) = line[static_cast<std::size_t>(p)];
  });
  return box;
}

Subband<double> as_subband(int level, int orientation, const std::array<IndexRange, 3>& ranges,
                           const Box& box) {
  Subband<double> band;
  band.level = level;
  band.orientation = orientation;
  for (std::size_t a = 0; a < 3; ++a) band.lower[a] = ranges[a].lower;
  band.dims = box.dims;
  band.coefficients.assign(box.values.begin(), box.values.end());
  return band;
}

Box extended(const volume::Volume& volume, Extension extension, const Dims& dims) {
  const auto grid = volume::converted<double>(volume);
  Box box = make_box(dims);
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const std::int64_t si = extension_source(extension, i, grid.dims()[0]);
        const std::int64_t sj = extension_source(extension, j, grid.dims()[1]);
        const std::int64_t sk = extension_source(extension, k, grid.dims()[2]);
        box.at(i, j, k) = si < 0 || sj < 0 || sk < 0 ? 0 : grid(si, sj, sk);
      }
    }
  }
  return box;
}

}  // namespace

Decomposition<double> analyze_reference(const volume::Volume& volume, const DwtOptions& options) {
  const Wavelet wavelet = make_wavelet(options.wavelet);
  if (options.initialisation != Initialisation::samples) throw Error("the reference takes samples only");
  Decomposition<double> result;
  result.wavelet = wavelet.name;
  result.levels = options.levels;
  result.boundary = options.boundary;
  result.extension = options.extension;
  result.geometry = volume.geometry();
  result.extended_dims = extended_dims(volume.geometry().dims, options.levels);
  result.voxel_type = volume.voxel_type();
  result.range = volume::value_range(volume);
  const auto ranges = layout(wavelet, options.boundary, result.extended_dims, options.levels);
  Box approximation = extended(volume, options.extension, result.extended_dims);
  for (int level = 1; level <= options.levels; ++level) {
    std::vector<std::pair<int, Box>> bands;
    bands.emplace_back(0, std::move(approximation));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (result.extended_dims[axis] == 1) continue;
      std::vector<std::pair<int, Box>> next;
      for (auto& [orientation, box] : bands) {
        auto halves =
            split(box, axis, wavelet, options.boundary, ranges[static_cast<std::size_t>(level) - 1][axis],
                  ranges[static_cast<std::size_t>(level)][axis]);
        next.emplace_back(orientation, std::move(halves[0]));
        next.emplace_back(orientation | 1 << axis, std::move(halves[1]));
      }
      bands = std::move(next);
    }
    for (auto& [orientation, box] : bands) {
      if (orientation == 0) {
        approximation = std::move(box);
      } else {
        result.subbands.push_back(
            as_subband(level, orientation, ranges[static_cast<std::size_t>(level)], box));
      }
    }
  }
  result.subbands.push_back(
      as_subband(options.levels, 0, ranges[static_cast<std::size_t>(options.levels)], approximation));
  std::sort(result.subbands.begin(), result.subbands.end(), [](const auto& a, const auto& b) {
    return std::pair(-a.level, a.orientation) < std::pair(-b.level, b.orientation);
  });
  return result;
}

volume::Grid<double> synthesize_reference(const Decomposition<double>& d) {
  validate(d);
  if (d.initialisation != Initialisation::samples) throw Error("the reference takes samples only");
  const Wavelet wavelet = make_wavelet(d.wavelet);
  const auto ranges = layout(wavelet, d.boundary, d.extended_dims, d.levels);
  const auto find = [&](int level, int orientation) {
    for (const auto& band : d.subbands) {
      if (band.level == level && band.orientation == orientation) {
        return Box{band.dims, Line(band.coefficients.begin(), band.coefficients.end())};
      }
    }
    throw Error("a subband is missing");
  };
  Box approximation = find(d.levels, 0);
  for (int level = d.levels; level >= 1; --level) {
    std::array<Box, 8> bands;
    bands[0] = std::move(approximation);
    int present = 0;  // bit mask of the axes that have two bands
    for (std::size_t a = 0; a < 3; ++a) present |= d.extended_dims[a] > 1 ? 1 << a : 0;
    for (int o = 1; o < 8; ++o) {
      if ((o & present) == o) bands[static_cast<std::size_t>(o)] = find(level, o);
    }
    for (std::size_t axis = 3; axis-- > 0;) {
      if ((present >> axis & 1) == 0) continue;
      for (int o = 0; o < (1 << axis); ++o) {
        if ((o & present) != o) continue;
        auto& low = bands[static_cast<std::size_t>(o)];
        low = join(low, bands[static_cast<std::size_t>(o | 1 << axis)], axis, wavelet, d.boundary,
                   ranges[static_cast<std::size_t>(level)][axis],
                   ranges[static_cast<std::size_t>(level) - 1][axis]);
      }
    }
    approximation = std::move(bands[0]);
  }
  volume::Grid<double> result{d.geometry, Buffer<double>(static_cast<std::size_t>(d.geometry.count()))};
  for (std::int64_t k = 0; k < d.geometry.dims[2]; ++k) {
    for (std::int64_t j = 0; j < d.geometry.dims[1]; ++j) {
      for (std::int64_t i = 0; i < d.geometry.dims[0]; ++i) result(i, j, k) = approximation.at(i, j, k);
    }
  }
  return result;
}

}  // namespace vol::wavelet
