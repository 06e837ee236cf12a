#include "wavelet/initialisation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <sstream>

#include "base/error.h"
#include "base/parallel.h"
#include "wavelet/prototypes.h"

namespace vol::wavelet {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// A periodic convolution: out[n] = sum_i values[i] in[n - first - i].
using Taps = PhiSamples;

/// B at 2 pi j / period, j = 0 .. period - 1.
std::vector<std::complex<double>> response(const Taps& taps, std::int64_t period) {
  std::vector<std::complex<double>> turn(static_cast<std::size_t>(period));
  for (std::size_t j = 0; j < turn.size(); ++j) {
    turn[j] = std::polar(1.0, -kTurn * static_cast<double>(j) / static_cast<double>(period));
  }
  std::vector<std::complex<double>> sums(turn.size());
  for (std::size_t j = 0; j < turn.size(); ++j) {
    for (std::size_t i = 0; i < taps.values.size(); ++i) {
      const std::int64_t m = taps.first + static_cast<std::int64_t>(i);
      const std::int64_t at = ((m % period + period) % period) * static_cast<std::int64_t>(j) % period;
      sums[j] += taps.values[i] * turn[static_cast<std::size_t>(at)];
    }
  }
  return sums;
}

/// B^-1 on a period. Its taps fall off exponentially, and a longer period than kEnough adds none that counts.
Taps inverse(const Taps& taps, std::int64_t period) {
  constexpr std::int64_t kEnough = 1024;
  const std::int64_t n = std::min(period, kEnough);
  const auto b = response(taps, n);
  Taps all{-(n / 2), std::vector<double>(static_cast<std::size_t>(n), 0)};
  std::vector<std::complex<double>> turn(static_cast<std::size_t>(n));
  for (std::size_t j = 0; j < turn.size(); ++j) {
    turn[j] = std::polar(1.0, kTurn * static_cast<double>(j) / static_cast<double>(n));
  }
  for (std::int64_t k = 0; k < n; ++k) {
    const std::int64_t m = ((all.first + k) % n + n) % n;
    std::complex<double> sum = 0;
    for (std::int64_t j = 0; j < n; ++j) {
      sum += turn[static_cast<std::size_t>(m * j % n)] / b[static_cast<std::size_t>(j)];
    }
    all.values[static_cast<std::size_t>(k)] = sum.real() / static_cast<double>(n);
  }
  // Below 1e-17 of the sum, which is 1 at least, taps are the transform's own rounding.
  const auto counts = [](double tap) { return std::abs(tap) > 1e-17; };
  const auto begin = std::find_if(all.values.begin(), all.values.end(), counts);
  const auto end = std::find_if(all.values.rbegin(), all.values.rend(), counts).base();
  return {all.first + (begin - all.values.begin()), std::vector<double>(begin, end)};
}

/// Along one axis, in place: blocks of neighbouring lines, so that memory is read in order.
template <class T>
void convolve(const Taps& taps, const Dims& dims, std::size_t axis, T* data) {
  const std::int64_t n = dims[axis];
  std::int64_t inner = 1, outer = 1;
  for (std::size_t a = 0; a < axis; ++a) inner *= dims[a];
  for (std::size_t a = axis + 1; a < 3; ++a) outer *= dims[a];
  const std::int64_t wide = std::min<std::int64_t>(inner, 16);
  const std::int64_t blocks = (inner + wide - 1) / wide;
  const auto length = static_cast<std::int64_t>(taps.values.size());
  const auto lines = [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> in(static_cast<std::size_t>((n + length - 1) * wide));
    std::vector<double> out(static_cast<std::size_t>(n * wide));
    for (std::int64_t b = begin; b < end; ++b) {
      const std::int64_t from = b % blocks * wide, width = std::min(wide, inner - from);
      T* const line = data + b / blocks * n * inner + from;
      for (std::int64_t p = 0; p < n + length - 1; ++p) {
        const std::int64_t at = ((p - taps.first - (length - 1)) % n + n) % n;
        for (std::int64_t w = 0; w < width; ++w) {
          in[static_cast<std::size_t>(p * width + w)] = static_cast<double>(line[at * inner + w]);
        }
      }
      std::fill(out.begin(), out.end(), 0.0);
      for (std::int64_t i = 0; i < length; ++i) {
        const double tap = taps.values[static_cast<std::size_t>(i)];
        const double* const shifted = in.data() + (length - 1 - i) * width;
        for (std::int64_t p = 0; p < n * width; ++p) out[static_cast<std::size_t>(p)] += tap * shifted[p];
      }
      for (std::int64_t p = 0; p < n; ++p) {
        for (std::int64_t w = 0; w < width; ++w) {
          line[p * inner + w] = static_cast<T>(out[static_cast<std::size_t>(p * width + w)]);
        }
      }
    }
  };
  parallel_for(0, outer * blocks, 64, lines);
}

template <class T, class TapsOf>
void convolve_all(const Wavelet& wavelet, const Dims& dims, Buffer<T>& data, const TapsOf& taps_of) {
  if (wavelet.family == Family::haar) return;
  const Taps samples = phi_samples(wavelet);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (dims[axis] > 1) convolve(taps_of(samples, dims[axis]), dims, axis, data.data());
  }
}

}  // namespace

double expansion_shift(const Wavelet& wavelet, Initialisation initialisation) {
  if (initialisation == Initialisation::samples || wavelet.family == Family::haar) return wavelet.mean;
  return std::round(wavelet.mean);
}

PhiSamples phi_samples(const Wavelet& wavelet) {
  if (wavelet.family == Family::haar) return {0, {1}};
  const auto shift = static_cast<std::int64_t>(expansion_shift(wavelet, Initialisation::interpolate));
  const PiecewiseCubic phi = make_prototypes(wavelet, 1).phi;
  const auto first = static_cast<std::int64_t>(std::ceil(phi.lower));
  PhiSamples samples{first - shift, {}};
  for (std::int64_t n = first; static_cast<double>(n) < phi.upper(); ++n) {
    samples.values.push_back(phi.value(static_cast<double>(n)));
  }
  return samples;
}

Response phi_response(const Wavelet& wavelet) {
  constexpr std::int64_t kFrequencies = 4096;
  const PhiSamples samples = phi_samples(wavelet);
  Response result{1, 1};
  for (const auto& b : response(samples, kFrequencies)) {
    result.least = std::min(result.least, std::abs(b));
    result.largest = std::max(result.largest, std::abs(b));
  }
  // |d|B|/dw| <= sum |m b[m]|; no frequency is further than half a step from one of these.
  double slope = 0;
  for (std::size_t i = 0; i < samples.values.size(); ++i) {
    slope += std::abs(static_cast<double>(samples.first + static_cast<std::int64_t>(i)) * samples.values[i]);
  }
  if (samples.values.size() > 1) result.largest += slope * std::numbers::pi / kFrequencies;
  return result;
}

void require_interpolation(const Wavelet& wavelet, Boundary boundary) {
  if (boundary != Boundary::periodic) {
    throw Error("interpolation of the voxels is known only for the periodic boundary");
  }
  if (!wavelet.orthonormal) {
    throw Error(wavelet.name + ": its cut filters do not belong to phi, which cannot interpolate; give " +
                wavelet.name.substr(0, wavelet.name.find(':')));
  }
  const double least = phi_response(wavelet).least;
  if (least < kLeastResponse) {
    std::ostringstream message;
    message << wavelet.name << ": interpolation would divide by " << least
            << ", the least response of phi's samples, which is below " << kLeastResponse
            << "; give another wavelet, or --initialise samples";
    throw Error(message.str());
  }
}

double interpolation_gain(const Wavelet& wavelet, const Dims& extended) {
  if (wavelet.family == Family::haar) return 1;
  const PhiSamples samples = phi_samples(wavelet);
  double gain = 1;
  for (const std::int64_t n : extended) {
    if (n == 1) continue;
    double sum = 0;
    for (const double tap : inverse(samples, n).values) sum += std::abs(tap);
    gain *= sum;
  }
  return gain;
}

template <class T>
void values_at_voxels(const Wavelet& wavelet, const Dims& extended, Buffer<T>& c0) {
  convolve_all(wavelet, extended, c0, [](const Taps& samples, std::int64_t) { return samples; });
}

template <class T>
void coefficients_through_voxels(const Wavelet& wavelet, const Dims& extended, Buffer<T>& voxels) {
  convolve_all(wavelet, extended, voxels, inverse);
}

template <class T>
void require_samples(const Decomposition<T>& decomposition) {
  if (decomposition.initialisation == Initialisation::samples) return;
  throw Error(
      "coefficients of vol-dwt --initialise interpolate, which are not those of the voxels; transform with "
      "--initialise samples");
}

template void values_at_voxels(const Wavelet&, const Dims&, Buffer<float>&);
template void values_at_voxels(const Wavelet&, const Dims&, Buffer<double>&);
template void coefficients_through_voxels(const Wavelet&, const Dims&, Buffer<float>&);
template void coefficients_through_voxels(const Wavelet&, const Dims&, Buffer<double>&);
template void require_samples(const Decomposition<float>&);
template void require_samples(const Decomposition<double>&);

}  // namespace vol::wavelet
