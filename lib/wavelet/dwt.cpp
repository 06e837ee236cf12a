#include "wavelet/dwt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <type_traits>

#include "base/checked.h"
#include "base/error.h"
#include "base/heap.h"
#include "base/parallel.h"
#include "wavelet/analysis_level.h"
#include "wavelet/initialisation.h"
#include "wavelet/layout.h"
#include "wavelet/synthesis_level.h"

namespace vol::wavelet {
namespace {

template <class V, class T>
void convert_row(const std::byte* row, std::int64_t count, T* to) {
  const V* from = reinterpret_cast<const V*>(row);
  for (std::int64_t i = 0; i < count; ++i) {
    if constexpr (std::is_same_v<V, volume::half>) {
      to[i] = static_cast<T>(static_cast<float>(from[i]));
    } else {
      to[i] = static_cast<T>(from[i]);
    }
  }
}

template <class T>
RowSource<T> rows_of(const volume::Volume& volume) {
  return volume::visit(volume, [](const auto& grid) {
    using V = typename std::decay_t<decltype(grid)>::value_type;
    RowSource<T> source{reinterpret_cast<const std::byte*>(grid.voxels.data()), grid.dims(), sizeof(V),
                        nullptr};
    if constexpr (!std::is_same_v<V, T>) source.convert = convert_row<V, T>;
    return source;
  });
}

/// |c| <= max|f| (sum |h|)^(3 levels): refused where that leaves the range of T, with a factor for the sums.
template <class T>
void require_headroom(const Wavelet& wavelet, const volume::Range& range, int levels) {
  double gain = 0, gain_g = 0;
  for (const double h : wavelet.bank.h) gain += std::abs(h);
  for (const double g : wavelet.bank.g) gain_g += std::abs(g);
  const double largest = std::max(std::abs(range.min), std::abs(range.max));
  const double bound = std::log2(largest) + 3 * levels * std::log2(std::max(gain, gain_g));
  if (largest > 0 && !(bound < std::log2(static_cast<double>(std::numeric_limits<T>::max())) - 4)) {
    std::ostringstream message;
    message << "values up to " << largest << " could overflow " << (sizeof(T) == 4 ? "float" : "double")
            << " coefficients at " << levels << " levels; "
            << (sizeof(T) == 4 ? "use double precision or rescale" : "rescale the volume");
    throw Error(message.str());
  }
}

template <class T>
Buffer<T> fresh_buffer(std::int64_t count) {
  Buffer<T> buffer(static_cast<std::size_t>(count));
  prefer_large_pages(buffer.data(), buffer.size() * sizeof(T));
  return buffer;
}

template <class T>
Subband<T> make_subband(int level, int orientation, const std::array<IndexRange, 3>& ranges) {
  Subband<T> band;
  band.level = level;
  band.orientation = orientation;
  std::int64_t count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    band.lower[a] = ranges[a].lower;
    band.dims[a] = ranges[a].count;
    count *= ranges[a].count;
  }
  band.coefficients = fresh_buffer<T>(count);
  return band;
}

bool exists(int orientation, const Dims& extended) {
  for (std::size_t a = 0; a < 3; ++a) {
    if ((orientation >> a & 1) != 0 && extended[a] == 1) return false;
  }
  return true;
}

/// The volume, and what it is extended by.
template <class T>
volume::Grid<T> extended_volume(const volume::Volume& volume, const Dims& extended, Extension extension) {
  volume::Grid<T> box{volume.geometry(), fresh_buffer<T>(checked_count(extended))};
  box.geometry.dims = extended;
  const RowSource<T> source = rows_of<T>(volume);
  const auto row_bytes = static_cast<std::size_t>(source.dims[0]) * source.element_size;
  parallel_for(0, extended[1] * extended[2], 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t r = begin; r < end; ++r) {
      T* const to = box.voxels.data() + r * extended[0];
      const std::int64_t j = extension_source(extension, r % extended[1], source.dims[1]);
      const std::int64_t k = extension_source(extension, r / extended[1], source.dims[2]);
      if (j < 0 || k < 0) {
        std::fill_n(to, extended[0], T{0});
        continue;
      }
      const std::byte* from = source.data + static_cast<std::size_t>(k * source.dims[1] + j) * row_bytes;
      if (source.convert != nullptr) {
        source.convert(from, source.dims[0], to);
      } else {
        std::copy_n(reinterpret_cast<const T*>(from), source.dims[0], to);
      }
      for (std::int64_t i = source.dims[0]; i < extended[0]; ++i) {
        const std::int64_t at = extension_source(extension, i, source.dims[0]);
        to[i] = at < 0 ? T{0} : to[at];
      }
    }
  });
  return box;
}

/// `interpolate`: the transform of c0.
template <class T>
Decomposition<T> analyze_interpolating(const volume::Volume& volume, DwtOptions options,
                                       const volume::Range& range) {
  const Wavelet wavelet = make_wavelet(options.wavelet);
  require_interpolation(wavelet, options.boundary);
  const Dims extended = extended_dims(volume.geometry().dims, options.levels);
  const double gain = interpolation_gain(wavelet, extended);
  const double largest = gain * std::max(std::abs(range.min), std::abs(range.max));
  require_headroom<T>(wavelet, {-largest, largest}, options.levels);
  volume::Volume c0;
  c0.grid = extended_volume<T>(volume, extended, options.extension);
  coefficients_through_voxels(wavelet, extended, std::get<volume::Grid<T>>(c0.grid).voxels);
  options.initialisation = Initialisation::samples;
  Decomposition<T> result = analyze<T>(c0, options, {-largest, largest});
  result.initialisation = Initialisation::interpolate;
  result.geometry = volume.geometry();
  result.voxel_type = volume.voxel_type();
  result.range = range;
  return result;
}

}  // namespace

template <class T>
Decomposition<T> analyze(const volume::Volume& volume, const DwtOptions& options,
                         const volume::Range& range) {
  volume.geometry().validate();
  if (options.initialisation == Initialisation::interpolate) {
    return analyze_interpolating<T>(volume, options, range);
  }
  const Wavelet wavelet = make_wavelet(options.wavelet);
  Decomposition<T> result;
  result.wavelet = wavelet.name;
  result.levels = options.levels;
  result.boundary = options.boundary;
  result.extension = options.extension;
  result.geometry = volume.geometry();
  result.extended_dims = extended_dims(volume.geometry().dims, options.levels);
  result.voxel_type = volume.voxel_type();
  result.range = range;
  require_headroom<T>(wavelet, range, options.levels);
  const auto ranges = layout(wavelet, options.boundary, result.extended_dims, options.levels);

  RowSource<T> source = rows_of<T>(volume);
  if (options.levels == 0) {
    result.subbands.push_back(make_subband<T>(0, 0, ranges[0]));
    T* to = result.subbands[0].coefficients.data();
    const auto row = static_cast<std::size_t>(source.dims[0]) * source.element_size;
    for (std::int64_t r = 0; r < source.dims[1] * source.dims[2]; ++r, to += source.dims[0]) {
      const std::byte* from = source.data + static_cast<std::size_t>(r) * row;
      if (source.convert != nullptr) {
        source.convert(from, source.dims[0], to);
      } else {
        std::copy_n(reinterpret_cast<const T*>(from), source.dims[0], to);
      }
    }
    return result;
  }

  Subband<T> approximation;  // of the level below; the volume itself at first
  for (int level = 1; level <= options.levels; ++level) {
    const auto& in = ranges[static_cast<std::size_t>(level) - 1];
    const auto& out = ranges[static_cast<std::size_t>(level)];
    std::array<AnalysisAxis<T>, 3> axes;
    for (std::size_t a = 0; a < 3; ++a) {
      axes[a] = analysis_axis<T>(wavelet, options.boundary, options.extension, in[a], out[a], source.dims[a],
                                 result.extended_dims[a] > 1);
    }
    std::array<T*, 8> bands{};
    Subband<T> next = make_subband<T>(level, 0, out);
    bands[0] = next.coefficients.data();
    for (int o = 7; o > 0; --o) {  // finest last and orientations rising once reversed
      if (!exists(o, result.extended_dims)) continue;
      result.subbands.push_back(make_subband<T>(level, o, out));
      bands[static_cast<std::size_t>(o)] = result.subbands.back().coefficients.data();
    }
    analyze_level(source, axes, bands);
    approximation = std::move(next);
    source = {reinterpret_cast<const std::byte*>(approximation.coefficients.data()), approximation.dims,
              sizeof(T), nullptr};
  }
  result.subbands.push_back(std::move(approximation));
  std::reverse(result.subbands.begin(), result.subbands.end());
  return result;
}

namespace {

/// c0, the first `dims` of the extended box.
template <class T>
Buffer<T> rebuilt(const Decomposition<T>& d, const Dims& dims) {
  const Wavelet wavelet = make_wavelet(d.wavelet);
  const auto ranges = layout(wavelet, d.boundary, d.extended_dims, d.levels);
  const auto find = [&](int level, int orientation) -> const T* {
    for (const auto& band : d.subbands) {
      if (band.level == level && band.orientation == orientation) return band.coefficients.data();
    }
    return nullptr;
  };

  const T* approximation = find(d.levels, 0);
  if (d.levels == 0) return {approximation, approximation + d.geometry.count()};
  Buffer<T> below;
  for (int level = d.levels; level >= 1; --level) {
    const auto& out = ranges[static_cast<std::size_t>(level) - 1];
    const auto& in = ranges[static_cast<std::size_t>(level)];
    std::array<SynthesisAxis<T>, 3> axes;
    std::int64_t count = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t wanted = level == 1 ? dims[a] : out[a].count;  // what was added is cut here
      axes[a] = synthesis_axis<T>(wavelet, d.boundary, out[a], in[a], wanted, d.extended_dims[a] > 1);
      count *= wanted;
    }
    std::array<const T*, 8> bands{};
    bands[0] = approximation;
    for (int o = 1; o < 8; ++o) bands[static_cast<std::size_t>(o)] = find(level, o);
    Buffer<T> to = fresh_buffer<T>(count);
    synthesize_level(bands, axes, to.data());
    below = std::move(to);
    approximation = below.data();
  }
  return below;
}

}  // namespace

template <class T>
volume::Grid<T> synthesize(const Decomposition<T>& d) {
  validate(d);
  if (d.initialisation == Initialisation::samples) return {d.geometry, rebuilt(d, d.geometry.dims)};
  require_interpolation(make_wavelet(d.wavelet), d.boundary);  // a file may say what analyze() never makes
  const Dims &extended = d.extended_dims, &dims = d.geometry.dims;
  Buffer<T> box = rebuilt(d, extended);
  values_at_voxels(make_wavelet(d.wavelet), extended, box);
  if (extended == dims) return {d.geometry, std::move(box)};
  volume::Grid<T> result{d.geometry, fresh_buffer<T>(d.geometry.count())};
  T* to = result.voxels.data();
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j, to += dims[0]) {
      std::copy_n(box.data() + (k * extended[1] + j) * extended[0], dims[0], to);
    }
  }
  return result;
}

template Decomposition<float> analyze(const volume::Volume&, const DwtOptions&, const volume::Range&);
template Decomposition<double> analyze(const volume::Volume&, const DwtOptions&, const volume::Range&);
template volume::Grid<float> synthesize(const Decomposition<float>&);
template volume::Grid<double> synthesize(const Decomposition<double>&);

}  // namespace vol::wavelet
