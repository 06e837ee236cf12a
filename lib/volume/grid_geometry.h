#pragma once
#include <string_view>

#include "base/vec.h"

namespace vol::volume {

/// Anatomical convention of the world axes, where the file states one: left-posterior-superior (NRRD,
/// MetaImage) or right-anterior-superior (NIfTI). The two differ by the sign of x and y.
enum class Space { none, lps, ras };

[[nodiscard]] std::string_view name(Space space);

/// Where the samples of a regular grid lie.
///
/// Sample (i, j, k), x fastest, sits at world  origin + direction (i sx, j sy, k sz): samples are at voxel
/// centres, and the reconstructed field lives on the box spanned by the outermost centres. An axis of one
/// sample is one spacing thick, [-1/2, 1/2] in index space, with the field constant along it.
struct GridGeometry {
  Dims dims{1, 1, 1};
  Vec3 spacing{1, 1, 1};               ///< world distance between samples per axis, > 0
  Vec3 origin{0, 0, 0};                ///< world position of sample (0,0,0)
  Mat3 direction = Mat3::Identity();   ///< columns: unit world vectors of the i, j, k axes; non-singular
  Space space = Space::none;

  /// Throws vol::Error unless dims >= 1 and their product fits, spacing is positive and finite, origin
  /// finite and direction has unit columns and a determinant away from 0.
  void validate() const;

  [[nodiscard]] std::int64_t count() const { return dims[0] * dims[1] * dims[2]; }
  [[nodiscard]] Vec3 index_to_world(const Vec3& p_index) const;
  [[nodiscard]] Vec3 world_to_index(const Vec3& p_world) const;
  /// Linear part of world_to_index.
  [[nodiscard]] Mat3 world_to_index_matrix() const;
  /// The field's box in index space: [0, n-1] per axis, [-1/2, 1/2] where n = 1.
  [[nodiscard]] Box3 index_box() const;
  /// World position of the box's centre.
  [[nodiscard]] Vec3 centre() const;
  /// World lengths of the box's three edges: (n-1) spacing, or one spacing where n = 1.
  [[nodiscard]] Vec3 edge_lengths() const;

  friend bool operator==(const GridGeometry&, const GridGeometry&) = default;
};

}  // namespace vol::volume
