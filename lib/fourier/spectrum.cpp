#include "fourier/spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/checked.h"
#include "base/error.h"
#include "base/parallel.h"
#include "transfer/bezier.h"

namespace vol::fourier {
namespace {

/// exp(sign 2 pi i k c / M), for k = first, first + 1, ...; the angle is reduced exactly: 2 k c is whole.
std::vector<std::complex<double>> phases(std::int64_t first, std::int64_t count, std::int64_t n,
                                         std::int64_t m, int sign) {
  std::vector<std::complex<double>> result(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t turns = ((first + i) * (n - 1)) % (2 * m);  // of half a turn over m
    result[i] =
        std::polar(1.0, sign * std::numbers::pi * static_cast<double>(turns) / static_cast<double>(m));
  }
  return result;
}

std::vector<double> axis_compensation(const Filter& filter, std::int64_t n, std::int64_t m) {
  std::vector<double> result(static_cast<std::size_t>(n));
  for (std::int64_t i = 0; i < n; ++i) {
    const double w = filter.transform((static_cast<double>(i) - 0.5 * static_cast<double>(n - 1)) /
                                      static_cast<double>(m));
    if (!(std::abs(w) > 1e-12)) {
      throw Error("filter " + filter.name() + " lets nothing through at the volume's rim; use more padding");
    }
    result[i] = 1 / w;
  }
  return result;
}

/// (-1)^i where a change of sign from sample to sample centres the spectrum, which it does for an even size.
double centring_sign(std::int64_t i, std::int64_t m) {
  return m % 2 == 0 && i % 2 != 0 ? -1.0 : 1.0;
}

/// Sizes of a spectrum and its strides, in real numbers.
struct Layout {
  Dims n, m;
  std::int64_t row, slab;
  explicit Layout(const SpectrumInfo& info)
      : n(info.geometry.dims), m(info.padded), row(2 * info.row_length()), slab(row * m[1]) {}
};

/// Brings rows (stride `row`) from FFT order to centred order, or back. For odd sizes only: even ones are
/// centred by signs.
template <class T>
void rotate_rows(T* slab, std::int64_t rows, std::int64_t row, bool to_centred) {
  const std::int64_t shift = to_centred ? rows - rows / 2 : rows / 2;  // the row that becomes the first
  std::rotate(slab, slab + shift * row, slab + rows * row);
}

/// The same along z, for the rows at one y.
template <class T>
void rotate_slabs(T* rows, const Layout& l, bool to_centred) {
  const std::int64_t shift = to_centred ? l.m[2] - l.m[2] / 2 : l.m[2] / 2;
  std::vector<T> copy(static_cast<std::size_t>(l.row * l.m[2]));
  for (std::int64_t k = 0; k < l.m[2]; ++k) std::copy_n(rows + k * l.slab, l.row, copy.data() + k * l.row);
  for (std::int64_t k = 0; k < l.m[2]; ++k) {
    std::copy_n(copy.data() + (k + shift) % l.m[2] * l.row, l.row, rows + k * l.slab);
  }
}

/// Multiplies the rows at one y, index j, by the phase of the volume's centre; false where a number is not
/// finite.
template <class T>
bool apply_phase(T* rows, const Layout& l, std::int64_t j, int sign) {
  const auto px = phases(0, l.row / 2, l.n[0], l.m[0], sign);
  const auto py = phases(j - l.m[1] / 2, 1, l.n[1], l.m[1], sign);
  const auto pz = phases(-(l.m[2] / 2), l.m[2], l.n[2], l.m[2], sign);
  std::vector<T> phase(static_cast<std::size_t>(l.row));
  T poison = 0;  // stays 0 unless something is not finite
  for (std::int64_t k = 0; k < l.m[2]; ++k) {
    for (std::size_t i = 0; i < px.size(); ++i) {
      const auto p = px[i] * py[0] * pz[k];
      phase[2 * i] = static_cast<T>(p.real());
      phase[2 * i + 1] = static_cast<T>(p.imag());
    }
    T* row = rows + k * l.slab;
    for (std::int64_t i = 0; i < l.row; i += 2) {
      const T re = row[i], im = row[i + 1];
      row[i] = re * phase[i] - im * phase[i + 1];
      row[i + 1] = re * phase[i + 1] + im * phase[i];
      poison += (re + im) * 0;
    }
  }
  return poison == 0;
}

void require_finite(const std::vector<char>& parts, const char* else_say) {
  if (std::find(parts.begin(), parts.end(), 0) != parts.end()) throw Error(else_say);
}

}  // namespace

Compensation compensation(const Filter& filter, const Dims& dims, const Dims& padded) {
  Compensation c{axis_compensation(filter, dims[0], padded[0]), axis_compensation(filter, dims[1], padded[1]),
                 axis_compensation(filter, dims[2], padded[2])};
  const auto largest = [](const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); };
  c.largest = largest(c.x) * largest(c.y) * largest(c.z);
  return c;
}

namespace {

Compensation compensation_of(const SpectrumInfo& info) {
  if (info.compensation != "none") {
    return compensation(Filter(info.compensation, info.padding), info.geometry.dims, info.padded);
  }
  const Dims& n = info.geometry.dims;
  const auto ones = [](std::int64_t count) {
    return std::vector<double>(static_cast<std::size_t>(count), 1.0);
  };
  return {ones(n[0]), ones(n[1]), ones(n[2])};
}

template <class T>
Buffer<T> transform_field(const SpectrumInfo& info, const RowSource& source, Planning planning) {
  const Layout l(info);
  const Compensation c = compensation_of(info);
  const RowTransform<T> along_x(l.m[0], true, planning);
  const ColumnTransform<T> along_y(l.m[1], true, planning), along_z(l.m[2], true, planning);
  Buffer<T> data(static_cast<std::size_t>(l.slab * l.m[2]));

  parallel_for(0, l.m[2], 1, [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> samples(static_cast<std::size_t>(l.n[0]));
    for (std::int64_t k = begin; k < end; ++k) {
      T* slab = data.data() + k * l.slab;
      std::fill(k < l.n[2] ? slab + l.n[1] * l.row : slab, slab + l.slab, T{0});
      if (k >= l.n[2]) continue;
      for (std::int64_t j = 0; j < l.n[1]; ++j) {
        source(j, k, samples);
        T* row = slab + j * l.row;
        const double yz = c.y[j] * c.z[k] * centring_sign(j, l.m[1]) * centring_sign(k, l.m[2]);
        for (std::int64_t i = 0; i < l.n[0]; ++i) row[i] = static_cast<T>(samples[i] * c.x[i] * yz);
        std::fill(row + l.n[0], row + l.row, T{0});
        along_x.run(row);
      }
      along_y.run(slab, l.row / 2, l.row / 2);
      if (l.m[1] % 2 != 0) rotate_rows(slab, l.m[1], l.row, true);
    }
  });
  std::vector<char> finite(static_cast<std::size_t>(l.m[1]));
  parallel_for(0, l.m[1], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t j = begin; j < end; ++j) {
      T* rows = data.data() + j * l.row;
      along_z.run(rows, l.row / 2, l.slab / 2);
      if (l.m[2] % 2 != 0) rotate_slabs(rows, l, true);
      finite[j] = apply_phase(rows, l, j, +1) ? 1 : 0;
    }
  });
  require_finite(finite, "the spectrum overflows its type; scale the volume or use f64");
  return data;
}

}  // namespace

template <class T>
std::int64_t transform_scratch_bytes(const SpectrumInfo& info) {
  const Layout l(info);
  const std::int64_t columns = l.row / 2;
  const std::int64_t lines =
      std::max({RowTransform<T>::scratch_bytes(l.m[0]), ColumnTransform<T>::scratch_bytes(l.m[1], columns),
                ColumnTransform<T>::scratch_bytes(l.m[2], columns)});
  const std::int64_t copy =  // of rotate_slabs()
      l.m[2] % 2 != 0 ? checked_product(l.row * static_cast<std::int64_t>(sizeof(T)), l.m[2]) : 0;
  return checked_product(lines + copy, thread_count());
}
template std::int64_t transform_scratch_bytes<float>(const SpectrumInfo&);
template std::int64_t transform_scratch_bytes<double>(const SpectrumInfo&);

template <class T>
Spectrum<T> transform(const SpectrumInfo& info, const std::vector<RowSource>& sources, Planning planning) {
  info.validate();
  if (sources.size() != info.names.size()) throw Error("as many spectra as names are expected");
  Spectrum<T> result{info, {}};
  for (const auto& source : sources) result.fields.push_back(transform_field<T>(info, source, planning));
  return result;
}

template <class T>
volume::Grid<T> inverse(Spectrum<T>& spectrum, std::size_t field, Planning planning) {
  const Layout l(spectrum.info);
  const Compensation c = compensation_of(spectrum.info);
  const RowTransform<T> along_x(l.m[0], false, planning);
  const ColumnTransform<T> along_y(l.m[1], false, planning), along_z(l.m[2], false, planning);
  Buffer<T>& data = spectrum.fields.at(field);
  std::vector<char> finite(static_cast<std::size_t>(std::max(l.m[1], l.n[2])), 1);
  parallel_for(0, l.m[1], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t j = begin; j < end; ++j) {
      T* rows = data.data() + j * l.row;
      finite[j] = apply_phase(rows, l, j, -1) ? 1 : 0;
      if (l.m[2] % 2 != 0) rotate_slabs(rows, l, false);
      along_z.run(rows, l.row / 2, l.slab / 2);
    }
  });
  require_finite(finite, "the spectrum holds a number that is not finite");
  volume::Grid<T> grid{spectrum.info.geometry, Buffer<T>(static_cast<std::size_t>(l.n[0] * l.n[1] * l.n[2]))};
  const double scale =
      1 / (static_cast<double>(l.m[0]) * static_cast<double>(l.m[1]) * static_cast<double>(l.m[2]));
  parallel_for(0, l.n[2], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      T* slab = data.data() + k * l.slab;
      if (l.m[1] % 2 != 0) rotate_rows(slab, l.m[1], l.row, false);
      along_y.run(slab, l.row / 2, l.row / 2);
      for (std::int64_t j = 0; j < l.n[1]; ++j) {
        T* row = slab + j * l.row;
        along_x.run(row);
        const double yz = scale * centring_sign(j, l.m[1]) * centring_sign(k, l.m[2]) / (c.y[j] * c.z[k]);
        T poison = 0;
        for (std::int64_t i = 0; i < l.n[0]; ++i) {
          const T value = static_cast<T>(row[i] * (yz / c.x[i]));
          grid(i, j, k) = value;
          poison += value * 0;
        }
        if (!(poison == 0)) finite[k] = 0;
      }
    }
  });
  require_finite(finite, "the volume overflows its type; make the spectrum as f64");
  return grid;
}

template Spectrum<float> transform(const SpectrumInfo&, const std::vector<RowSource>&, Planning);
template Spectrum<double> transform(const SpectrumInfo&, const std::vector<RowSource>&, Planning);
template volume::Grid<float> inverse(Spectrum<float>&, std::size_t, Planning);
template volume::Grid<double> inverse(Spectrum<double>&, std::size_t, Planning);

}  // namespace vol::fourier
