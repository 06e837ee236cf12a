#pragma once
#include <string>
#include <vector>

#include "features/local_energy.h"
#include "features/pca.h"
#include "features/self_organising_map.h"
#include "volume/volume.h"

namespace vol::features {

inline constexpr int kMostLabels = 256;  // labels are u8

/// What labels a volume: how its features are made, projected, and which label each unit has. A voxel of
/// features x has the label of the unit nearest to projection (x - mean). In the volume's own values: another
/// volume must have the same scale.
struct Codebook {
  std::string wavelet;
  int levels = 0;
  FeatureOptions features;
  std::vector<std::string> names;  ///< of the features
  Eigen::VectorXd mean;            ///< of each feature
  Eigen::MatrixXd projection;      ///< components x features
  Samples units;                   ///< units x components
  std::vector<int> labels;         ///< of each unit

  /// Throws vol::Error unless sizes belong together, numbers are finite and labels lie in 0..255.
  void validate() const;
};

enum class Method { self_organising_map, k_means };

struct TrainingOptions {
  Method method = Method::self_organising_map;
  int labels = 4;
  /// Amplitudes are of one unit, and the large ones tell textures apart; scaled to one variance, levels that
  /// hold nothing but the regions' borders would count as much.
  PcaOptions pca = {.standardise = false};
  MapOptions map = {};
  /// Voxels to learn from, at most; all where the volume has no more. They are drawn in one corner's eighth
  /// of the volume and mirrored into the others, so that what is learnt does not depend on which way an axis
  /// runs.
  std::int64_t samples = 65536;
  std::uint64_t seed = 1;  ///< of that draw, and of k-means
};

/// A codebook and how well it fits what it was learnt from.
struct Training {
  Codebook codebook;  ///< without wavelet, levels and features, which the caller knows
  std::int64_t samples = 0;
  Eigen::VectorXd shares;         ///< of the variance, of all principal components, descending
  double variance_share = 0;      ///< of those taken
  int labels_found = 0;           ///< fewer than asked for where there are fewer distinct vectors
  double quantisation_error = 0;  ///< over the root mean square of the projected vectors
  double topographic_error = 0;   ///< of a map
  std::vector<std::int64_t> hits;
};

/// The vectors to learn from, relative as FeatureField::at() has them, a row each.
[[nodiscard]] Samples drawn_samples(const FeatureField& field, std::int64_t most, std::uint64_t seed);

/// Label 0 is the one most samples have, then descending.
[[nodiscard]] Training train(const FeatureField& field, const TrainingOptions& options);

/// The label of every voxel, u8. Throws vol::Error where the codebook is for other features, or for values so
/// much smaller than the volume's that floats do not hold their squares.
[[nodiscard]] volume::Volume label_volume(const FeatureField& field, const Codebook& codebook);

}  // namespace vol::features
