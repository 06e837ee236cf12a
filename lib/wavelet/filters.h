#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vol::wavelet {

/// A low-pass and a high-pass filter on one window of an even number of taps: h[i] and g[i] belong to offset
/// first + i. Analysis  c'[k] = sum_n h[n] c[2k + n],  d[k] = sum_n g[n] c[2k + n];
/// synthesis  c[m] = sum_k h[m - 2k] c'[k] + g[m - 2k] d[k].  first is even.
struct FilterBank {
  std::int64_t first = 0;
  std::vector<double> h;
  std::vector<double> g;

  [[nodiscard]] std::int64_t taps() const { return static_cast<std::int64_t>(h.size()); }
  [[nodiscard]] std::int64_t last() const { return first + taps() - 1; }
};

enum class Family { haar, daubechies, coiflet, battle_lemarie };

/// An orthonormal wavelet of a dilation by two, known by its filters, each computed from its definition.
///
/// haar, daubechies-4 .. -20 (even): h[0..L-1], sum sqrt 2; minimum phase (Daubechies 1988).
/// coiflet-6 .. -30 (by 6): h[0..L-1]; L/3 vanishing moments of psi, and moments 1 .. L/3 - 1 of phi about
/// its
///   centre L/3 vanish (Daubechies 1993, her own branch of the solutions).
/// battle-lemarie-1, -3: orthonormalised splines of that degree, h symmetric about 0, of infinite support;
/// the
///   list holds every tap down to a tail of 1e-16. `battle-lemarie-3:29` and `:33` are cut to 29 and 33 taps,
///   as papers have them, and are orthonormal to about 1e-3 only.
/// g[n] = (-1)^n h[L-1-n]; Battle-Lemarie g[n] = (-1)^(n-1) h[1-n].
struct Wavelet {
  std::string name;  ///< canonical
  Family family = Family::haar;
  int vanishing_moments = 1;  ///< of psi
  int degree = 0;             ///< of the spline, Battle-Lemarie only
  bool compact = true;        ///< false: the list of taps approximates an infinite one
  bool orthonormal = true;    ///< false for the truncated ones
  FilterBank bank;            ///< on the integers
  double mean = 0;            ///< mu = integral of x phi(x) = sum n h[n] / sqrt 2, in samples
};

/// Filters of a wavelet. `battle-lemarie` means `battle-lemarie-3`. Throws vol::Error listing the names.
[[nodiscard]] Wavelet make_wavelet(std::string_view name);

/// Canonical names, in the order of the documentation.
[[nodiscard]] std::vector<std::string> wavelet_names();

/// The filters for a periodic signal of `period` samples (even), as one window of at most `period` taps.
/// For the exact Battle-Lemarie wavelets of more taps than samples the taps are the inverse DFT of the
/// frequency response at 2 pi k / period, orthonormal to rounding whatever the period; otherwise the list is
/// wrapped. Taps of an infinite list whose sum of magnitudes is below `tail` are left out.
[[nodiscard]] FilterBank periodised(const Wavelet& wavelet, std::int64_t period, double tail = 1e-16);

/// H(w) with H(0) = 1 of the Battle-Lemarie wavelet of odd spline degree 1 or 3:
/// H(w)^2 = Sigma(w) / (2^(2d+2) Sigma(2w)),  Sigma(w) = sum_k (w + 2 pi k)^-(2d+2),
/// which is cos(w/2)^(2d+2) E(w) / E(2w), E the Fourier series of the B-spline of degree 2d+1 at the
/// integers: no denominator vanishes.
[[nodiscard]] long double battle_lemarie_response(int degree, long double w);

/// First and last sample (of the volume) that coefficient k of `level` reaches in synthesis, boundaries
/// apart: [2^m k + (2^m - 1) first, 2^m k + (2^m - 1) last].
struct Support {
  std::int64_t first = 0;
  std::int64_t last = 0;
};
[[nodiscard]] Support synthesis_support(const FilterBank& bank, int level, std::int64_t k);

/// Largest amplification of a signal's l2 norm by one one-dimensional synthesis step, and largest relative
/// error of one step there and back; 1 and 0 for orthonormal filters. From the modulation matrix on 4096
/// frequencies (the responses are trigonometric polynomials of at most 34 taps, so this is the supremum to
/// 1e-4 relative, which is added).
struct FrameBounds {
  double synthesis_norm = 1;
  double round_trip_error = 0;
};
[[nodiscard]] FrameBounds frame_bounds(const Wavelet& wavelet);

}  // namespace vol::wavelet
