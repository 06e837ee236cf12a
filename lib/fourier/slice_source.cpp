#include "fourier/slice_source.h"

#include <algorithm>

#include "base/checked.h"
#include "base/heap.h"
#include "base/parallel.h"

namespace vol::fourier {
namespace {

constexpr std::int64_t kLineReals = 16;  // rows begin at a cache line where T is float

struct Extent {
  std::int64_t margin, half_y, half_z, row, slab;
};

Extent extent(const SpectrumInfo& info, int taps) {
  Extent e{};
  e.margin = taps / 2 + 1;
  e.half_y = info.padded[1] / 2 + e.margin;
  e.half_z = info.padded[2] / 2 + e.margin;
  const std::int64_t reals = 2 * (info.row_length() + 2 * e.margin);
  e.row = (reals + kLineReals - 1) / kLineReals * kLineReals;
  e.slab = checked_product(e.row, 2 * e.half_y + 1);
  return e;
}

/// Index k brought to [-floor(m/2), ceil(m/2)), and the sign that F takes on the way.
struct Wrapped {
  std::int64_t k;
  int sign;
};
Wrapped wrapped(std::int64_t k, std::int64_t n, std::int64_t m) {
  const std::int64_t shifted = k + m / 2;
  const std::int64_t turns = shifted >= 0 ? shifted / m : -((m - 1 - shifted) / m);
  return {k - turns * m, turns % 2 != 0 && n % 2 == 0 ? -1 : 1};
}

}  // namespace

template <class T>
std::int64_t SliceSource<T>::bytes(const SpectrumInfo& info, int taps) {
  const Extent e = extent(info, taps);
  const auto reals = checked_product(checked_product(e.slab, 2 * e.half_z + 1),
                                     static_cast<std::int64_t>(info.names.size()));
  return checked_product(reals, sizeof(T));
}

template <class T>
SliceSource<T>::SliceSource(const SpectrumInfo& info, int taps) : info_(info), taps_(taps) {
  info.validate();
  (void)bytes(info, taps);
  const Extent e = extent(info, taps);
  margin_ = e.margin;
  half_y_ = e.half_y;
  half_z_ = e.half_z;
  row_ = e.row;
  slab_ = e.slab;
  for (std::size_t f = 0; f < info.names.size(); ++f) {
    const auto reals = static_cast<std::size_t>(slab_ * (2 * half_z_ + 1));
    fields_.emplace_back(reals + kLineReals);
    // A slice touches a few numbers on each of thousands of pages.
    prefer_large_pages(fields_.back().data(), reals * sizeof(T));
    std::fill_n(fields_.back().begin() + reals, kLineReals, T{0});  // vectors run over the end, with weight 0
  }
}

template <class T>
void SliceSource<T>::fill_margins() {
  const Dims& n = info_.geometry.dims;
  const Dims& m = info_.padded;
  const std::int64_t length = info_.row_length();
  const auto for_all_rows = [&](const auto& work) {
    parallel_for(-half_z_, half_z_ + 1, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t kz = begin; kz < end; ++kz) {
        for (std::int64_t ky = -half_y_; ky <= half_y_; ++ky) work(ky, kz);
      }
    });
  };
  for (auto& field : fields_) {
    // Rows beyond the ends of y and z.
    for_all_rows([&](std::int64_t ky, std::int64_t kz) {
      const Wrapped y = wrapped(ky, n[1], m[1]), z = wrapped(kz, n[2], m[2]);
      if (y.k == ky && z.k == kz) return;
      const T sign = static_cast<T>(y.sign * z.sign);
      const T* from = field.data() + offset(0, y.k, z.k);
      T* to = field.data() + offset(0, ky, kz);
      for (std::int64_t i = 0; i < 2 * length; ++i) to[i] = sign * from[i];
    });
    // The margins of every row, from the rows' own part.
    for_all_rows([&](std::int64_t ky, std::int64_t kz) {
      T* row = field.data() + offset(0, ky, kz);
      const T* mirror = field.data() + offset(0, -ky, -kz);
      const auto fill = [&](std::int64_t kx) {
        const Wrapped x = wrapped(kx, n[0], m[0]);
        const T sign = static_cast<T>(x.sign);
        const T* from = x.k < 0 ? mirror - 2 * x.k : row + 2 * x.k;
        row[2 * kx] = sign * from[0];
        row[2 * kx + 1] = x.k < 0 ? -sign * from[1] : sign * from[1];
      };
      for (std::int64_t kx = -margin_; kx < 0; ++kx) fill(kx);
      std::int64_t kx = length;
      for (; kx < length + margin_; ++kx) fill(kx);
      std::fill(row + 2 * kx, row - 2 * margin_ + row_, T{0});  // read with a weight of 0
    });
  }
}

template <class T>
SliceSource<T> slice_source(const Spectrum<T>& spectrum, int taps) {
  SliceSource<T> source(spectrum.info, taps);
  const Dims& m = spectrum.info.padded;
  const std::int64_t reals = 2 * spectrum.info.row_length();
  for (std::size_t f = 0; f < spectrum.fields.size(); ++f) {
    parallel_for(0, m[2], 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t k = begin; k < end; ++k) {
        for (std::int64_t j = 0; j < m[1]; ++j) {
          std::copy_n(spectrum.fields[f].data() + (k * m[1] + j) * reals, reals,
                      source.row(f, j - m[1] / 2, k - m[2] / 2));
        }
      }
    });
  }
  source.fill_margins();
  return source;
}

template class SliceSource<float>;
template class SliceSource<double>;
template SliceSource<float> slice_source(const Spectrum<float>&, int);
template SliceSource<double> slice_source(const Spectrum<double>&, int);

}  // namespace vol::fourier
