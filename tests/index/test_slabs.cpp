#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "index/build_index.h"
#include "index/classified_fields.h"
#include "index/classify.h"
#include "whole_index.h"

// The index is made in boxes of the classified fields and slabs of entries: the same entries as by whole
// fields.
namespace vol::index {
namespace {

using volume::GridGeometry;
using volume::Reconstruction;
using volume::Volume;
using volume::VoxelType;

GridGeometry random_geometry(Rng& rng, const Dims& dims) {
  GridGeometry g;
  g.dims = dims;
  g.origin = Vec3(-3, 5, 0.5);
  for (int a = 0; a < 3; ++a) g.spacing[a] = rng.uniform(0.5, 2);
  if (rng.below(3) == 0) {
    const double t = rng.uniform(0, 1.5);
    g.direction.col(0) = Vec3(std::cos(t), std::sin(t), 0);
    g.direction.col(1) = Vec3(-std::sin(t), std::cos(t), 0);
  }
  return g;
}

/// Smooth, with noise in a slanted layer and the value 0 beyond another, on 0 .. 100.
Volume random_volume(Rng& rng, VoxelType type, const GridGeometry& g) {
  Volume v = volume::allocate(type, g);
  const double noisy = rng.uniform(0, 0.6), empty = rng.uniform(0.6, 1.2), wave = rng.uniform(1, 6);
  volume::visit(v, [&](auto& grid) {
    using V = typename std::decay_t<decltype(grid)>::value_type;
    std::size_t n = 0;
    for (std::int64_t k = 0; k < g.dims[2]; ++k) {
      for (std::int64_t j = 0; j < g.dims[1]; ++j) {
        for (std::int64_t i = 0; i < g.dims[0]; ++i) {
          const double at = (double(i) / double(g.dims[0]) + double(j) / double(g.dims[1]) +
                             double(k) / double(g.dims[2])) /
                            3;
          double value = 50 + 25 * std::sin(wave * at);
          if (std::abs(at - noisy) < 0.03) value += 25 * rng.uniform();
          if (at > empty) value = 0;
          grid.voxels[n++] = static_cast<V>(static_cast<float>(value));
        }
      }
    }
  });
  return v;
}

transfer::TransferFunction random_transfer(Rng& rng) {
  const auto colour = [&] { return Vec3(rng.uniform(), rng.uniform(), rng.uniform()); };
  const Vec3 grey = Vec3::Constant(rng.uniform());
  std::vector<transfer::ColourPoint> colours = {{0, rng.below(2) ? grey : colour()}, {100, grey}};
  return {std::move(colours),
          {{10, 0}, {rng.uniform(11, 50), rng.uniform(0, 0.2)}, {80, rng.below(4) == 0 ? 1.0 : 0.1}}};
}

SignificanceOptions random_significance(Rng& rng) {
  SignificanceOptions s;
  s.epsilon = rng.below(4) == 0 ? 0 : std::pow(10, rng.uniform(-8, -1));
  s.rule = rng.below(2) ? Rule::segment : Rule::magnitude;
  s.normalisation = rng.below(4) ? Normalisation::amplitude : Normalisation::orthonormal;
  s.energy_share = std::array{1.0, 0.99, 0.6}[rng.below(3)];
  return s;
}

IndexOptions random_options(Rng& rng) {
  constexpr std::array kReconstructions = {Reconstruction::nearest, Reconstruction::trilinear,
                                           Reconstruction::catmull_rom, Reconstruction::b_spline};
  IndexOptions o;
  o.standard_distance = rng.uniform(0.2, 1.2);
  o.look_ahead = rng.below(3) != 0;
  o.reduction = 1 + static_cast<int>(rng.below(3));
  o.reconstruction = kReconstructions[rng.below(4)];
  return o;
}

wavelet::DwtOptions random_dwt(Rng& rng, bool haar) {
  constexpr std::array kWavelets = {"daubechies-4", "daubechies-8", "coiflet-6", "battle-lemarie-3:29"};
  wavelet::DwtOptions dwt;
  dwt.wavelet = haar ? "haar" : kWavelets[rng.below(4)];
  dwt.levels = 1 + static_cast<int>(rng.below(4));
  dwt.boundary = rng.below(2) ? wavelet::Boundary::periodic : wavelet::Boundary::symmetric;
  dwt.extension = static_cast<wavelet::Extension>(rng.below(3));
  return dwt;
}

/// Compares, entry by entry. \returns the levels that occur
std::set<int> expect_equal(const IndexVolume& index, const IndexVolume& expected) {
  std::set<int> seen;
  EXPECT_EQ(index.dims(), expected.dims());
  EXPECT_EQ(index.nibbles(), expected.nibbles());
  for (const auto byte : expected.nibbles()) seen.insert(byte & 15);
  return seen;
}

std::string text(const Dims& d) {
  return std::to_string(d[0]) + " x " + std::to_string(d[1]) + " x " + std::to_string(d[2]);
}

TEST(Slabs, ClassifiedDetailsGiveTheIndexOfWholeFields) {
  Rng rng(4711);
  constexpr std::array kTypes = {VoxelType::u8,  VoxelType::i8,  VoxelType::u16, VoxelType::i16,
                                 VoxelType::f16, VoxelType::f32, VoxelType::f64, VoxelType::i32};
  std::set<int> levels;
  int mixed = 0;
  for (int trial = 0; trial < 120; ++trial) {
    Dims dims;
    const bool haar = trial % 3 != 0;
    for (auto& n : dims) n = rng.below(8) == 0 ? 1 : 1 + static_cast<std::int64_t>(rng.below(haar ? 50 : 20));
    const auto g = random_geometry(rng, dims);
    const Volume v = random_volume(rng, kTypes[rng.below(kTypes.size())], g);
    const auto transfer = random_transfer(rng);
    const auto s = random_significance(rng);
    const auto o = random_options(rng);
    const auto dwt = random_dwt(rng, haar);
    SCOPED_TRACE("trial " + std::to_string(trial) + ": " + text(dims) + ", " + dwt.wavelet + ", " +
                 std::to_string(dwt.levels) + " levels, reduction " + std::to_string(o.reduction));
    const auto index =
        build_index(significant_classified_details(v, transfer, 1.5, o.standard_distance, dwt, s), g, o);
    const auto seen = expect_equal(
        index,
        whole::build_index(
            whole::significant_classified_voxels(v, transfer, 1.5, o.standard_distance, dwt, s), g, o));
    levels.insert(seen.begin(), seen.end());
    mixed += seen.size() > 1;
    if (HasFailure()) return;
  }
  EXPECT_EQ(levels, (std::set<int>{0, 1, 2, 3, 4}));
  EXPECT_GE(mixed, 20);  // the comparison has met more than uniform indices
}

// More voxels than a box has, cut along y and z, the last boxes partly beyond the volume; many slabs.
TEST(Slabs, SeveralBoxesToo) {
  Rng rng(12);
  int mixed = 0;
  struct Case {
    Dims dims;
    int levels;
  };
  for (const auto& [dims, levels] :
       {Case{{150, 70, 40}, 5}, Case{{37, 300, 41}, 4}, Case{{530, 17, 50}, 4}, Case{{1, 700, 600}, 3},
        Case{{270, 1, 1100}, 2}, Case{{90, 70, 81}, 1}}) {
    const auto g = random_geometry(rng, dims);
    const Volume v = random_volume(rng, VoxelType::u8, g);
    const auto transfer = random_transfer(rng);
    auto dwt = random_dwt(rng, true);
    dwt.levels = levels;
    SignificanceOptions s;
    s.epsilon = 0.01;
    s.rule = Rule::segment;
    auto o = random_options(rng);
    o.standard_distance = 0.3;
    SCOPED_TRACE(text(dims) + ", reduction " + std::to_string(o.reduction));
    const auto seen = expect_equal(
        build_index(significant_classified_details(v, transfer, 1.5, o.standard_distance, dwt, s), g, o),
        whole::build_index(
            whole::significant_classified_voxels(v, transfer, 1.5, o.standard_distance, dwt, s), g, o));
    mixed += seen.size() > 1;
  }
  EXPECT_GE(mixed, 4);
}

TEST(Slabs, DetailsOfATransformGiveTheIndexOfWholeSets) {
  Rng rng(99);
  int mixed = 0;
  for (int trial = 0; trial < 60; ++trial) {
    Dims dims;
    for (auto& n : dims) n = rng.below(8) == 0 ? 1 : 1 + static_cast<std::int64_t>(rng.below(30));
    const auto g = random_geometry(rng, dims);
    const Volume v = random_volume(rng, VoxelType::f32, g);
    auto s = random_significance(rng);
    s.epsilon = rng.below(8) == 0 ? 0 : std::pow(10, rng.uniform(-1, 1.5));
    const auto o = random_options(rng);
    const auto dwt = random_dwt(rng, trial % 3 == 0);
    SCOPED_TRACE("trial " + std::to_string(trial) + ": " + text(dims) + ", " + dwt.wavelet + ", " +
                 std::to_string(dwt.levels) + " levels, reduction " + std::to_string(o.reduction));
    const auto compare = [&](const auto& d) {
      mixed += expect_equal(build_index(significant_details(d, s), g, o),
                            whole::build_index(whole::significant_voxels(d, s), g, o))
                   .size() > 1;
    };
    if (trial % 2) {
      compare(wavelet::analyze<float>(v, dwt, volume::value_range(v)));
    } else {
      compare(wavelet::analyze<double>(v, dwt, volume::value_range(v)));
    }
    if (HasFailure()) return;
  }
  EXPECT_GE(mixed, 15);
}

TEST(Slabs, TheNumberOfThreadsChangesNothing) {
  Rng rng(5);
  const auto g = random_geometry(rng, {130, 70, 90});
  const Volume v = random_volume(rng, VoxelType::u16, g);
  const auto transfer = random_transfer(rng);
  SignificanceOptions s;
  s.epsilon = 0.01;
  const auto built = [&](int threads) {
    set_thread_count(threads);
    return build_index(significant_classified_details(v, transfer, 1, 0.5, {}, s), g, {}).nibbles();
  };
  const auto one = built(1);
  EXPECT_EQ(built(2), one);
  EXPECT_EQ(built(5), one);
  set_thread_count(0);
  EXPECT_NE(std::count(one.begin(), one.end(), one[0]), static_cast<std::ptrdiff_t>(one.size()));
}

TEST(Slabs, DetailsOfOtherDimensionsAreRefused) {
  Rng rng(1);
  const auto g = random_geometry(rng, {9, 8, 7});
  const Volume v = random_volume(rng, VoxelType::f32, g);
  const auto d = wavelet::analyze<float>(v, {}, volume::value_range(v));
  auto other = g;
  other.dims = {9, 8, 6};
  EXPECT_THROW((void)build_index(significant_details(d, {}), other, {}), Error);
  SignificantDetails smaller(other.dims, {}, 1);
  smaller.levels[0].coefficients = BitGrid({1, 1, 1});
  EXPECT_THROW(add_significant(d, {0.0F, 0.0F, 0.0F}, {0, 0, 0}, smaller), Error);
}

// The bound must hold, or a detail that is the transform's rounding would count; and be near, or every volume
// would be searched.
TEST(ClassifiedFields, AreBoundedByTheTransferFunction) {
  Rng rng(77);
  for (int trial = 0; trial < 30; ++trial) {
    const auto g = random_geometry(rng, {11, 6, 5});
    const Volume v = random_volume(rng, trial % 2 ? VoxelType::u8 : VoxelType::f32, g);
    const auto transfer = random_transfer(rng);
    const ClassifiedFields fields(v, transfer, rng.uniform(0.1, 2), rng.uniform(0.1, 2));
    const auto largest = fields.largest();
    ASSERT_EQ(largest.size(), fields.count());
    std::vector<std::vector<float>> voxels(fields.count(),
                                           std::vector<float>(static_cast<std::size_t>(g.count())));
    std::vector<float*> to;
    for (auto& field : voxels) to.push_back(field.data());
    fields.fill({0, 0, 0}, g.dims, wavelet::Extension::zero, to);
    for (std::size_t f = 0; f < fields.count(); ++f) {
      EXPECT_EQ(largest[f], *std::max_element(voxels[f].begin(), voxels[f].end()));
      EXPECT_LE(largest[f], fields.bound(f));
      EXPECT_LE(fields.bound(f), 64);  // twice the deepest, of colours up to 1
    }
  }
}

}  // namespace
}  // namespace vol::index
