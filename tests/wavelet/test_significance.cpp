#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "random_volume.h"
#include "wavelet/dwt.h"
#include "wavelet/filters.h"
#include "wavelet/layout.h"
#include "wavelet/significance.h"

namespace vol::wavelet {
namespace {

using volume::Volume;

template <class T = double>
Decomposition<T> analyzed(const Volume& volume, const DwtOptions& options) {
  return analyze<T>(volume, options, volume::value_range(volume));
}

double l2_difference(const Buffer<double>& a, const Buffer<double>& b) {
  double sum = 0;
  for (std::size_t n = 0; n < a.size(); ++n) sum += (a[n] - b[n]) * (a[n] - b[n]);
  return std::sqrt(sum);
}

std::vector<double> all_coefficients(const Decomposition<double>& d) {
  std::vector<double> all;
  for (const auto& band : d.subbands)
    all.insert(all.end(), band.coefficients.begin(), band.coefficients.end());
  return all;
}

// Approximation at level 2: three scaling functions; a detail HHL at level 1 (orientation 3): one.
TEST(Significance, WeightsOfThePapers) {
  const Dims box{8, 8, 8};
  EXPECT_DOUBLE_EQ(significance_weight(Significance::gross, 2, 0, box), std::pow(2, 1.5 + 3));
  EXPECT_DOUBLE_EQ(significance_weight(Significance::gross, 1, 3, box), std::pow(2, 0.5 + 1.5));
  EXPECT_DOUBLE_EQ(significance_weight(Significance::gross, 1, 7, box), std::pow(2, 1.5));
  EXPECT_DOUBLE_EQ(significance_weight(Significance::muraki, 2, 5, box), 64);
  EXPECT_DOUBLE_EQ(significance_weight(Significance::amplitude, 2, 5, box), 0.125);
  EXPECT_DOUBLE_EQ(significance_weight(Significance::energy, 2, 5, box), 1);
  EXPECT_DOUBLE_EQ(significance_weight(Significance::amplitude, 2, 1, {8, 1, 1}), 0.5);  // one axis: 2^(-m/2)
  EXPECT_EQ(significance_from_name("gross"), Significance::gross);
  EXPECT_THROW((void)significance_from_name("Gross"), Error);
}

// An amplitude is on the data's scale: the constant 7 has approximation amplitude 7 at any level.
TEST(Significance, AmplitudeOfAConstantIsTheConstant) {
  Volume f = random_volume<double>({8, 16, 24}, 1);
  auto& voxels = std::get<volume::Grid<double>>(f.grid).voxels;
  std::fill(voxels.begin(), voxels.end(), 7.0);
  for (int levels = 1; levels <= 3; ++levels) {
    const auto d = analyzed(f, {.wavelet = "coiflet-6", .levels = levels});
    const double weight = significance_weight(Significance::amplitude, levels, 0, d.extended_dims);
    EXPECT_NEAR(weight * d.subbands[0].coefficients[0], 7, 1e-13);
  }
}

// The oracle: sort everything, stably, and keep the first N.
TEST(Reject, KeepsTheNMostSignificant) {
  const Volume f = random_volume<double>({20, 12, 16}, 3);
  for (const auto significance :
       {Significance::gross, Significance::muraki, Significance::energy, Significance::amplitude}) {
    const auto d = analyzed(f, {.wavelet = "daubechies-4", .levels = 2});
    struct Entry {
      double significance;
      std::size_t position;
    };
    std::vector<Entry> sorted;
    for (const auto& band : d.subbands) {
      const double w = significance_weight(significance, band.level, band.orientation, d.extended_dims);
      for (const double c : band.coefficients) sorted.push_back({w * std::abs(c), sorted.size()});
    }
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const auto& a, const auto& b) { return a.significance > b.significance; });
    for (const std::int64_t n : {0, 1, 77, 1000, 3839, 3840, 9999}) {
      auto kept = d;
      const auto report = reject(kept, {.significance = significance, .keep = n});
      const auto expected = std::min<std::int64_t>(n, static_cast<std::int64_t>(sorted.size()));
      EXPECT_EQ(report.kept, expected);
      EXPECT_EQ(report.total, 20 * 12 * 16);
      const auto before = all_coefficients(d), after = all_coefficients(kept);
      for (std::size_t r = 0; r < sorted.size(); ++r) {
        const auto p = sorted[r].position;
        ASSERT_EQ(after[p], static_cast<std::int64_t>(r) < expected ? before[p] : 0) << n << " " << r;
      }
    }
  }
}

// A checkerboard of two values has whole subbands of equal coefficients: the earlier ones win, on any thread
// count.
TEST(Reject, TiesGoToTheEarlierCoefficient) {
  Volume f = random_volume<double>({8, 8, 8}, 1);
  auto& voxels = std::get<volume::Grid<double>>(f.grid).voxels;
  for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = (n % 8 + n / 8 % 8 + n / 64) % 2 == 0 ? 3 : -3;
  auto d = analyzed(f, {.wavelet = "haar", .levels = 1});
  auto& band = d.subbands.back();  // HHH, where all of it lies
  ASSERT_NEAR(std::abs(band.coefficients[5]), 3 * std::sqrt(8.0), 1e-14);
  for (auto& c : band.coefficients) c = std::copysign(3, c);
  for (auto& other : d.subbands) {
    if (other.orientation != 7) std::fill(other.coefficients.begin(), other.coefficients.end(), 0.0);
  }
  const auto report = reject(d, {.keep = 10});
  EXPECT_EQ(report.kept, 10);
  EXPECT_EQ(report.nonzero, 64);
  for (std::size_t n = 0; n < 64; ++n) EXPECT_EQ(band.coefficients[n] != 0, n < 10) << n;
}

TEST(Reject, KeepsAsFewAsHoldTheShareOfEnergy) {
  const Volume f = random_volume<double>({20, 12, 16}, 5);
  for (const double share : {0.0, 0.1, 0.5, 0.9, 0.999, 1.0}) {
    auto d = analyzed(f, {.wavelet = "coiflet-6", .levels = 2});
    const double before = energy(d);
    double smallest = 1e300;
    const auto report = reject(d, {.keep_energy = share});
    const double after = energy(d);
    EXPECT_GE(after, share * before * (1 - 1e-13));
    for (const double c : all_coefficients(d)) {
      if (c != 0) smallest = std::min(smallest, c * c);
    }
    if (report.kept > 0 && share < 1) {
      EXPECT_LT(after - smallest, share * before * (1 + 1e-13));
    }
    EXPECT_NEAR(report.rejected_norm * report.rejected_norm, before - after, 1e-10 * before);
    EXPECT_NEAR(report.norm * report.norm, before, 1e-12 * before);
  }
}

TEST(Reject, ThresholdKeepsWhatReachesIt) {
  auto d = analyzed(random_volume<double>({16, 8, 24}, 6), {.wavelet = "haar", .levels = 3});
  const auto original = d;
  (void)reject(d, {.significance = Significance::amplitude, .threshold = 0.05});
  for (std::size_t b = 0; b < d.subbands.size(); ++b) {
    const double w = std::exp2(-1.5 * d.subbands[b].level);
    for (std::size_t n = 0; n < d.subbands[b].coefficients.size(); ++n) {
      const double c = original.subbands[b].coefficients[n];
      EXPECT_EQ(d.subbands[b].coefficients[n], w * std::abs(c) >= 0.05 ? c : 0);
    }
  }
  auto e = original;
  const double c = e.subbands[3].coefficients[2];
  (void)reject(e, {.significance = Significance::energy, .threshold = c * c * (1 + 1e-12)});
  EXPECT_EQ(e.subbands[3].coefficients[2], 0);
}

// Orthonormality, eq. (27): what is rejected is what is lost. On the extended box of a periodic transform to
// 1e-10.
TEST(PredictedError, IsTheTrueErrorOnTheExtendedBox) {
  for (const auto& name : wavelet_names()) {
    const bool orthonormal = make_wavelet(name).orthonormal;
    const Volume f = random_volume<double>({24, 16, 40}, name.size());
    for (const auto boundary : {Boundary::periodic, Boundary::symmetric}) {
      if (boundary == Boundary::symmetric && name.starts_with("battle") && orthonormal)
        continue;  // slow, as others
      auto d = analyzed(f, {.wavelet = name, .levels = 2, .boundary = boundary});
      const auto report = reject(d, {.keep = 2000});
      const auto predicted = predicted_error(d, report);
      const double truth = l2_difference(synthesize(d).voxels, grid_of<double>(f).voxels);
      if (orthonormal && boundary == Boundary::periodic) {
        EXPECT_EQ(predicted.kind, ErrorKind::exact);
        EXPECT_NEAR(truth / predicted.l2, 1, 1e-10) << name;
      } else {
        EXPECT_EQ(predicted.kind,
                  !orthonormal && boundary == Boundary::symmetric ? ErrorKind::estimate : ErrorKind::bound);
        EXPECT_LE(truth, predicted.l2 * (1 + 1e-10)) << name;
        EXPECT_GE(truth, predicted.l2 / 8) << name;  // a bound that says something
      }
    }
  }
}

TEST(PredictedError, IsABoundWhereTheBoxWasExtended) {
  const Volume f = random_volume<double>({13, 9, 22}, 8);
  for (const auto extension : {Extension::replicate, Extension::mirror, Extension::zero}) {
    auto d = analyzed(f, {.wavelet = "daubechies-6", .levels = 3, .extension = extension});
    const auto report = reject(d, {.keep = 500});
    const auto predicted = predicted_error(d, report);
    EXPECT_EQ(predicted.kind, ErrorKind::bound);
    // On the extended box itself it is exact: transform the box as a volume of its own.
    auto box = d;
    box.geometry.dims = d.extended_dims;
    auto whole = analyzed(f, {.wavelet = "daubechies-6", .levels = 3, .extension = extension});
    whole.geometry.dims = d.extended_dims;
    EXPECT_NEAR(l2_difference(synthesize(box).voxels, synthesize(whole).voxels) / predicted.l2, 1, 1e-10);
    const double truth = l2_difference(synthesize(d).voxels, grid_of<double>(f).voxels);
    EXPECT_LE(truth, predicted.l2);
    EXPECT_GT(truth, 0.1 * predicted.l2);
  }
}

// Inside the region nothing is lost; outside, without a criterion, only the approximation is left.
TEST(Region, KeepsAllDetailInsideAndTheApproximationOutside) {
  const Dims dims{40, 30, 25};
  const Volume f = random_volume<double>(dims, 11);
  const VoxelBox box{{5, 20, 0}, {17, 30, 9}};
  for (const auto boundary : {Boundary::periodic, Boundary::symmetric}) {
    for (const char* name : {"haar", "daubechies-6", "battle-lemarie:29"}) {
      const DwtOptions options{.wavelet = name, .levels = 2, .boundary = boundary};
      auto d = analyzed(f, options);
      const auto all = synthesize(d);
      auto approximation = d;
      for (auto& band : approximation.subbands) {
        if (band.orientation != 0) std::fill(band.coefficients.begin(), band.coefficients.end(), 0.0);
      }
      const auto smooth = synthesize(approximation);
      const auto report = reject(d, {.region = box});
      const auto back = synthesize(d);
      bool outside_differs = false;
      for (std::int64_t k = 0; k < dims[2]; ++k) {
        for (std::int64_t j = 0; j < dims[1]; ++j) {
          for (std::int64_t i = 0; i < dims[0]; ++i) {
            const bool inside = i >= 5 && i < 17 && j >= 20 && k < 9;
            ASSERT_TRUE(!inside || std::abs(back(i, j, k) - all(i, j, k)) < 1e-14) << name;
            outside_differs |= !inside && std::abs(back(i, j, k) - all(i, j, k)) > 1e-3;
          }
        }
      }
      EXPECT_TRUE(outside_differs || std::string(name) != "haar");
      EXPECT_LE(report.kept, report.total);
      if (std::string(name) == "haar") {  // 4-voxel blocks: far from the box the picture is the smooth one
        EXPECT_NEAR(back(30, 3, 20), smooth(30, 3, 20), 1e-14);
      }
    }
  }
}

// Minimality: dropping any one kept detail coefficient that is not zero changes a voxel of the box.
TEST(Region, KeepsNoCoefficientThatDoesNotReachTheBox) {
  const Volume f = random_volume<double>({16, 1, 24}, 12);
  const VoxelBox box{{14, 0, 3}, {16, 1, 6}};
  auto d = analyzed(f, {.wavelet = "daubechies-4", .levels = 2});
  (void)reject(d, {.region = box});
  for (auto& band : d.subbands) {
    if (band.orientation == 0) continue;
    for (auto& c : band.coefficients) {
      if (c == 0) continue;
      Decomposition<double> one = d;
      for (auto& other : one.subbands) std::fill(other.coefficients.begin(), other.coefficients.end(), 0.0);
      one.subbands[static_cast<std::size_t>(&band - d.subbands.data())]
          .coefficients[static_cast<std::size_t>(&c - band.coefficients.data())] = 1;
      const auto basis = synthesize(one);
      double reach = 0;
      for (std::int64_t k = 3; k < 6; ++k) {
        for (std::int64_t i = 14; i < 16; ++i) reach = std::max(reach, std::abs(basis(i, 0, k)));
      }
      EXPECT_GT(reach, 0) << band.level << " " << band.orientation;
    }
  }
}

TEST(Reject, RefusesCriteriaOutsideTheirRange) {
  auto d = analyzed(random_volume<double>({8, 8, 8}, 1), {.levels = 1});
  EXPECT_THROW((void)reject(d, {.keep = -1}), Error);
  EXPECT_THROW((void)reject(d, {.keep_energy = 1.5}), Error);
  EXPECT_THROW((void)reject(d, {.keep_energy = std::nan("")}), Error);
  EXPECT_THROW((void)reject(d, {.threshold = -1}), Error);
  EXPECT_THROW((void)reject(d, {.keep = 1, .threshold = 1}), Error);
  EXPECT_THROW((void)reject(d, {.region = VoxelBox{{0, 0, 0}, {9, 8, 8}}}), Error);
  EXPECT_THROW((void)reject(d, {.region = VoxelBox{{3, 0, 0}, {3, 8, 8}}}), Error);
}

TEST(Reject, NormsSurviveExtremeScales) {
  for (const double scale : {1e150, 1e-170}) {
    auto d = analyzed(random_volume<double>({8, 8, 8}, 1, scale), {.levels = 2});
    const auto reference = analyzed(random_volume<double>({8, 8, 8}, 1, 1), {.levels = 2});
    const auto report = reject(d, {.keep = 100});
    EXPECT_NEAR(report.norm / scale / std::sqrt(energy(reference)), 1, 1e-12);
    EXPECT_GT(report.rejected_norm, 0);
  }
}

}  // namespace
}  // namespace vol::wavelet
