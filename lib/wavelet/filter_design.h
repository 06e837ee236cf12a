#pragma once
#include <vector>

// The scaling filters, each from its definition. Sum sqrt 2.
namespace vol::wavelet {

/// Daubechies 1988: `taps` even; H(z) = c (1 + 1/z)^(taps/2) prod (1 - r/z), the roots r inside the unit
/// circle.
[[nodiscard]] std::vector<double> daubechies_taps(int taps);

/// Daubechies 1993: Gauss-Newton on the defining equations, which are all solved to rounding.
[[nodiscard]] std::vector<double> coiflet_taps(int taps);

/// h[-radius .. radius] of the Battle-Lemarie wavelet.
[[nodiscard]] std::vector<double> battle_lemarie_taps(int degree, int radius);

/// h periodised to `period` samples, h[0 .. period-1].
[[nodiscard]] std::vector<double> battle_lemarie_periodised(int degree, int period);

}  // namespace vol::wavelet
