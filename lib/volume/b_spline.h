#pragma once
#include "volume/volume.h"

namespace vol::volume {

/// Coefficients c of the cubic B-spline that interpolates the voxels, mirror-symmetric about the outermost
/// centres: f[k] = sum_m c[m] beta3(k - m), c[-1] = c[1].
///
/// Along each axis the inverse of (1/6, 4/6, 1/6) is a causal and an anticausal recursion with pole
/// z = sqrt(3) - 2 and gain (1 - z)(1 - 1/z) = 6 (Unser, Aldroubi & Eden 1993, part II). The start of the
/// causal one is the exact sum over the mirrored period 2n - 2, so interpolation holds to rounding for any n.
template <class T>
[[nodiscard]] Buffer<double> b_spline_coefficients(const Grid<T>& grid);

}  // namespace vol::volume
