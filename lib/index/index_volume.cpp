#include "index/index_volume.h"

#include <string>

#include "base/checked.h"

namespace vol::index {

IndexVolume::IndexVolume(const Dims& volume_dims, int reduction, double standard_distance)
    : volume_dims_(volume_dims), reduction_(reduction), standard_distance_(standard_distance) {
  (void)checked_count(volume_dims);
  if (reduction < 1) throw Error("index reduction " + std::to_string(reduction) + " is below 1");
  if (!(standard_distance > 0)) throw Error("standard sampling distance is not positive");
  for (int a = 0; a < 3; ++a) dims_[a] = (volume_dims[a] + reduction - 1) / reduction;
  row_bytes_ = (dims_[0] + 1) / 2;
  nibbles_.assign(static_cast<std::size_t>(row_bytes_ * dims_[1] * dims_[2]), 0);
}

void IndexVolume::set_entry(std::int64_t i, std::int64_t j, std::int64_t k, int level) {
  const auto byte = static_cast<std::size_t>((i >> 1) + row_bytes_ * (j + dims_[1] * k));
  const int shift = static_cast<int>(i & 1) * 4;
  nibbles_[byte] = static_cast<std::uint8_t>((nibbles_[byte] & ~(15 << shift)) | ((level & 15) << shift));
}

}  // namespace vol::index
