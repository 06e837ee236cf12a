#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace vol::fourier {

/// A separable kernel w(t) that resamples a spectrum between its grid points, t in grid steps.
///
///     F(g) = sum_k w(g - k) F[k],   k = first .. first + taps - 1,   first = floor(g - taps/2) + 1
///
/// In space this multiplies the volume by the kernel's transform W(x) = integral of w(t) cos(2 pi x t) dt at
/// x = (n - centre)/padded size (what compensation divides out), and adds replicas weighted by W(x + m), the
/// ghosts.
///
/// Names: `nearest`; `trilinear`; `catmull-rom` (Keys 1981, a = -1/2; 64 taps); `catmull-rom-fast` (Cheng
/// 2007: four linearly interpolated samples, one step apart and half a step off the position, joined by the
/// Catmull-Rom curve at its middle, so that w is a sum of four hat functions); `sinc:N` (N taps; Hamming's
/// window 0.54348 + 0.45652 cos(2 pi t/N)); `es:N`, the exponential of semicircle exp(beta (sqrt(1 -
/// (2t/N)^2) - 1)) (Barnett, Magland & af Klinteberg 2019) with beta = 0.976 pi N (1 - 1/(2 padding)). All
/// but `es` and `catmull-rom-fast` interpolate: on a slice through grid points they change nothing. Those two
/// are right only for a spectrum compensated for them.
class Filter {
 public:
  /// \param padding  of the spectrum it is for, >= 1; only `es` depends on it
  /// \throws vol::Error for an unknown name, sinc taps outside 2..16 or es widths outside 2..16
  Filter(std::string_view name, double padding);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] int taps() const { return taps_; }
  /// False where an uncompensated spectrum gives a wrong picture.
  [[nodiscard]] bool interpolates() const;
  [[nodiscard]] double beta() const { return beta_; }
  /// w(t); 0 for |t| > taps/2.
  [[nodiscard]] double weight(double t) const;
  /// W(x), by Gauss-Legendre rules on the kernel's smooth pieces; to 1e-14.
  [[nodiscard]] double transform(double x) const;
  /// Weights of the taps as polynomials: weight of tap j at g is  sum_d c[d * taps + j] s^d,
  /// s = 2 (g - taps/2 - floor(g - taps/2)) - 1 in [-1, 1). Exact for the polynomial kernels, else by
  /// interpolation at Chebyshev nodes: sinc to 1e-7 of the largest weight, es to exp(-beta) or 1e-7,
  /// whichever is more; the first is below the kernel's own error.
  struct Polynomials {
    int degree = 0;
    std::vector<double> coefficients;
  };
  [[nodiscard]] Polynomials polynomials() const;

 private:
  enum class Kind { nearest, trilinear, catmull_rom, catmull_rom_fast, sinc, es };
  std::string name_;
  Kind kind_ = Kind::nearest;
  int taps_ = 1;
  double beta_ = 0;
};

/// The names with what may follow them, for messages and help.
[[nodiscard]] std::string filter_names();

}  // namespace vol::fourier
