#include "fourier/fft.h"

#include <fftw3.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>

#include "base/error.h"

namespace vol::fourier {
namespace {

template <class T>
struct Fftw;

template <>
struct Fftw<float> {
  using Plan = fftwf_plan;
  using Complex = fftwf_complex;
  static constexpr auto dft = fftwf_plan_dft_1d;
  static constexpr auto r2c = fftwf_plan_dft_r2c_1d;
  static constexpr auto c2r = fftwf_plan_dft_c2r_1d;
  static constexpr auto execute_dft = fftwf_execute_dft;
  static constexpr auto execute_r2c = fftwf_execute_dft_r2c;
  static constexpr auto execute_c2r = fftwf_execute_dft_c2r;
  static constexpr auto destroy = fftwf_destroy_plan;
  static constexpr auto import_wisdom = fftwf_import_wisdom_from_filename;
  static constexpr auto export_wisdom = fftwf_export_wisdom_to_string;
};

template <>
struct Fftw<double> {
  using Plan = fftw_plan;
  using Complex = fftw_complex;
  static constexpr auto dft = fftw_plan_dft_1d;
  static constexpr auto r2c = fftw_plan_dft_r2c_1d;
  static constexpr auto c2r = fftw_plan_dft_c2r_1d;
  static constexpr auto execute_dft = fftw_execute_dft;
  static constexpr auto execute_r2c = fftw_execute_dft_r2c;
  static constexpr auto execute_c2r = fftw_execute_dft_c2r;
  static constexpr auto destroy = fftw_destroy_plan;
  static constexpr auto import_wisdom = fftw_import_wisdom_from_filename;
  static constexpr auto export_wisdom = fftw_export_wisdom_to_string;
};

unsigned flags(Planning planning) {
  return planning == Planning::measure ? FFTW_MEASURE : FFTW_ESTIMATE;
}

int narrow(std::int64_t n) {
  if (n < 1 || n > std::numeric_limits<int>::max()) {
    throw Error("a transform of " + std::to_string(n) + " points is beyond FFTW's sizes");
  }
  return static_cast<int>(n);
}

constexpr std::int64_t kSideBySide = 8;  // columns of float: a cache line of every row

/// Complex numbers from one column to the next where they stand side by side: aligned, and lines of columns
/// do not meet in one set of the cache.
template <class T>
std::int64_t pitch(std::int64_t length) {
  constexpr auto kLine = static_cast<std::int64_t>(64 / (2 * sizeof(T)));
  return (length + kLine - 1) / kLine * kLine + kLine;
}

/// Reals of one scratch for columns side by side, and for a row.
template <class T>
std::int64_t column_reals(std::int64_t length, std::int64_t columns) {
  return 2 * std::min(columns, kSideBySide) * pitch<T>(length);
}
std::int64_t row_reals(std::int64_t length) {
  return 2 * (length / 2 + 1);
}

/// This thread's own, at least `count` reals; two at once, told apart by `which`.
template <class T>
T* scratch(int which, std::int64_t count) {
  thread_local Buffer<T> buffers[2];
  auto& buffer = buffers[which];
  if (static_cast<std::int64_t>(buffer.size()) < count) {
    buffer = Buffer<T>();  // or both would be there at once
    buffer = Buffer<T>(static_cast<std::size_t>(count));
  }
  return buffer.data();
}

template <class T>
typename Fftw<T>::Complex* complex(T* data) {
  return reinterpret_cast<typename Fftw<T>::Complex*>(data);
}

}  // namespace

template <class T>
ColumnTransform<T>::ColumnTransform(std::int64_t length, bool forward, Planning planning) : length_(length) {
  const int n = narrow(length);
  plan_ = Fftw<T>::dft(n, complex(scratch<T>(0, 2 * length)), complex(scratch<T>(1, 2 * length)),
                       forward ? FFTW_FORWARD : FFTW_BACKWARD, flags(planning));
  if (plan_ == nullptr) throw Error("FFTW has no plan for " + std::to_string(length) + " points");
}

template <class T>
ColumnTransform<T>::~ColumnTransform() {
  Fftw<T>::destroy(static_cast<typename Fftw<T>::Plan>(plan_));
}

template <class T>
std::int64_t ColumnTransform<T>::scratch_bytes(std::int64_t length, std::int64_t columns) {
  return 2 * column_reals<T>(length, columns) * static_cast<std::int64_t>(sizeof(T));
}

template <class T>
void ColumnTransform<T>::run(T* data, std::int64_t columns, std::int64_t stride) const {
  struct Number {
    T re, im;
  };
  const std::int64_t apart = pitch<T>(length_);
  T* before = scratch<T>(0, column_reals<T>(length_, columns));
  T* after = scratch<T>(1, column_reals<T>(length_, columns));
  const auto batch = [&](std::int64_t first, auto count) {
    auto* place = reinterpret_cast<Number*>(data) + first;
    auto* from = reinterpret_cast<Number*>(before);
    for (std::int64_t i = 0; i < length_; ++i) {
      for (std::int64_t c = 0; c < count; ++c) from[c * apart + i] = place[i * stride + c];
    }
    for (std::int64_t c = 0; c < count; ++c) {
      Fftw<T>::execute_dft(static_cast<typename Fftw<T>::Plan>(plan_), complex(before + 2 * c * apart),
                           complex(after + 2 * c * apart));
    }
    const auto* to = reinterpret_cast<const Number*>(after);
    for (std::int64_t i = 0; i < length_; ++i) {
      for (std::int64_t c = 0; c < count; ++c) place[i * stride + c] = to[c * apart + i];
    }
  };
  std::int64_t c = 0;
  for (; c + kSideBySide <= columns; c += kSideBySide) {
    batch(c, std::integral_constant<std::int64_t, kSideBySide>{});  // loops unrolled
  }
  if (c < columns) batch(c, columns - c);
}

template <class T>
RowTransform<T>::RowTransform(std::int64_t length, bool forward, Planning planning)
    : length_(length), forward_(forward) {
  const int n = narrow(length);
  T* before = scratch<T>(0, row_reals(length));
  T* after = scratch<T>(1, row_reals(length));
  plan_ = forward ? Fftw<T>::r2c(n, before, complex(after), flags(planning))
                  : Fftw<T>::c2r(n, complex(before), after, flags(planning));
  if (plan_ == nullptr) throw Error("FFTW has no plan for " + std::to_string(length) + " points");
}

template <class T>
RowTransform<T>::~RowTransform() {
  Fftw<T>::destroy(static_cast<typename Fftw<T>::Plan>(plan_));
}

template <class T>
std::int64_t RowTransform<T>::scratch_bytes(std::int64_t length) {
  return 2 * row_reals(length) * static_cast<std::int64_t>(sizeof(T));
}

template <class T>
void RowTransform<T>::run(const T* from, T* to) const {
  const std::int64_t spectrum = row_reals(length_);
  T* before = scratch<T>(0, spectrum);
  T* after = scratch<T>(1, spectrum);
  const auto plan = static_cast<typename Fftw<T>::Plan>(plan_);
  std::copy_n(from, forward_ ? length_ : spectrum, before);
  if (forward_) {
    Fftw<T>::execute_r2c(plan, before, complex(after));
  } else {
    Fftw<T>::execute_c2r(plan, complex(before), after);
  }
  std::copy_n(after, forward_ ? spectrum : length_, to);
}

template <class T>
void read_wisdom(const std::filesystem::path& path) {
  if (Fftw<T>::import_wisdom(path.c_str()) == 0) {
    throw Error(path.string() + ": cannot be read as FFTW's wisdom of " + (sizeof(T) == 8 ? "f64" : "f32") +
                "; f32 and f64 each need a file of their own");
  }
}

template <class T>
std::string wisdom() {
  const std::unique_ptr<char, decltype(&std::free)> text(Fftw<T>::export_wisdom(), &std::free);
  if (!text) throw Error("FFTW does not give its wisdom");
  return text.get();
}

template class ColumnTransform<float>;
template class ColumnTransform<double>;
template class RowTransform<float>;
template class RowTransform<double>;
template void read_wisdom<float>(const std::filesystem::path&);
template void read_wisdom<double>(const std::filesystem::path&);
template std::string wisdom<float>();
template std::string wisdom<double>();

}  // namespace vol::fourier
