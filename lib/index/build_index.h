#pragma once
#include "index/index_volume.h"
#include "index/significant_details.h"
#include "volume/field_sampler.h"
#include "volume/grid_geometry.h"

namespace vol::index {

struct IndexOptions {
  double standard_distance = 0.5;  ///< d, world length
  bool look_ahead = true;          ///< no step leaves the region that allows it; false: He's blind steps
  int reduction = 1;               ///< one entry for reduction^3 cells: the smallest of theirs
  volume::Reconstruction reconstruction = volume::Reconstruction::trilinear;  ///< whose footprint counts
};

/// The index volume (He 1998): L of a cell is the largest number for which no voxel that a step of 2^L d can
/// reach has a significant detail on the levels 1..L.
///
/// The voxels of a position are those under the reconstruction kernel. With look-ahead a step from anywhere
/// in the cell, in any direction, of world length 2^L d, must stay among voxels without significant details;
/// without it only the cell itself must. L is at most the number of levels and at most 15.
///
/// Axis by axis, the entries from which a coefficient is met are an interval: the voxels it bears on, widened
/// by kernel and step, divided by the reduction. Each coefficient so forbids a box of entries. Boxes are
/// united in slabs of 16 planes of entries, one bit each: beside the index this takes about a hundredth of
/// its size, a thread.
///
/// \throws vol::Error when the details' dims are not the geometry's, or the standard distance is not positive
[[nodiscard]] IndexVolume build_index(const SignificantDetails& details, const volume::GridGeometry& geometry,
                                      const IndexOptions& options);

}  // namespace vol::index
