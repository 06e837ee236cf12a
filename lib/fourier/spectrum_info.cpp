// What needs no transform, and so no FFTW: whoever only describes or reads spectra links this alone.
#include <cmath>
#include <limits>

#include "base/checked.h"
#include "base/error.h"
#include "fourier/spectrum.h"
#include "transfer/bezier.h"

namespace vol::fourier {

std::int64_t SpectrumInfo::count() const {
  return checked_product(checked_product(row_length(), padded[1]), padded[2]);
}

void SpectrumInfo::validate() const {
  geometry.validate();
  (void)checked_count(padded);
  if (!(padding >= 1 && padding <= 16)) throw Error("padding is not between 1 and 16");
  for (int a = 0; a < 3; ++a) {
    if (padded[a] < geometry.dims[a]) throw Error("a spectrum is smaller than its volume");
    if (padded[a] > std::numeric_limits<int>::max())
      throw Error("a spectrum is larger than FFTW can make one");
    const std::int64_t size = padded_size(geometry.dims[a], padding);
    if (padded[a] != size) {
      throw Error(std::to_string(geometry.dims[a]) + " samples, padded, are " + std::to_string(size) +
                  ", not " + std::to_string(padded[a]));
    }
  }
  if (names.empty()) throw Error("a spectrum file without spectra");
  const std::size_t given = names.size();
  const auto require_names = [&](std::size_t least, std::size_t most) {
    if (given < least || given > most) {
      throw Error("a " + model + " file has " + std::to_string(least) +
                  (most == least ? "" : " to " + std::to_string(most)) +
                  (most == 1 ? " spectrum" : " spectra") + ", this one " + std::to_string(given));
    }
  };
  if (model == "plain") {
    require_names(1, 1);
  } else if (model == "depth-cue" || model == "directional") {
    require_names(4, 4);
  } else if (model == "bezier") {
    require_names(1, transfer::kMostControlPoints);
  } else if (model != "bands") {
    throw Error("spectrum of an unknown model; plain, depth-cue, directional, bezier and bands are known");
  }
  if (compensation != "none") (void)Filter(compensation, padding);
}

std::int64_t padded_size(std::int64_t n, double padding) {
  const double exact = static_cast<double>(n) * padding;
  const auto size = static_cast<std::int64_t>(std::ceil(exact));
  return padding == std::floor(padding) ? size : next_fast_size(size);
}

template <class T>
std::int64_t spectrum_bytes(const SpectrumInfo& info) {
  return checked_product(checked_product(info.count(), 2 * sizeof(T)),
                         static_cast<std::int64_t>(info.names.size()));
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

template std::int64_t spectrum_bytes<float>(const SpectrumInfo&);
template std::int64_t spectrum_bytes<double>(const SpectrumInfo&);

}  // namespace vol::fourier
