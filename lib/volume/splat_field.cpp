#include "volume/splat_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace vol::volume {

SplatField::SplatField(Grid<std::uint8_t> labels, const std::vector<bool>& chosen,
                       const SplatOptions& options)
    : labels_(std::move(labels)),
      support_(options.support),
      world_to_index_(labels_.geometry.world_to_index_matrix()),
      index_to_world_(labels_.geometry.direction * labels_.geometry.spacing.asDiagonal()) {
  if (!(support_ > 0)) throw Error("the support of a splat is a positive length");
  for (int a = 0; a < 3; ++a) reach_[a] = support_ * world_to_index_.row(a).norm();
  // A ray through filled voxels meets the cube of this number of splats in every voxel: beyond a few, a
  // picture takes hours.
  constexpr double kMostVoxels = 8, kLeastVoxels = 0.01;
  if (!(reach_.maxCoeff() <= kMostVoxels)) {
    throw Error("a splat of support " + std::to_string(support_) + " covers more than " +
                std::to_string(static_cast<int>(kMostVoxels)) + " voxels either way, take a smaller one");
  }
  if (!(reach_.minCoeff() >= kLeastVoxels)) {
    throw Error("a splat of support " + std::to_string(support_) +
                " covers less than a hundredth of a voxel, take a larger one");
  }
  for (std::size_t l = 0; l < chosen.size() && l < chosen_.size(); ++l) chosen_[l] = chosen[l];

  const Dims& dims = labels_.dims();
  for (std::size_t a = 0; a < 3; ++a) blocks_[a] = (dims[a] + kBlock - 1) / kBlock;
  any_.assign(static_cast<std::size_t>(blocks_[0] * blocks_[1] * blocks_[2]), 0);
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        if (!chosen_[labels_(i, j, k)]) continue;
        ++count_;
        const std::int64_t block = i / kBlock + blocks_[0] * (j / kBlock + blocks_[1] * (k / kBlock));
        any_[static_cast<std::size_t>(block)] = 1;
        const Vec3 index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        low = low.cwiseMin(index);
        high = high.cwiseMax(index);
      }
    }
  }
  if (count_ == 0) low = high = Vec3::Zero();
  low -= reach_;
  high += reach_;
  bounds_ = {labels_.geometry.origin + index_to_world_ * low,
             index_to_world_ * Mat3((high - low).asDiagonal())};
}

double SplatField::value(const Vec3& p_world) const {
  double sum = 0;
  for_splats(p_world, p_world, [&](std::uint8_t, const Vec3& centre) {
    const double g = std::max(0.0, 1 - (p_world - centre).squaredNorm() / (support_ * support_));
    sum += g * g * g;
  });
  return sum;
}

Vec3 SplatField::gradient(const Vec3& p_world) const {
  Vec3 sum = Vec3::Zero();
  for_splats(p_world, p_world, [&](std::uint8_t, const Vec3& centre) {
    const Vec3 from = p_world - centre;
    const double g = std::max(0.0, 1 - from.squaredNorm() / (support_ * support_));
    sum -= 6 * g * g / (support_ * support_) * from;
  });
  return sum;
}

void SplatField::shares(const Vec3& p_world, std::array<double, 256>& of) const {
  of.fill(0);
  for_splats(p_world, p_world, [&](std::uint8_t label, const Vec3& centre) {
    const double g = std::max(0.0, 1 - (p_world - centre).squaredNorm() / (support_ * support_));
    of[label] += g * g * g;
  });
}

}  // namespace vol::volume
