#include "wavelet/synthesis_level.h"

#include <algorithm>
#include <cmath>

#include "base/buffer.h"
#include "base/parallel.h"
#include "wavelet/row_kernels.h"

namespace vol::wavelet {
namespace {

/// What a task works in: two planes after z, two rows after y with room for their periodic continuation, and
/// one row's even and odd samples after x.
template <class T>
class Task {
 public:
  Task(const std::array<const T*, 8>& bands, const std::array<SynthesisAxis<T>, 3>& axes, T* to,
       std::int64_t y_begin, std::int64_t y_end)
      : bands_(bands), x_(axes[0]), y_(axes[1]), z_(axes[2]), to_(to), y_begin_(y_begin), y_end_(y_end) {
    pitch_ = (x_.inputs * x_.bands() + 15) / 16 * 16 + 16;
    plane_rows_ = y_end - y_begin + y_.lags - 1;
    plane_size_ = y_.bands() * plane_rows_ * pitch_;
    planes_.resize(static_cast<std::size_t>(2 * plane_size_));
    before_ = std::max<std::int64_t>(0, x_.lags - 1 - x_.origin);
    after_ = std::max<std::int64_t>(0, x_.origin + x_.pairs - x_.inputs);
    padded_ = before_ + x_.inputs + after_;
    pair_.resize(static_cast<std::size_t>(2 * x_.bands() * padded_));
    even_odd_.resize(static_cast<std::size_t>(2 * x_.pairs));
    rows_.resize(std::max({x_.terms.size(), y_.terms.size(), z_.terms.size()}));
  }

  void run(std::int64_t z_begin, std::int64_t z_end) {
    for (std::int64_t t = z_begin; t < z_end; ++t) {
      combine_z(t);
      for (int p = 0; p < 2; ++p) {
        const std::int64_t z = z_.first_sample + 2 * t + p;
        if (z >= 0 && z < z_.outputs) combine_plane(planes_.data() + p * plane_size_, z);
      }
    }
  }

 private:
  void combine_z(std::int64_t t) {
    for (int by = 0; by < y_.bands(); ++by) {
      for (std::int64_t r = 0; r < plane_rows_; ++r) {
        const std::int64_t y = y_.source[static_cast<std::size_t>(y_begin_ + r)];
        T* even = planes_.data() + (by * plane_rows_ + r) * pitch_;
        for (int bx = 0; bx < x_.bands(); ++bx) {
          for (std::size_t i = 0; i < z_.terms.size(); ++i) {
            const auto& term = z_.terms[i];
            const std::int64_t z = z_.source[static_cast<std::size_t>(t - term.lag + z_.lags - 1)];
            rows_[i] = bands_[static_cast<std::size_t>(bx + 2 * by + 4 * term.band)] +
                       (z * y_.inputs + y) * x_.inputs;
          }
          T* to = even + bx * x_.inputs;
          combine(rows_.data(), z_.even.data(), z_.odd.data(), static_cast<int>(z_.terms.size()), x_.inputs,
                  to, z_.transformed ? to + plane_size_ : nullptr);
        }
      }
    }
  }

  void combine_plane(const T* plane, std::int64_t z) {
    for (std::int64_t t = y_begin_; t < y_end_; ++t) {
      for (int bx = 0; bx < x_.bands(); ++bx) {
        for (std::size_t i = 0; i < y_.terms.size(); ++i) {
          const auto& term = y_.terms[i];
          const std::int64_t r = t - y_begin_ - term.lag + y_.lags - 1;
          rows_[i] = plane + (term.band * plane_rows_ + r) * pitch_ + bx * x_.inputs;
        }
        T* to = pair_.data() + bx * padded_ + before_;
        combine(rows_.data(), y_.even.data(), y_.odd.data(), static_cast<int>(y_.terms.size()), x_.inputs, to,
                y_.transformed ? to + x_.bands() * padded_ : nullptr);
      }
      for (int p = 0; p < 2; ++p) {
        const std::int64_t y = y_.first_sample + 2 * t + p;
        if (y >= 0 && y < y_.outputs) {
          combine_row(pair_.data() + p * x_.bands() * padded_, to_ + (z * y_.outputs + y) * x_.outputs);
        }
      }
    }
  }

  void combine_row(T* row, T* to) {
    for (int b = 0; b < x_.bands(); ++b) {
      T* c = row + b * padded_ + before_;
      const auto continued =
          [&](std::int64_t k) {  // coefficient k of the padded row, outside the stored ones
            c[k] = c[x_.source[static_cast<std::size_t>(k - x_.origin + x_.lags - 1)]];
          };
      for (std::int64_t k = x_.origin - (x_.lags - 1); k < 0; ++k) continued(k);
      for (std::int64_t k = x_.inputs; k < x_.origin + x_.pairs; ++k) continued(k);
    }
    for (std::size_t i = 0; i < x_.terms.size(); ++i) {
      rows_[i] = row + x_.terms[i].band * padded_ + before_ + x_.origin - x_.terms[i].lag;
    }
    T* even = even_odd_.data();
    T* odd = even + x_.pairs;
    combine(rows_.data(), x_.even.data(), x_.odd.data(), static_cast<int>(x_.terms.size()), x_.pairs, even,
            x_.transformed ? odd : nullptr);
    if (x_.first_sample < 0) {  // the first sample is the odd one of pair 0
      *to++ = *odd++;
      ++even;
    }
    const std::int64_t left = x_.outputs + x_.first_sample;
    interleave(even, odd, left / 2, to);
    if (left % 2 == 1) to[left - 1] = even[left / 2];
  }

  const std::array<const T*, 8>& bands_;
  const SynthesisAxis<T>&x_, &y_, &z_;
  T* to_;
  std::int64_t y_begin_, y_end_;
  std::int64_t pitch_, plane_rows_, plane_size_, before_, after_, padded_;
  Buffer<T> planes_, pair_, even_odd_;
  std::vector<const T*> rows_;
};

std::int64_t floor_half(std::int64_t x) {
  return x >= 0 ? x / 2 : -((1 - x) / 2);
}

}  // namespace

template <class T>
SynthesisAxis<T> synthesis_axis(const Wavelet& wavelet, Boundary boundary, const IndexRange& out,
                                const IndexRange& in, std::int64_t wanted, bool transformed) {
  SynthesisAxis<T> axis;
  axis.transformed = transformed;
  axis.inputs = in.count;
  axis.outputs = wanted;
  if (!transformed) {
    axis.terms = {{0, 0}};
    axis.even = {1};
    axis.odd = {0};
    axis.source = {0};
    return axis;
  }
  const FilterBank bank =
      boundary == Boundary::periodic ? periodised(wavelet, out.count, kTail<T>) : wavelet.bank;
  axis.lags = bank.taps() / 2;
  const std::int64_t t_first = floor_half(out.lower - bank.first);
  const std::int64_t t_last = floor_half(out.lower + wanted - 1 - bank.first);
  axis.pairs = t_last - t_first + 1;
  axis.first_sample = 2 * t_first + bank.first - out.lower;
  axis.origin = t_first - in.lower;
  for (std::int64_t k = axis.origin - (axis.lags - 1); k < axis.origin + axis.pairs; ++k) {
    // For the symmetric boundary every coefficient that is needed is stored; only the padding goes beyond.
    axis.source.push_back(boundary == Boundary::periodic ? wrapped_index(boundary, k, in.count) : k);
  }
  for (int band = 0; band < 2; ++band) {
    for (std::int64_t j = 0; j < axis.lags; ++j) axis.terms.push_back({band, j});
  }
  const auto factor = [&](const typename SynthesisAxis<T>::Term& t, int p) {
    return (t.band == 0 ? bank.h : bank.g)[static_cast<std::size_t>(2 * t.lag + p)];
  };
  const auto weight = [&](const auto& t) { return std::abs(factor(t, 0)) + std::abs(factor(t, 1)); };
  std::stable_sort(axis.terms.begin(), axis.terms.end(),
                   [&](const auto& a, const auto& b) { return weight(a) < weight(b); });
  for (const auto& t : axis.terms) {
    axis.even.push_back(static_cast<T>(factor(t, 0)));
    axis.odd.push_back(static_cast<T>(factor(t, 1)));
  }
  return axis;
}

template <class T>
void synthesize_level(const std::array<const T*, 8>& bands, const std::array<SynthesisAxis<T>, 3>& axes,
                      T* to) {
  const auto& [x, y, z] = axes;
  // The coefficients of `lags` planes in all bands are what a task should find in the cache again.
  const std::int64_t row_bytes =
      x.inputs * x.bands() * y.bands() * z.bands() * z.lags * static_cast<std::int64_t>(sizeof(T));
  const std::int64_t tile_y =
      std::max(std::min<std::int64_t>(kScratchBytes / row_bytes, 64), std::max<std::int64_t>(16, 2 * y.lags));
  const std::int64_t tiles_y = (y.pairs + tile_y - 1) / tile_y;
  const std::int64_t tiles_z = (z.pairs + 31) / 32;  // slabs share nothing but reads
  parallel_for(0, tiles_y * tiles_z, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t tile = begin; tile < end; ++tile) {
      const std::int64_t ty = tile % tiles_y, tz = tile / tiles_y;
      Task<T>(bands, axes, to, tile_begin(ty, tiles_y, y.pairs), tile_begin(ty + 1, tiles_y, y.pairs))
          .run(tile_begin(tz, tiles_z, z.pairs), tile_begin(tz + 1, tiles_z, z.pairs));
    }
  });
}

template SynthesisAxis<float> synthesis_axis(const Wavelet&, Boundary, const IndexRange&, const IndexRange&,
                                             std::int64_t, bool);
template SynthesisAxis<double> synthesis_axis(const Wavelet&, Boundary, const IndexRange&, const IndexRange&,
                                              std::int64_t, bool);
template void synthesize_level(const std::array<const float*, 8>&, const std::array<SynthesisAxis<float>, 3>&,
                               float*);
template void synthesize_level(const std::array<const double*, 8>&,
                               const std::array<SynthesisAxis<double>, 3>&, double*);

}  // namespace vol::wavelet
