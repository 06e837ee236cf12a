#pragma once
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "fourier/fft.h"
#include "fourier/filter.h"
#include "volume/volume.h"

namespace vol::fourier {

/// What a spectrum says of itself; the keys of its file.
struct SpectrumInfo {
  volume::GridGeometry geometry;                  ///< of the volume that was transformed
  Dims padded{1, 1, 1};                           ///< M: the size of the transform per axis, padded_size()
  double padding = 1;                             ///< as asked for; M may be a little larger
  std::string compensation = "none";              ///< filter whose attenuation was divided out
  std::string model = "plain";                    ///< plain, depth-cue, directional, bezier, bands
  std::vector<std::string> names{"f"};            ///< of the spectra, in order
  std::map<std::string, std::string> attributes;  ///< of the volume, and how it was made

  /// kx = 0 .. floor(Mx/2); ky and kz centred, index ky + floor(My/2).
  [[nodiscard]] std::int64_t row_length() const { return padded[0] / 2 + 1; }
  /// Complex numbers in one spectrum.
  [[nodiscard]] std::int64_t count() const;
  /// Throws vol::Error where sizes, padding, model or names cannot be those of a spectrum.
  void validate() const;
};

/// The centred half spectrum of a real volume f, about its box centre c = (n - 1)/2:
///
///     F[kx, ky, kz] = sum over samples of f[i] exp(-2 pi i sum_a k_a (i_a - c_a) / M_a)
///
/// as interleaved complex numbers, one buffer for each of info.names. F[-k] = conj F[k] gives the half that
/// is not stored, and F[k + M_a] = (-1)^(n_a - 1) F[k] what lies outside.
template <class T>
struct Spectrum {
  SpectrumInfo info;
  std::vector<Buffer<T>> fields;
};

/// Size of the transform: n times padding where that is whole, else the next size of factors 2, 3, 5, 7.
[[nodiscard]] std::int64_t padded_size(std::int64_t n, double padding);

/// 1 / W((i - c)/M) along each axis: what a volume is multiplied by so that a filter leaves it as it was.
struct Compensation {
  std::vector<double> x, y, z;
  double largest = 1;  ///< over the whole volume
};
/// \throws vol::Error where the filter lets nothing through at some sample
[[nodiscard]] Compensation compensation(const Filter& filter, const Dims& dims, const Dims& padded);

/// Row (j, k) of a field's samples along x.
using RowSource = std::function<void(std::int64_t j, std::int64_t k, std::span<double> row)>;

/// Bytes that transform() takes for `fields` spectra of this size, and keeps.
template <class T>
[[nodiscard]] std::int64_t spectrum_bytes(const SpectrumInfo& info);

/// Bytes that transform() and inverse() take besides spectra and volume, on all threads together.
template <class T>
[[nodiscard]] std::int64_t transform_scratch_bytes(const SpectrumInfo& info);

/// The spectra of `sources`, one for each of info.names; compensated as info says. Rows of padding are not
/// transformed along x, slabs of padding neither along x nor y; phase and centring are applied while the data
/// are in the cache. Threads: parallel_for; the same bits for any number of them. \throws vol::Error where a
/// result is not finite
template <class T>
[[nodiscard]] Spectrum<T> transform(const SpectrumInfo& info, const std::vector<RowSource>& sources,
                                    Planning planning = Planning::estimate);

/// The volume whose spectrum number `field` is: the inverse of transform(), padding cut, compensation undone.
/// Overwrites that spectrum. \throws vol::Error where a number of the spectrum or of the volume is not finite
template <class T>
[[nodiscard]] volume::Grid<T> inverse(Spectrum<T>& spectrum, std::size_t field,
                                      Planning planning = Planning::estimate);

}  // namespace vol::fourier
