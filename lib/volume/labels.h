#pragma once
#include <cstdint>
#include <vector>

#include "volume/volume.h"

namespace vol::volume {

/// A volume of labels: any voxel type, so long as every voxel is a whole number from 0 to 255.
/// \throws vol::Error with the first position that is none
[[nodiscard]] Grid<std::uint8_t> label_grid(const Volume& volume);

/// The labels that occur, ascending.
[[nodiscard]] std::vector<int> labels_in(const Grid<std::uint8_t>& labels);

/// 1 where a voxel has the label, else 0: its trilinear field is the label's share of each point.
[[nodiscard]] Volume indicator(const Grid<std::uint8_t>& labels, int label);

}  // namespace vol::volume
