#pragma once
#include <vector>

#include "index/bit_grid.h"
#include "index/index_volume.h"
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
/// The voxels of a position are those under the reconstruction kernel. With look-ahead a step from anywhere in the
/// cell, in any direction, of world length 2^L d, must stay among voxels without significant details; without it
/// only the cell itself must. L is at most the number of levels and at most 15.
///
/// \param significant  for levels 1..M, the voxels with a significant relevant detail (significant_details.h);
///                     several fields' sets may be united before
/// \throws vol::Error when the sets' dims are not the geometry's, or the standard distance is not positive
[[nodiscard]] IndexVolume build_index(const std::vector<BitGrid>& significant, const volume::GridGeometry& geometry,
                                      const IndexOptions& options);

}  // namespace vol::index
