#include "index/macrocells.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/rng.h"

namespace vol::index {
namespace {

volume::Volume random_volume(const Dims& dims) {
  volume::GridGeometry g;
  g.dims = dims;
  volume::Grid<std::int16_t> grid{g, Buffer<std::int16_t>(static_cast<std::size_t>(g.count()))};
  Rng rng(1);
  for (auto& voxel : grid.voxels) voxel = static_cast<std::int16_t>(rng.uniform(-700, 2300));
  return {std::move(grid), {}};
}

TEST(Macrocells, RangesAreThoseOfTheSamplesAroundTheirCells) {
  const Dims dims{19, 8, 33};
  const auto v = random_volume(dims);
  const auto& grid = std::get<volume::Grid<std::int16_t>>(v.grid);
  const Macrocells cells = macrocells(v);
  constexpr std::int64_t kEdge = Macrocells::kEdge;
  ASSERT_EQ(cells.dims, (Dims{(18 + kEdge - 1) / kEdge, (7 + kEdge - 1) / kEdge, (32 + kEdge - 1) / kEdge}));
  for (std::int64_t n = 0; n < cells.dims[0] * cells.dims[1] * cells.dims[2]; ++n) {
    const std::int64_t a = n % cells.dims[0], b = n / cells.dims[0] % cells.dims[1],
                       c = n / cells.dims[0] / cells.dims[1];
    float lo = 1e9F, hi = -1e9F;
    for (std::int64_t k = kEdge * c; k <= std::min<std::int64_t>(kEdge * c + kEdge, 32); ++k) {
      for (std::int64_t j = kEdge * b; j <= std::min<std::int64_t>(kEdge * b + kEdge, 7); ++j) {
        for (std::int64_t i = kEdge * a; i <= std::min<std::int64_t>(kEdge * a + kEdge, 18); ++i) {
          lo = std::min(lo, float(grid(i, j, k)));
          hi = std::max(hi, float(grid(i, j, k)));
        }
      }
    }
    EXPECT_EQ(cells(a, b, c).min, lo);
    EXPECT_EQ(cells(a, b, c).max, hi);
  }
}

}  // namespace
}  // namespace vol::index
