#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "fourier/slice_source.h"
#include "io/file.h"

namespace vol::io {

/// Writes spectra as NRRD: axes complex (2), kx 0 .. floor(Mx/2), ky and kz centred at floor(M/2), and one
/// more where there are several spectra; float or double. Keys: precis.kind = spectrum, and below
/// precis.spectrum. the volume's dims, spacing, origin, direction and space, and padded (M), padding,
/// compensation, model, names (one a line). `attributes` and those of the spectrum's info go in beside them.
template <class T>
void write_spectrum(const std::filesystem::path& path, const fourier::Spectrum<T>& spectrum,
                    const std::map<std::string, std::string>& attributes);

/// A spectrum's header: what is in the file, without its numbers.
struct SpectrumHeader {
  fourier::SpectrumInfo info;
  bool is_double = false;
};
/// Whether a file begins as those that write_spectrum() makes. Consumes nothing.
[[nodiscard]] bool is_spectrum(InputFile& file);
/// Reads the header, and checks sizes against keys and, where the file's size is known, data against sizes.
/// \throws vol::Error naming the file, for what is no spectrum too
[[nodiscard]] SpectrumHeader read_spectrum_header(InputFile& file);

/// A spectrum file whose header has been read and checked: sizes against keys and, where the file's size is
/// known, data against sizes. Data follow when asked for, straight to their place.
class SpectrumFile {
 public:
  /// \throws vol::Error naming the file, for what is no spectrum too
  explicit SpectrumFile(const std::filesystem::path& path);

  [[nodiscard]] const fourier::SpectrumInfo& info() const { return header_.info; }
  [[nodiscard]] bool is_double() const { return header_.is_double; }
  /// All spectra, for slicing; T must be the file's type. \throws vol::Error naming the file, here and below,
  /// where a number is not finite
  template <class T>
  [[nodiscard]] fourier::SliceSource<T> read_slice_source(int taps);
  /// All spectra as they stand.
  template <class T>
  [[nodiscard]] fourier::Spectrum<T> read_spectrum();

 private:
  InputFile file_;
  SpectrumHeader header_;
};

}  // namespace vol::io
