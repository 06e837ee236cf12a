#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "volume/volume.h"

namespace vol::wavelet {

/// periodic: orthonormal. symmetric: half-sample symmetric extension, expansive for unsymmetric filters.
enum class Boundary { periodic, symmetric };

/// How a size that 2^levels does not divide is extended, once, to the next multiple.
enum class Extension { replicate, mirror, zero };

/// What stands for the finest coefficients c0 of a volume (initialisation.h).
///   samples      its voxels
///   interpolate  what phi's expansion takes to go through its voxels
enum class Initialisation { samples, interpolate };

/// Coefficients of one orientation at one level, x fastest. Coefficient (i, j, k) of the array is coefficient
/// index lower + (i, j, k) of the transform (lower is 0 for periodic, negative for expansive transforms).
template <class T>
struct Subband {
  int level = 1;  ///< 1 is the finest
  int orientation =
      0;  ///< bit 0: wavelet along x, bit 1: along y, bit 2: along z; 0 is the approximation LLL
  std::array<std::int64_t, 3> lower{0, 0, 0};
  Dims dims{0, 0, 0};
  Buffer<T> coefficients;
};

/// "LLH" for orientation 4: letters in x, y, z order.
[[nodiscard]] std::string orientation_name(int orientation);

/// A volume's separable wavelet transform: the approximation of the coarsest level first, then the detail
/// subbands from the coarsest level to the finest, orientations 1..7 in order. An axis of one sample is not
/// transformed, and the orientations with a wavelet along it do not exist.
template <class T>
struct Decomposition {
  std::string wavelet;  ///< canonical name, "daubechies-4"
  int levels = 0;
  Boundary boundary = Boundary::periodic;
  Extension extension = Extension::replicate;
  Initialisation initialisation = Initialisation::samples;
  volume::GridGeometry geometry;  ///< of the volume itself
  Dims extended_dims{0, 0, 0};    ///< of the box that was transformed
  volume::VoxelType voxel_type =
      volume::VoxelType::f32;  ///< of the volume, so that the inverse can restore it
  volume::Range range;         ///< of the volume
  std::vector<Subband<T>> subbands;
};

}  // namespace vol::wavelet
