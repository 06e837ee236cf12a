#include "wavelet/analysis_level.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/buffer.h"
#include "base/parallel.h"
#include "wavelet/row_kernels.h"

namespace vol::wavelet {
namespace {

/// What a task works in: one row split into even and odd positions, the rows of one plane after x, and the
/// ring of planes after x and y.
template <class T>
class Task {
 public:
  Task(const RowSource<T>& source, const std::array<AnalysisAxis<T>, 3>& axes, const std::array<T*, 8>& bands,
       std::int64_t y_begin, std::int64_t y_end)
      : source_(source),
        x_(axes[0]),
        y_(axes[1]),
        z_(axes[2]),
        bands_(bands),
        y_begin_(y_begin),
        y_end_(y_end) {
    width_ = x_.outputs * x_.bands();
    pitch_ =
        (width_ + 15) / 16 * 16 + 16;  // an odd number of cache lines: rows of a power of two share no set
    half_ = static_cast<std::int64_t>(x_.source.size()) / 2 + 1;
    plane_rows_ = 2 * (y_end - y_begin - 1) + y_.taps();
    // An odd number of cache lines apart, too: the planes of a long filter would meet in a few sets of the
    // cache.
    slot_size_ = (y_end - y_begin) * y_.bands() * pitch_ +
                 ((y_end - y_begin) * y_.bands() * pitch_ / 16 % 2 == 0 ? 16 : 0);
    even_odd_.resize(static_cast<std::size_t>(2 * half_));
    raw_.resize(static_cast<std::size_t>(source.convert != nullptr ? source.dims[0] : 0));
    plane_.resize(static_cast<std::size_t>(plane_rows_ * pitch_));
    ring_.resize(static_cast<std::size_t>(z_.taps() * slot_size_));
    rows_.resize(static_cast<std::size_t>(std::max(y_.taps(), z_.taps())));
    planes_.resize(static_cast<std::size_t>(z_.taps()));
    for (const std::int64_t n : x_.offset) shifts_.push_back(even_odd_.data() + n % 2 * half_ + n / 2);
  }

  void run(std::int64_t z_begin, std::int64_t z_end) {
    const std::int64_t last = 2 * (z_end - 1) + z_.taps() - 1;
    for (std::int64_t p = 2 * z_begin; p <= last; ++p) {
      filter_plane_x(z_.source[static_cast<std::size_t>(p)]);
      filter_plane_y(slot(p));
      const std::int64_t k2 = p - (z_.taps() - 1);
      if (k2 >= 2 * z_begin && k2 % 2 == 0) filter_z(k2 / 2);
    }
  }

 private:
  T* slot(std::int64_t position) { return ring_.data() + position % z_.taps() * slot_size_; }

  void filter_plane_x(std::int64_t z) {
    for (std::int64_t r = 0; r < plane_rows_; ++r) {
      T* to = plane_.data() + r * pitch_;
      const std::int64_t y = y_.source[static_cast<std::size_t>(2 * y_begin_ + r)];
      if (y < 0 || z < 0) {
        std::fill(to, to + width_, T{0});
      } else {
        split_row(y, z);
        combine(shifts_.data(), x_.h.data(), x_.g.data(), static_cast<int>(x_.taps()), x_.outputs, to,
                x_.transformed ? to + x_.outputs : nullptr);
      }
    }
  }

  /// Row (y, z), extended on both sides, as its even and its odd positions.
  void split_row(std::int64_t y, std::int64_t z) {
    const std::int64_t n = source_.dims[0];
    const std::byte* from =
        source_.data + static_cast<std::size_t>((z * source_.dims[1] + y) * n) * source_.element_size;
    const T* row = reinterpret_cast<const T*>(from);
    if (source_.convert != nullptr) {
      source_.convert(from, n, raw_.data());
      row = raw_.data();
    }
    T* even = even_odd_.data();
    T* odd = even + half_;
    const std::int64_t begin = x_.interior;
    const auto positions = static_cast<std::int64_t>(x_.source.size());
    if (begin % 2 == 0) {
      deinterleave(row, n, even + begin / 2, odd + begin / 2);
    } else {
      deinterleave(row, n, odd + begin / 2, even + begin / 2 + 1);
    }
    const auto gather = [&](std::int64_t p) {
      const std::int64_t s = x_.source[static_cast<std::size_t>(p)];
      // In one expression g++ 12 loses the index under -fsanitize=undefined.
      T* parity = p % 2 == 0 ? even : odd;
      parity[p / 2] = s < 0 ? T{0} : row[s];
    };
    for (std::int64_t p = 0; p < begin; ++p) gather(p);
    for (std::int64_t p = begin + n; p < positions; ++p) gather(p);
  }

  void filter_plane_y(T* to) {
    for (std::int64_t k = 0; k < y_end_ - y_begin_; ++k) {
      for (std::size_t t = 0; t < y_.h.size(); ++t)
        rows_[t] = plane_.data() + (2 * k + y_.offset[t]) * pitch_;
      T* low = to + k * y_.bands() * pitch_;
      combine(rows_.data(), y_.h.data(), y_.g.data(), static_cast<int>(y_.taps()), width_, low,
              y_.transformed ? low + pitch_ : nullptr);
    }
  }

  void filter_z(std::int64_t kz) {
    for (std::size_t t = 0; t < z_.h.size(); ++t) planes_[t] = slot(2 * kz + z_.offset[t]);
    for (std::int64_t ky = y_begin_; ky < y_end_; ++ky) {
      const std::int64_t to = (kz * y_.outputs + ky) * x_.outputs;
      for (int by = 0; by < y_.bands(); ++by) {
        for (int bx = 0; bx < x_.bands(); ++bx) {
          const std::int64_t from = ((ky - y_begin_) * y_.bands() + by) * pitch_ + bx * x_.outputs;
          for (std::size_t t = 0; t < z_.h.size(); ++t) rows_[t] = planes_[t] + from;
          const auto band = static_cast<std::size_t>(bx + 2 * by);
          combine(rows_.data(), z_.h.data(), z_.g.data(), static_cast<int>(z_.taps()), x_.outputs,
                  bands_[band] + to, z_.transformed ? bands_[band + 4] + to : nullptr);
        }
      }
    }
  }

  const RowSource<T>& source_;
  const AnalysisAxis<T>&x_, &y_, &z_;
  const std::array<T*, 8>& bands_;
  std::int64_t y_begin_, y_end_;
  std::int64_t width_, pitch_, half_, plane_rows_, slot_size_;
  Buffer<T> even_odd_, raw_, plane_, ring_;
  std::vector<const T*> rows_, planes_, shifts_;  // of the taps: any row, the ring's planes, the split row
};

}  // namespace

template <class T>
AnalysisAxis<T> analysis_axis(const Wavelet& wavelet, Boundary boundary, Extension extension,
                              const IndexRange& in, const IndexRange& out, std::int64_t stored,
                              bool transformed) {
  AnalysisAxis<T> axis;
  axis.transformed = transformed;
  axis.outputs = out.count;
  FilterBank bank{0, {1}, {0}};
  if (transformed)
    bank = boundary == Boundary::periodic ? periodised(wavelet, in.count, kTail<T>) : wavelet.bank;

  axis.offset.resize(bank.h.size());
  std::iota(axis.offset.begin(), axis.offset.end(), 0);
  const auto weight = [&](std::int64_t n) {
    return std::abs(bank.h[static_cast<std::size_t>(n)]) + std::abs(bank.g[static_cast<std::size_t>(n)]);
  };
  std::stable_sort(axis.offset.begin(), axis.offset.end(),
                   [&](std::int64_t a, std::int64_t b) { return weight(a) < weight(b); });
  for (const auto n : axis.offset) {
    axis.h.push_back(static_cast<T>(bank.h[static_cast<std::size_t>(n)]));
    axis.g.push_back(static_cast<T>(bank.g[static_cast<std::size_t>(n)]));
  }

  const std::int64_t start = 2 * out.lower + bank.first;
  axis.interior = in.lower - start;
  const std::int64_t positions = std::max(2 * (out.count - 1) + bank.taps(), axis.interior + stored);
  for (std::int64_t p = 0; p < positions; ++p) {
    const std::int64_t inside = wrapped_index(boundary, p - axis.interior, in.count);
    axis.source.push_back(extension_source(extension, inside, stored));
  }
  return axis;
}

template <class T>
void analyze_level(const RowSource<T>& source, const std::array<AnalysisAxis<T>, 3>& axes,
                   const std::array<T*, 8>& bands) {
  const auto& [x, y, z] = axes;
  // A longer tile repeats less of its neighbours' work (taps - 2 rows or planes), a shorter one keeps its
  // ring of planes in the cache and leaves tasks for more threads.
  const std::int64_t row_bytes = x.outputs * x.bands() * y.bands() * static_cast<std::int64_t>(sizeof(T));
  const std::int64_t fitting = kScratchBytes / std::max<std::int64_t>(1, z.taps() * row_bytes);
  const std::int64_t tile_y =
      std::max(std::min<std::int64_t>(fitting, 64), std::max<std::int64_t>(16, y.taps()));
  const std::int64_t tile_z = std::max<std::int64_t>(32, 2 * z.taps());
  const std::int64_t tiles_y = (y.outputs + tile_y - 1) / tile_y;
  const std::int64_t tiles_z = (z.outputs + tile_z - 1) / tile_z;
  parallel_for(0, tiles_y * tiles_z, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t tile = begin; tile < end; ++tile) {
      const std::int64_t ty = tile % tiles_y, tz = tile / tiles_y;
      Task<T>(source, axes, bands, tile_begin(ty, tiles_y, y.outputs), tile_begin(ty + 1, tiles_y, y.outputs))
          .run(tile_begin(tz, tiles_z, z.outputs), tile_begin(tz + 1, tiles_z, z.outputs));
    }
  });
}

template AnalysisAxis<float> analysis_axis(const Wavelet&, Boundary, Extension, const IndexRange&,
                                           const IndexRange&, std::int64_t, bool);
template AnalysisAxis<double> analysis_axis(const Wavelet&, Boundary, Extension, const IndexRange&,
                                            const IndexRange&, std::int64_t, bool);
template void analyze_level(const RowSource<float>&, const std::array<AnalysisAxis<float>, 3>&,
                            const std::array<float*, 8>&);
template void analyze_level(const RowSource<double>&, const std::array<AnalysisAxis<double>, 3>&,
                            const std::array<double*, 8>&);

}  // namespace vol::wavelet
