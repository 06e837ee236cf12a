#pragma once
#include "base/rng.h"
#include "curvilinear/grid.h"

namespace vol::curvilinear {

/// Points on a jittered lattice of unequal sizes: nothing symmetric, every cell curved.
inline Block random_block(const Dims& dims, std::uint64_t seed, double jitter = 0.3) {
  Block block;
  block.dims = dims;
  Rng random(seed);
  PointArray values{"f", {}};
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const Vec3 off(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
        block.points.push_back(
            Vec3(static_cast<double>(i), 1.5 * static_cast<double>(j), 0.7 * static_cast<double>(k)) +
            jitter * off + Vec3(3, -7, 11));
        values.values.push_back(random.uniform());
      }
    }
  }
  block.arrays.push_back(std::move(values));
  return block;
}

}  // namespace vol::curvilinear
