#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/error.h"
#include "random_volume.h"
#include "wavelet/dwt.h"
#include "wavelet/expansion.h"
#include "wavelet/initialisation.h"
#include "wavelet/significance.h"
#include "wavelet_label.h"

namespace vol::wavelet {
namespace {

/// All but the truncated filters, and daubechies-10.
std::vector<std::string> interpolating_wavelets() {
  std::vector<std::string> names = wavelet_names();
  std::erase_if(names, [](const std::string& name) {
    return !make_wavelet(name).orthonormal || name == "daubechies-10";
  });
  return names;
}
class Interpolation : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Wavelets, Interpolation, testing::ValuesIn(interpolating_wavelets()), wavelet_label);

DwtOptions interpolating(const std::string& wavelet, int levels, Extension extension = Extension::replicate) {
  return {.wavelet = wavelet,
          .levels = levels,
          .extension = extension,
          .initialisation = Initialisation::interpolate};
}

template <class T = double>
Decomposition<T> transformed(const volume::Volume& volume, const DwtOptions& options) {
  return analyze<T>(volume, options, volume::value_range(volume));
}

// Sizes that 2^levels does not divide, and an axis of one sample. A level's functions are exact at the voxels
// if the depth is the level's or more.
TEST_P(Interpolation, TheFieldGoesThroughAllVoxels) {
  for (const Dims& dims : {Dims{7, 6, 5}, Dims{10, 1, 3}}) {
    const auto volume = random_volume<double>(dims, 11);
    const auto& grid = grid_of<double>(volume);
    for (const int depth : {2, 3, 6}) {
      const auto extension = depth == 2   ? Extension::replicate
                             : depth == 3 ? Extension::mirror
                                          : Extension::zero;
      const Expansion f(transformed(volume, interpolating(GetParam(), 2, extension)), {.depth = depth});
      for (std::int64_t k = 0; k < dims[2]; k += 2) {
        for (std::int64_t j = 0; j < dims[1]; ++j) {
          for (std::int64_t i = 0; i < dims[0]; i += 3) {
            const Vec3 p(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
            ASSERT_NEAR(f.value_index(p), grid(i, j, k), 1e-10) << depth << ", at " << p.transpose();
          }
        }
      }
    }
  }
}

TEST_P(Interpolation, TheInverseIsTheVoxels) {
  const auto volume = random_volume<double>({9, 6, 20}, 12, 1e3);
  const auto& voxels = grid_of<double>(volume).voxels;
  for (const int levels : {0, 1, 3}) {
    const auto back = synthesize(transformed(volume, interpolating(GetParam(), levels)));
    EXPECT_EQ(back.geometry.dims, volume.geometry().dims);
    EXPECT_LT(relative_difference(back.voxels, voxels), 1e-12) << levels;
    const auto narrow = synthesize(transformed<float>(volume, interpolating(GetParam(), levels)));
    EXPECT_LT(relative_difference(narrow.voxels, voxels), 1e-5) << levels;  // 60 ulp of float
  }
}

// c0 by the definition: the linear system sum_k phi(n + s - k) c0[k] = f[n] on a period, solved densely.
TEST_P(Interpolation, CoefficientsSolveTheLinearSystem) {
  for (const std::int64_t n : {4, 13, 64}) {
    const auto volume = random_volume<double>({n, 1, 1}, 13);
    const Wavelet wavelet = make_wavelet(GetParam());
    const PiecewiseCubic phi = make_prototypes(wavelet, 1).phi;
    const double s = expansion_shift(wavelet, Initialisation::interpolate);
    Eigen::MatrixXd b(n, n);
    for (Eigen::Index row = 0; row < n; ++row) {
      for (Eigen::Index k = 0; k < n; ++k) {
        b(row, k) = 0;
        for (Eigen::Index turn = -60; turn <= 60; ++turn) {
          b(row, k) += phi.value(static_cast<double>(row - k - turn * n) + s);
        }
      }
    }
    const auto& voxels = grid_of<double>(volume).voxels;
    const Eigen::VectorXd c =
        b.colPivHouseholderQr().solve(Eigen::Map<const Eigen::VectorXd>(voxels.data(), n));
    const auto d = transformed(volume, interpolating(GetParam(), 0));
    for (Eigen::Index k = 0; k < n; ++k) {
      EXPECT_NEAR(d.subbands[0].coefficients[static_cast<std::size_t>(k)], c[k], 1e-12) << k;
    }
  }
}

TEST_P(Interpolation, ConstantsAreReproduced) {
  auto volume = random_volume<double>({9, 6, 1}, 1);
  for (double& v : std::get<volume::Grid<double>>(volume.grid).voxels) v = -2.5;
  const Expansion f(transformed(volume, interpolating(GetParam(), 1)), {.depth = 4});
  Rng rng(8);
  for (int n = 0; n < 50; ++n) {
    EXPECT_NEAR(f.value_index({rng.uniform(0, 8), rng.uniform(0, 5), 0}), -2.5, 1e-11);
  }
}

// The Lagrange functions of phi's spaces reproduce polynomials below the number of vanishing moments, and so
// a cosine of 32 samples up to the spline's deviation: nothing is shifted. Haar is a step: half a sample's
// slope.
TEST_P(Interpolation, NothingIsShifted) {
  constexpr int kPeriod = 32;
  auto volume = random_volume<double>({kPeriod, 1, 1}, 1);
  const double w = 2 * std::numbers::pi / kPeriod;
  auto& voxels = std::get<volume::Grid<double>>(volume.grid).voxels;
  for (std::size_t n = 0; n < kPeriod; ++n) voxels[n] = std::cos(w * static_cast<double>(n));
  const Expansion f(transformed(volume, interpolating(GetParam(), 2)), {.depth = 9});
  const bool haar = GetParam() == "haar";
  double sine = 0;  // a shift by e makes it pi e
  for (int i = 0; i < 31 * 16; ++i) {
    const double x = (i + 0.5) / 16;
    EXPECT_NEAR(f.value_index({x, 0, 0}), std::cos(w * x), haar ? 0.1 : 0.04) << x;
    sine += f.value_index({x, 0, 0}) * std::sin(w * x) / 16;
  }
  for (int i = 31 * 16; i < 32 * 16; ++i) {  // beyond the last voxel nothing is asked
    const double x = (i + 0.5) / 16;
    sine += std::cos(w * x) * std::sin(w * x) / 16;
  }
  // pi e with e = 0.01 of a sample; haar's last step is not the box's.
  EXPECT_NEAR(sine, 0, haar ? 0.1 : 0.03);
}

TEST_P(Interpolation, WhatIsRejectedStaysWithinItsBound) {
  const auto volume = random_volume<double>({12, 9, 8}, 14);
  const auto& voxels = grid_of<double>(volume).voxels;
  for (const std::int64_t keep : {0, 40, 400}) {
    auto d = transformed(volume, interpolating(GetParam(), 2));
    const auto bound = predicted_error(d, reject(d, {.keep = keep}));
    EXPECT_EQ(bound.kind, ErrorKind::bound);
    const auto back = synthesize(d);
    double squares = 0;
    for (std::size_t n = 0; n < voxels.size(); ++n) squares += std::pow(back.voxels[n] - voxels[n], 2);
    EXPECT_LE(std::sqrt(squares), bound.l2 * (1 + 1e-12)) << keep;
    EXPECT_GT(bound.l2, 0);
  }
}

// |B(w)| by its definition on frequencies between those that phi_response() looks at.
TEST_P(Interpolation, ResponseBoundsItsFrequencies) {
  const Wavelet wavelet = make_wavelet(GetParam());
  const PhiSamples b = phi_samples(wavelet);
  const Response response = phi_response(wavelet);
  EXPECT_GE(response.least, kLeastResponse);
  double sum = 0;
  for (const double v : b.values) sum += v;
  EXPECT_NEAR(sum, 1, 1e-13);
  Rng rng(3);
  for (int n = 0; n < 500; ++n) {
    const double w = rng.uniform(0, 2 * std::numbers::pi);
    std::complex<double> at = 0;
    for (std::size_t i = 0; i < b.values.size(); ++i) {
      at += b.values[i] * std::polar(1.0, -w * static_cast<double>(b.first + static_cast<std::int64_t>(i)));
    }
    EXPECT_LE(std::abs(at), response.largest);
    EXPECT_GE(std::abs(at), response.least - 1e-3);
  }
}

TEST(Initialisation, RefusesWhatCannotInterpolate) {
  const auto volume = random_volume<double>({16, 8, 8}, 2);
  EXPECT_NEAR(phi_response(make_wavelet("daubechies-10")).least, 0.0309, 1e-4);
  EXPECT_THROW((void)transformed(volume, interpolating("daubechies-10", 1)), Error);
  EXPECT_THROW((void)transformed(volume, interpolating("battle-lemarie-3:29", 1)), Error);
  auto symmetric = interpolating("daubechies-4", 1);
  symmetric.boundary = Boundary::symmetric;
  EXPECT_THROW((void)transformed(volume, symmetric), Error);
  const auto d = transformed(volume, interpolating("daubechies-4", 1));
  EXPECT_EQ(d.initialisation, Initialisation::interpolate);
  EXPECT_THROW(require_samples(d), Error);
  EXPECT_NO_THROW(require_samples(transformed(volume, {.wavelet = "daubechies-10", .levels = 1})));
}

TEST(Initialisation, ValuesOfAnySize) {
  for (const double size : {1e30, 1e-30}) {
    const auto volume = random_volume<double>({7, 12, 9}, 11, size);
    const auto d = transformed(volume, interpolating("coiflet-6", 2));
    EXPECT_LT(relative_difference(synthesize(d).voxels, grid_of<double>(volume).voxels), 1e-12);
    EXPECT_NEAR(Expansion(d).value_index({3, 4, 5}) / size, grid_of<double>(volume)(3, 4, 5) / size, 1e-10);
  }
  // Of values that their inverse could push out of float's range it is said beforehand.
  EXPECT_THROW(
      (void)transformed<float>(random_volume<double>({8, 8, 8}, 11, 1e38), interpolating("coiflet-6", 1)),
      Error);
}

// Taps of the inverse are cut to a period of 1024: on longer axes nothing is missing.
TEST(Initialisation, LongAxes) {
  for (const char* name : {"daubechies-18", "daubechies-20", "coiflet-30", "battle-lemarie-3"}) {
    const auto volume = random_volume<double>({3000, 1, 2}, 15);
    const auto back = synthesize(transformed(volume, interpolating(name, 3)));
    EXPECT_LT(relative_difference(back.voxels, grid_of<double>(volume).voxels), 1e-12) << name;
  }
}

}  // namespace
}  // namespace vol::wavelet
