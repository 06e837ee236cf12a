#include "fourier/fft.h"

#include <fftw3.h>

#include <cstdlib>
#include <limits>
#include <memory>
#include <string>

#include "base/error.h"

namespace vol::fourier {
namespace {

template <class T>
struct Fftw;

template <>
struct Fftw<float> {
  using Plan = fftwf_plan;
  using Complex = fftwf_complex;
  static constexpr auto many_dft = fftwf_plan_many_dft;
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
  static constexpr auto many_dft = fftw_plan_many_dft;
  static constexpr auto r2c = fftw_plan_dft_r2c_1d;
  static constexpr auto c2r = fftw_plan_dft_c2r_1d;
  static constexpr auto execute_dft = fftw_execute_dft;
  static constexpr auto execute_r2c = fftw_execute_dft_r2c;
  static constexpr auto execute_c2r = fftw_execute_dft_c2r;
  static constexpr auto destroy = fftw_destroy_plan;
  static constexpr auto import_wisdom = fftw_import_wisdom_from_filename;
  static constexpr auto export_wisdom = fftw_export_wisdom_to_string;
};

/// Rows start wherever the width puts them, so no plan may count on alignment: other codelets, other bits.
unsigned flags(Planning planning) {
  return FFTW_UNALIGNED | (planning == Planning::measure ? FFTW_MEASURE : FFTW_ESTIMATE);
}

int narrow(std::int64_t n) {
  if (n < 1 || n > std::numeric_limits<int>::max()) {
    throw Error("a transform of " + std::to_string(n) + " points is beyond FFTW's sizes");
  }
  return static_cast<int>(n);
}

}  // namespace

template <class T>
ColumnTransform<T>::ColumnTransform(std::int64_t length, std::int64_t columns, std::int64_t stride,
                                    bool forward, Planning planning) {
  const int n = narrow(length);
  // Measuring overwrites what it plans on; estimating touches nothing, and the address alone is not looked
  // at.
  Buffer<T> scratch(planning == Planning::measure ? static_cast<std::size_t>(2 * length * stride) : 2);
  auto* data = reinterpret_cast<typename Fftw<T>::Complex*>(scratch.data());
  plan_ = Fftw<T>::many_dft(1, &n, narrow(columns), data, nullptr, narrow(stride), 1, data, nullptr,
                            narrow(stride), 1, forward ? FFTW_FORWARD : FFTW_BACKWARD, flags(planning));
  if (plan_ == nullptr) throw Error("FFTW has no plan for " + std::to_string(length) + " points");
}

template <class T>
ColumnTransform<T>::~ColumnTransform() {
  Fftw<T>::destroy(static_cast<typename Fftw<T>::Plan>(plan_));
}

template <class T>
void ColumnTransform<T>::run(T* data) const {
  auto* complex = reinterpret_cast<typename Fftw<T>::Complex*>(data);
  Fftw<T>::execute_dft(static_cast<typename Fftw<T>::Plan>(plan_), complex, complex);
}

// One member says which way: a plan of FFTW knows its own direction, but not its own call.
template <class T>
struct DirectedPlan {
  typename Fftw<T>::Plan plan;
  bool forward;
};

template <class T>
RowTransform<T>::RowTransform(std::int64_t length, bool forward, Planning planning) {
  const int n = narrow(length);
  Buffer<T> scratch(static_cast<std::size_t>(2 * (length / 2 + 1)));
  auto* complex = reinterpret_cast<typename Fftw<T>::Complex*>(scratch.data());
  const auto plan = forward ? Fftw<T>::r2c(n, scratch.data(), complex, flags(planning))
                            : Fftw<T>::c2r(n, complex, scratch.data(), flags(planning));
  if (plan == nullptr) throw Error("FFTW has no plan for " + std::to_string(length) + " points");
  plan_ = new DirectedPlan<T>{plan, forward};
}

template <class T>
RowTransform<T>::~RowTransform() {
  auto* directed = static_cast<DirectedPlan<T>*>(plan_);
  Fftw<T>::destroy(directed->plan);
  delete directed;
}

template <class T>
void RowTransform<T>::run(T* row) const {
  const auto* directed = static_cast<const DirectedPlan<T>*>(plan_);
  auto* complex = reinterpret_cast<typename Fftw<T>::Complex*>(row);
  if (directed->forward) {
    Fftw<T>::execute_r2c(directed->plan, row, complex);
  } else {
    Fftw<T>::execute_c2r(directed->plan, complex, row);
  }
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

std::int64_t next_fast_size(std::int64_t n, bool same_parity) {
  for (std::int64_t size = n;; size += same_parity ? 2 : 1) {
    std::int64_t rest = size;
    for (const int prime : {2, 3, 5, 7}) {
      while (rest % prime == 0) rest /= prime;
    }
    if (rest == 1) return size;
  }
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
