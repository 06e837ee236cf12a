#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/rng.h"
#include "index/build_index.h"
#include "index/classify.h"
#include "index/significant_details.h"
#include "wavelet/dwt.h"
#include "wavelet/filters.h"

namespace vol::index {
namespace {

using volume::Grid;
using volume::GridGeometry;
using volume::Volume;

GridGeometry geometry(const Dims& dims, const Vec3& spacing = Vec3(1, 1, 1)) {
  GridGeometry g;
  g.dims = dims;
  g.spacing = spacing;
  g.origin = Vec3(-3, 5, 0.5);
  return g;
}

Volume smooth_with_noise(const GridGeometry& g, std::uint64_t seed) {
  Rng rng(seed);
  Grid<float> grid{g, Buffer<float>(static_cast<std::size_t>(g.count()))};
  const double noisy = rng.uniform(0, static_cast<double>(g.dims[0]));
  for (std::int64_t k = 0; k < g.dims[2]; ++k) {
    for (std::int64_t j = 0; j < g.dims[1]; ++j) {
      for (std::int64_t i = 0; i < g.dims[0]; ++i) {
        const double noise = std::abs(static_cast<double>(i) - noisy) < 3 ? rng.normal() : 0.0;
        grid(i, j, k) = static_cast<float>(std::sin(0.1 * static_cast<double>(i + 2 * j - k)) + noise);
      }
    }
  }
  Volume v;
  v.grid = std::move(grid);
  return v;
}

double spacing_of_step(const IndexOptions& options, int level, double spacing) {
  return std::ceil(options.look_ahead ? std::ldexp(options.standard_distance, level) / spacing : 0.0);
}

// He's definition, coefficient by coefficient and cell by cell, against the sets of bits.
int level_by_definition(const wavelet::Decomposition<double>& d, const SignificanceOptions& s, const IndexOptions& o,
                        std::int64_t i, std::int64_t j, std::int64_t k) {
  const std::array<std::int64_t, 3> cell = {i, j, k};
  int level = 0;
  for (int L = 1; L <= d.levels; ++L) {
    for (const auto& band : d.subbands) {
      if (band.orientation == 0 || band.level > L) continue;
      const auto support = relevant_support(d.wavelet, band.level, s.energy_share);
      const double scale = s.normalisation == Normalisation::amplitude ? std::pow(2.0, -1.5 * band.level) : 1.0;
      const double weight = s.rule == Rule::segment ? std::ldexp(1.0, band.level) : 1.0;
      for (std::int64_t n = 0; n < static_cast<std::int64_t>(band.coefficients.size()); ++n) {
        if (!(std::abs(band.coefficients[static_cast<std::size_t>(n)]) * scale * weight > s.epsilon)) continue;
        const std::array<std::int64_t, 3> at = {n % band.dims[0], n / band.dims[0] % band.dims[1],
                                                n / band.dims[0] / band.dims[1]};
        bool reached = true;
        for (std::size_t a = 0; a < 3; ++a) {
          const auto reach = static_cast<std::int64_t>(spacing_of_step(o, L, d.geometry.spacing[static_cast<int>(a)]));
          const std::int64_t first = std::max<std::int64_t>(0, cell[a] - reach);
          const std::int64_t last = std::min(d.geometry.dims[a] - 1, cell[a] + 1 + reach);
          bool axis = false;
          for (std::int64_t v = first; v <= last && !axis; ++v) {
            const std::int64_t base = (std::int64_t{1} << band.level) * (at[a] + band.lower[a]);
            for (std::int64_t x = base + support.first; x <= base + support.last && !axis; ++x) {
              const std::int64_t n_ext = d.extended_dims[a];
              axis = (d.boundary == wavelet::Boundary::periodic ? ((x % n_ext) + n_ext) % n_ext : x) == v;
            }
          }
          reached = reached && axis;
        }
        if (reached) return level;
      }
    }
    level = L;
  }
  return level;
}

TEST(BuildIndex, IsTheDefinition) {
  Rng rng(21);
  int different_levels = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const auto g = geometry({13, 9, 6}, trial % 2 ? Vec3(1, 1, 1) : Vec3(0.5, 2, 1.25));
    wavelet::DwtOptions dwt;
    dwt.wavelet = trial % 3 == 0 ? "haar" : "daubechies-4";
    dwt.levels = 2;
    dwt.boundary = trial % 4 < 2 ? wavelet::Boundary::periodic : wavelet::Boundary::symmetric;
    const Volume v = smooth_with_noise(g, rng.next());
    const auto d = wavelet::analyze<double>(v, dwt, volume::value_range(v));
    SignificanceOptions s;
    s.epsilon = rng.uniform(0.02, 0.3);
    s.rule = trial % 2 ? Rule::segment : Rule::magnitude;
    s.normalisation = trial % 5 == 0 ? Normalisation::orthonormal : Normalisation::amplitude;
    s.energy_share = trial % 3 == 1 ? 0.9 : 1;
    IndexOptions o;
    o.standard_distance = 0.4;
    o.look_ahead = trial % 3 != 2;
    const auto index = build_index(significant_details(d, s), g, o);
    std::array<int, 16> seen{};
    for (std::int64_t k = 0; k < g.dims[2]; ++k) {
      for (std::int64_t j = 0; j < g.dims[1]; ++j) {
        for (std::int64_t i = 0; i < g.dims[0]; ++i) {
          ASSERT_EQ(index.entry(i, j, k), level_by_definition(d, s, o, i, j, k))
              << "trial " << trial << " cell " << i << " " << j << " " << k;
          ++seen[static_cast<std::size_t>(index.entry(i, j, k))];
        }
      }
    }
    different_levels += seen[0] > 0 && (seen[1] > 0 || seen[2] > 0);
  }
  EXPECT_GE(different_levels, 3);  // the comparison has met more than all-zero indices
}

TEST(BuildIndex, AConstantVolumeGetsTheLargestLevelAndInfiniteEpsilonToo) {
  const auto g = geometry({17, 9, 12});
  Volume v = volume::allocate(volume::VoxelType::f32, g);
  for (auto& x : std::get<Grid<float>>(v.grid).voxels) x = 1e8f;
  wavelet::DwtOptions dwt;
  dwt.wavelet = "daubechies-8";
  dwt.levels = 3;
  const auto d = wavelet::analyze<float>(v, dwt, volume::value_range(v));
  const auto index = build_index(significant_details(d, {}), g, {});
  EXPECT_EQ(index.entry(8, 4, 6), 3);  // rounding of the transform on 1e8 is not detail
  const auto noisy = smooth_with_noise(g, 3);
  SignificanceOptions all;
  all.epsilon = std::numeric_limits<double>::infinity();
  const auto d2 = wavelet::analyze<float>(noisy, dwt, volume::value_range(noisy));
  EXPECT_EQ(build_index(significant_details(d2, all), g, {}).entry(0, 0, 0), 3);
}

TEST(BuildIndex, ReductionTakesTheSmallestOfItsCells) {
  const auto g = geometry({21, 10, 7});
  const Volume v = smooth_with_noise(g, 8);
  wavelet::DwtOptions dwt;
  dwt.levels = 2;
  const auto d = wavelet::analyze<float>(v, dwt, volume::value_range(v));
  SignificanceOptions s;
  s.epsilon = 0.2;
  IndexOptions full, reduced;
  reduced.reduction = 3;
  const auto sets = significant_details(d, s);
  const auto fine = build_index(sets, g, full);
  const auto coarse = build_index(sets, g, reduced);
  for (std::int64_t k = 0; k < 7; ++k) {
    for (std::int64_t j = 0; j < 10; ++j) {
      for (std::int64_t i = 0; i < 21; ++i) EXPECT_LE(coarse.entry(i / 3, j / 3, k / 3), fine.entry(i, j, k));
    }
  }
  int least = 15;
  for (std::int64_t n = 0; n < 27; ++n) least = std::min(least, fine.entry(n % 3, n / 3 % 3, n / 9));
  EXPECT_EQ(coarse.entry(0, 0, 0), least);
}

// A transfer function that shows one band only: where the volume lies outside it the classified field is constant,
// whatever the data do there, and the index allows the longest steps.
TEST(ClassifiedDetails, WhatIsInvisibleNeedsNoSamples) {
  const auto g = geometry({32, 8, 8});
  Grid<float> grid{g, Buffer<float>(static_cast<std::size_t>(g.count()))};
  Rng rng(2);
  for (std::size_t n = 0; n < grid.voxels.size(); ++n) {
    const bool noisy_half = n % 32 >= 16;
    grid.voxels[n] = static_cast<float>(noisy_half ? 10 * rng.uniform() : 100 + 20 * rng.uniform());
  }
  Volume v;
  v.grid = std::move(grid);
  wavelet::DwtOptions dwt;
  dwt.levels = 2;
  const auto d = wavelet::analyze<float>(v, dwt, volume::value_range(v));
  const transfer::TransferFunction band({{0, {1, 1, 1}}}, {{50, 0}, {100, 0.1}, {130, 0.9}});
  IndexOptions o;
  o.standard_distance = 1;
  const SignificanceOptions s;
  const auto raw = build_index(significant_details(d, s), g, o);
  const auto aware = build_index(significant_classified_details(d, band, 1, 1, s), g, o);
  EXPECT_EQ(raw.entry(25, 4, 4), 0);
  EXPECT_EQ(aware.entry(25, 4, 4), 2);
  EXPECT_EQ(aware.entry(5, 4, 4), 0);
}

TEST(RelevantSupport, HoldsTheShareAndGrowsWithIt) {
  const auto full = relevant_support("battle-lemarie-3", 1, 1);
  const auto most = relevant_support("battle-lemarie-3", 1, 0.99);
  EXPECT_GT(full.last - full.first, 60);
  EXPECT_LT(most.last - most.first, 12);
  const auto haar = relevant_support("haar", 3, 1);
  EXPECT_EQ(haar.first, 0);
  EXPECT_EQ(haar.last, 7);
  EXPECT_THROW((void)relevant_support("haar", 1, 0), Error);
}

}  // namespace
}  // namespace vol::index
