#pragma once
#include "base/rng.h"
#include "volume/volume.h"
#include "wavelet/decomposition.h"

namespace vol::wavelet {

/// White noise on a grid with nothing symmetric about it.
template <class T>
volume::Volume random_volume(const Dims& dims, std::uint64_t seed, double amplitude = 1) {
  volume::GridGeometry geometry;
  geometry.dims = dims;
  geometry.spacing = {0.7, 1.3, 2.9};
  geometry.origin = {-12.5, 3, 101};
  Rng rng(seed);
  volume::Grid<T> grid{geometry, Buffer<T>(static_cast<std::size_t>(geometry.count()))};
  for (T& v : grid.voxels) v = static_cast<T>(rng.uniform(-amplitude, amplitude));
  volume::Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

template <class T>
const volume::Grid<T>& grid_of(const volume::Volume& volume) {
  return std::get<volume::Grid<T>>(volume.grid);
}

/// Largest |a - b| over largest |b|.
template <class A, class B>
double relative_difference(const A& a, const B& b) {
  double difference = 0, largest = 0;
  for (std::size_t n = 0; n < b.size(); ++n) {
    difference = std::max(difference, std::abs(static_cast<double>(a[n]) - static_cast<double>(b[n])));
    largest = std::max(largest, std::abs(static_cast<double>(b[n])));
  }
  return largest > 0 ? difference / largest : difference;
}

/// Sum of squares of all coefficients.
template <class T>
double energy(const Decomposition<T>& d) {
  double sum = 0;
  for (const auto& band : d.subbands) {
    for (const T c : band.coefficients) sum += static_cast<double>(c) * static_cast<double>(c);
  }
  return sum;
}

}  // namespace vol::wavelet
