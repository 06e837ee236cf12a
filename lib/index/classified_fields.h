#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "transfer/transfer_function.h"
#include "volume/volume.h"
#include "wavelet/decomposition.h"

namespace vol::index {

/// What a scene makes of a volume, voxel by voxel: the extinction sigma_t, and the emission c sigma_t of each
/// colour channel that differs from the others, in units of 1 / standard_distance, so that a value is the
/// optical depth (or the light) of one standard step. These are the fields the ray integral sums, and their
/// details, not those of the raw data, say how far apart it must be sampled: what the transfer function makes
/// invisible or constant needs no samples.
///
/// Extinction is capped at the optical depth 32 a standard step, beyond which (e^-32 = 1e-14) nothing is
/// seen.
///
/// No field is ever there as a whole: boxes of voxels are made when they are asked for. Integers of at most
/// 16 bits are looked up in a table.
class ClassifiedFields {
 public:
  /// Refers to the volume and the transfer function. \throws vol::Error unless both lengths are positive
  ClassifiedFields(const volume::Volume& volume, const transfer::TransferFunction& transfer,
                   double reference_length, double standard_distance);

  [[nodiscard]] std::size_t count() const { return 1 + channels_.size(); }

  /// No voxel of the field can be larger, whatever the volume holds.
  [[nodiscard]] double bound(std::size_t field) const;

  /// Largest voxel of each field, all of which are at least 0: one pass over the volume.
  [[nodiscard]] std::vector<float> largest() const;

  /// Writes the voxels [begin, begin + box) of every field, x fastest; behind the volume's end they are those
  /// of its extension.
  void fill(const Dims& begin, const Dims& box, wavelet::Extension extension,
            std::span<float* const> fields) const;

 private:
  /// All fields at one value of the volume.
  void classify(double value, float* to) const;
  template <class V>
  void classify_row(const V* from, std::int64_t count, float* const* to) const;

  const volume::Volume& volume_;
  const transfer::TransferFunction& transfer_;
  double reference_length_, standard_distance_;
  std::vector<int> channels_;               ///< that are not copies of an earlier one
  std::vector<std::vector<float>> tables_;  ///< of each field, by value from the voxel type's smallest on
};

}  // namespace vol::index
