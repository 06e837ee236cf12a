#include "wavelet/significance.h"
#include "wavelet/initialisation.h"

#include <cmath>
#include <limits>
#include <string>

#include "base/error.h"
#include "wavelet/filters.h"

namespace vol::wavelet {
namespace {

constexpr std::array<std::string_view, 4> kNames = {"gross", "muraki", "energy", "amplitude"};

int transformed_axes(const Dims& extended) {
  int axes = 0;
  for (const auto n : extended) axes += n > 1;
  return axes;
}

}  // namespace

std::string_view name(Significance significance) {
  return kNames[static_cast<std::size_t>(significance)];
}

Significance significance_from_name(std::string_view wanted) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == wanted) return static_cast<Significance>(i);
  }
  throw Error("significance '" + std::string(wanted) + "' is not one of gross muraki energy amplitude");
}

std::string_view name(ErrorKind kind) {
  constexpr std::array<std::string_view, 3> names = {"exact", "bound", "estimate"};
  return names[static_cast<std::size_t>(kind)];
}

double significance_weight(Significance significance, int level, int orientation, const Dims& extended) {
  const int d = transformed_axes(extended);
  int wavelets = 0;
  for (int axis = 0; axis < 3; ++axis) wavelets += orientation >> axis & 1;
  const int s = d - wavelets;
  switch (significance) {
    case Significance::gross:
      return std::exp2(0.5 * (s + d * level));
    case Significance::muraki:
      return std::exp2(d * level);
    case Significance::amplitude:
      return std::exp2(-0.5 * d * level);
    case Significance::energy:
      break;
  }
  return 1;
}

template <class T>
PredictedError predicted_error(const Decomposition<T>& decomposition, const RejectionReport& report) {
  const Wavelet wavelet = make_wavelet(decomposition.wavelet);
  const bool periodic = decomposition.boundary == Boundary::periodic;
  if (decomposition.initialisation == Initialisation::interpolate) {
    const double largest = phi_response(wavelet).largest;
    return {ErrorKind::bound,
            std::pow(largest, transformed_axes(decomposition.extended_dims)) * report.rejected_norm};
  }
  if (wavelet.orthonormal) {
    const bool whole = periodic && decomposition.extended_dims == decomposition.geometry.dims;
    return {whole || decomposition.levels == 0 ? ErrorKind::exact : ErrorKind::bound, report.rejected_norm};
  }
  const FrameBounds frame = frame_bounds(wavelet);
  const int d = transformed_axes(decomposition.extended_dims);
  const double growth = std::pow(frame.synthesis_norm, d * decomposition.levels);
  double round_trip = 0;
  for (int level = 1; level <= decomposition.levels; ++level) {
    round_trip =
        std::pow(1 + frame.round_trip_error, d) - 1 + std::pow(frame.synthesis_norm, 2 * d) * round_trip;
  }
  const double volume_norm =
      round_trip < 1 ? growth * report.norm / (1 - round_trip) : std::numeric_limits<double>::infinity();
  return {periodic ? ErrorKind::bound : ErrorKind::estimate,
          growth * report.rejected_norm + (round_trip > 0 ? round_trip * volume_norm : 0)};
}

template PredictedError predicted_error(const Decomposition<float>&, const RejectionReport&);
template PredictedError predicted_error(const Decomposition<double>&, const RejectionReport&);

}  // namespace vol::wavelet
