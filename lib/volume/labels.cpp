#include "volume/labels.h"

#include <array>
#include <sstream>

#include "base/error.h"

namespace vol::volume {

Grid<std::uint8_t> label_grid(const Volume& volume) {
  Grid<std::uint8_t> labels;
  labels.geometry = volume.geometry();
  visit(volume, [&](const auto& grid) {
    labels.voxels = Buffer<std::uint8_t>(grid.voxels.size());
    for (std::size_t n = 0; n < grid.voxels.size(); ++n) {
      const auto value = static_cast<double>(grid.voxels[n]);
      const bool is_label = value >= 0 && value <= 255;  // not NaN either
      labels.voxels[n] = is_label ? static_cast<std::uint8_t>(value) : std::uint8_t{0};
      if (!is_label || labels.voxels[n] != value) {
        const Dims& dims = labels.geometry.dims;
        const auto v = static_cast<std::int64_t>(n);
        std::ostringstream message;
        message << "labels are whole numbers from 0 to 255; voxel (" << v % dims[0] << ", "
                << v / dims[0] % dims[1] << ", " << v / dims[0] / dims[1] << ") is " << value;
        throw Error(message.str());
      }
    }
  });
  return labels;
}

std::vector<int> labels_in(const Grid<std::uint8_t>& labels) {
  std::array<bool, 256> met{};
  for (const auto label : labels.voxels) met[label] = true;
  std::vector<int> found;
  for (int label = 0; label < 256; ++label) {
    if (met[static_cast<std::size_t>(label)]) found.push_back(label);
  }
  return found;
}

Volume indicator(const Grid<std::uint8_t>& labels, int label) {
  Volume result = allocate(VoxelType::u8, labels.geometry);
  auto& voxels = std::get<Grid<std::uint8_t>>(result.grid).voxels;
  for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = labels.voxels[n] == label;
  return result;
}

}  // namespace vol::volume
