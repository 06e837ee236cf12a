#pragma once
#include <cstdint>
#include <vector>

#include "base/buffer.h"
#include "volume/volume.h"
#include "wavelet/decomposition.h"
#include "wavelet/filters.h"

// From voxels to the coefficients c0 of f(x) = sum_k c0[k] phi(x - k + s) and back. Coefficients are not
// samples (Gross, Lippert, Dreger & Koch 1995, eq. 24, takes one for the other). Two readings:
//
// samples: c0 = voxels, s = mu, the first moment of phi. f is near the voxels where they are smooth, of
// second order, and nothing shifts; it does not go through them but for haar.
//
// interpolate: c0 = B^-1 voxels, B the periodic convolution with b[m] = phi(m + s) along every transformed
// axis of the extended box, s the integer nearest to mu (haar, which jumps at the integers: mu itself, and B
// is the identity). f goes through every voxel; so no picture shifts, whatever s is. An integer because phi
// is known there exactly, by the eigenvector of the refinement equation, and every spline of the expansion
// goes through these values, whatever its depth; the nearest to mu so that c0[k] belongs to the voxel k to
// within half a voxel, and regions mean what they say.

namespace vol::wavelet {

/// s of f(x) = sum_k c0[k] phi(x - k + s).
[[nodiscard]] double expansion_shift(const Wavelet& wavelet, Initialisation initialisation);

/// b[m], m = first, first + 1, ...: phi(m + s), s the shift of `interpolate`. They sum to 1.
struct PhiSamples {
  std::int64_t first = 0;
  std::vector<double> values;
};
[[nodiscard]] PhiSamples phi_samples(const Wavelet& wavelet);

/// Least and largest |B(w)|, B(w) = sum_m b[m] exp(-i m w), on 4096 frequencies (the largest plus what may
/// lie between them). An error of c0 becomes one of the voxels at most `largest` times as large along an
/// axis, and one of the voxels one of c0 of 1 / least.
struct Response {
  double least = 1;
  double largest = 1;
};
[[nodiscard]] Response phi_response(const Wavelet& wavelet);

/// Of |B(w)|: below, interpolation would blow up the voxels' noise more than 10 times an axis. Only
/// daubechies-10, whose |B(pi)| is 0.031, is below; the next is daubechies-18 with 0.37.
inline constexpr double kLeastResponse = 0.1;

/// \throws vol::Error where `interpolate` is not to be had: |B(w)| below kLeastResponse, filters that are not
/// orthonormal (their transform does not belong to phi), a boundary that is not periodic
void require_interpolation(const Wavelet& wavelet, Boundary boundary);

/// Of the largest |voxel|, how large |c0| can be at most: the sum of magnitudes of B^-1 along all axes.
[[nodiscard]] double interpolation_gain(const Wavelet& wavelet, const Dims& extended);

/// In place, on the extended box, x fastest: voxels = B c0, and back. Axes of one sample are left alone. Sums
/// are taken in double; the result has the same bits for any number of threads.
template <class T>
void values_at_voxels(const Wavelet& wavelet, const Dims& extended, Buffer<T>& c0);
template <class T>
void coefficients_through_voxels(const Wavelet& wavelet, const Dims& extended, Buffer<T>& voxels);

/// \throws vol::Error, saying what to do, for coefficients that interpolate
template <class T>
void require_samples(const Decomposition<T>& decomposition);

}  // namespace vol::wavelet
