#pragma once
#include "fourier/spectrum.h"

namespace vol::fourier {

/// A spectrum as slices are taken from it: every row has a margin on both sides and rows continue past both
/// ends of y and z, so that no tap of a filter asks whether it lies inside. The margins hold what the
/// symmetries say is there: F[-k] = conj F[k], F[k + M_a] = (-1)^(n_a - 1) F[k].
template <class T>
class SliceSource {
 public:
  /// \param taps  the widest filter's
  SliceSource(const SpectrumInfo& info, int taps);

  /// Bytes that a source takes.
  [[nodiscard]] static std::int64_t bytes(const SpectrumInfo& info, int taps);

  [[nodiscard]] const SpectrumInfo& info() const { return info_; }
  [[nodiscard]] int taps() const { return taps_; }
  [[nodiscard]] std::size_t fields() const { return fields_.size(); }
  /// Element kx of row (ky, kz), at which real and imaginary part stand; |kx|, |ky|, |kz| may pass M/2 by
  /// taps/2 + 1.
  [[nodiscard]] const T* at(std::size_t field, std::int64_t kx, std::int64_t ky, std::int64_t kz) const {
    return fields_[field].data() + offset(kx, ky, kz);
  }
  /// The row (ky, kz) proper, kx = 0 .. floor(Mx/2), to be filled in by whoever makes or reads the spectrum
  /// ...
  [[nodiscard]] T* row(std::size_t field, std::int64_t ky, std::int64_t kz) {
    return fields_[field].data() + offset(0, ky, kz);
  }
  /// ... and then the margins from the rows.
  void fill_margins();

  /// Distance in reals between rows of neighbouring ky, and kz.
  [[nodiscard]] std::int64_t row_stride() const { return row_; }
  [[nodiscard]] std::int64_t slab_stride() const { return slab_; }
  [[nodiscard]] std::int64_t offset(std::int64_t kx, std::int64_t ky, std::int64_t kz) const {
    return 2 * (kx + margin_) + row_ * (ky + half_y_) + slab_ * (kz + half_z_);
  }

 private:
  SpectrumInfo info_;
  int taps_;
  std::int64_t margin_ = 0, half_y_ = 0, half_z_ = 0;  // rows go from -half to +half
  std::int64_t row_ = 0, slab_ = 0;
  std::vector<Buffer<T>> fields_;
};

/// From a spectrum in memory.
template <class T>
[[nodiscard]] SliceSource<T> slice_source(const Spectrum<T>& spectrum, int taps);

}  // namespace vol::fourier
