#include <gtest/gtest.h>

#include "base/error.h"
#include "base/parallel.h"
#include "direct.h"
#include "fourier/slice_source.h"
#include "transfer/bezier.h"

namespace vol::fourier {
namespace {

using namespace fourier_test;

RowSource rows_of(const volume::Grid<double>& f) {
  return [&f](std::int64_t j, std::int64_t k, std::span<double> row) {
    std::copy_n(&f(0, j, k), row.size(), row.begin());
  };
}

SpectrumInfo info_of(const volume::Grid<double>& f, double padding,
                     const std::string& compensation = "none") {
  SpectrumInfo info;
  info.geometry = f.geometry;
  info.padding = padding;
  for (int a = 0; a < 3; ++a) info.padded[a] = padded_size(f.dims()[a], padding);
  info.compensation = compensation;
  return info;
}

const Dims kSizes[] = {{7, 11, 13}, {8, 6, 10}, {9, 4, 5}, {1, 9, 6}, {5, 1, 8},
                       {4, 7, 1},   {1, 1, 12}, {1, 1, 1}, {2, 3, 2}};

TEST(Spectrum, EveryNumberIsItsDirectSum) {
  for (const Dims& dims : kSizes) {
    for (const double padding : {1.0, 1.25, 1.5, 2.0, 4.0}) {
      const auto f = white_noise(oblique_geometry(dims), 3);
      const auto info = info_of(f, padding);
      const auto spectrum = transform<double>(info, {rows_of(f)});
      const Dims& m = info.padded;
      double worst = 0, norm = 0;
      for (const double v : f.voxels) norm += std::abs(v);
      for (std::int64_t k = 0; k < m[2]; ++k) {
        for (std::int64_t j = 0; j < m[1]; ++j) {
          for (std::int64_t i = 0; i < info.row_length(); ++i) {
            const Complex truth =
                direct_sum(f, Vec3(double(i) / double(m[0]), double(j - m[1] / 2) / double(m[1]),
                                   double(k - m[2] / 2) / double(m[2])));
            const auto at = static_cast<std::size_t>(2 * (i + info.row_length() * (j + m[1] * k)));
            worst = std::max(worst,
                             std::abs(Complex(spectrum.fields[0][at], spectrum.fields[0][at + 1]) - truth));
          }
        }
      }
      // Rounding of a transform grows with log M, of the direct sum with the number of terms: some tens of
      // ulp.
      EXPECT_LT(worst, 1e-14 * norm) << dims[0] << " " << dims[1] << " " << dims[2] << " padding " << padding;
    }
  }
}

TEST(Spectrum, MarginsHoldWhatTheSymmetriesSay) {
  for (const Dims& dims : kSizes) {
    const auto f = white_noise(oblique_geometry(dims), 4);
    const auto info = info_of(f, 1.25);
    const int taps = 8;
    const auto source = slice_source(transform<double>(info, {rows_of(f)}), taps);
    const std::int64_t margin = taps / 2 + 1;
    const Dims& m = info.padded;
    double worst = 0, norm = 0;
    for (const double v : f.voxels) norm += std::abs(v);
    for (std::int64_t k = -m[2] / 2 - margin; k <= m[2] / 2 + margin; ++k) {
      for (std::int64_t j = -m[1] / 2 - margin; j <= m[1] / 2 + margin; ++j) {
        for (std::int64_t i = -margin; i <= m[0] / 2 + margin; ++i) {
          const Complex truth = direct_sum(
              f, Vec3(double(i) / double(m[0]), double(j) / double(m[1]), double(k) / double(m[2])));
          const double* at = source.at(0, i, j, k);
          worst = std::max(worst, std::abs(Complex(at[0], at[1]) - truth));
        }
      }
    }
    EXPECT_LT(worst, 1e-14 * norm) << dims[0] << " " << dims[1] << " " << dims[2];
  }
}

TEST(Spectrum, InverseGivesTheVolumeBack) {
  for (const Dims& dims : kSizes) {
    for (const char* compensation : {"none", "trilinear", "es:6"}) {
      const auto f = white_noise(oblique_geometry(dims), 5);
      auto spectrum = transform<double>(info_of(f, 1.5, compensation), {rows_of(f)});
      const auto back = inverse(spectrum, 0);
      EXPECT_EQ(back.geometry, f.geometry);
      // Compensation multiplies rounding by at most 1/W^3, below 100 at this padding.
      EXPECT_LT(largest_difference(back.voxels, f.voxels), 1e-13) << compensation;
    }
  }
}

TEST(Spectrum, ThreadsDoNotCount) {
  const auto f = white_noise(oblique_geometry({33, 20, 31}), 6);
  const auto info = info_of(f, 1.5, "es:4");
  set_thread_count(1);
  const auto one = transform<float>(info, {rows_of(f)});
  set_thread_count(3);
  const auto three = transform<float>(info, {rows_of(f)});
  set_thread_count(0);
  EXPECT_EQ(one.fields[0], three.fields[0]);
}

TEST(Spectrum, OverflowAndImpossibleSizesAreRefused) {
  auto f = grid_of(oblique_geometry({4, 4, 4}));
  std::fill(f.voxels.begin(), f.voxels.end(), 3e37);
  EXPECT_THROW((void)transform<float>(info_of(f, 2), {rows_of(f)}), Error);
  EXPECT_NO_THROW((void)transform<double>(info_of(f, 2), {rows_of(f)}));
  auto info = info_of(f, 2);
  info.padded[1] = 3;
  EXPECT_THROW((void)transform<double>(info, {rows_of(f)}), Error);
  info.padded = {std::int64_t{1} << 40, std::int64_t{1} << 40, 4};
  EXPECT_THROW((void)spectrum_bytes<float>(info), Error);
}

TEST(Spectrum, WhatContradictsItselfIsRefused) {
  const auto f = grid_of(oblique_geometry({4, 5, 6}));
  const auto good = info_of(f, 1.5);
  EXPECT_NO_THROW(good.validate());
  const auto refused = [&](auto change) {
    auto info = good;
    change(info);
    EXPECT_THROW(info.validate(), Error) << info.model << " " << info.names.size() << " " << info.padding;
  };
  refused([](auto& i) { i.padding = 1; });
  refused([](auto& i) { i.padding = 4; });
  refused([](auto& i) { i.padding = std::nan(""); });
  refused([](auto& i) { i.padded[1] += 1; });
  refused([](auto& i) { i.model = "frobnicate"; });
  refused([](auto& i) { i.model = "depth-cue"; });
  refused([](auto& i) { i.names = {"a", "b"}; });
  refused([](auto& i) {
    i.model = "bezier";
    i.names.resize(transfer::kMostControlPoints + 1);
  });
  refused([](auto& i) {  // a size whose padding is not looked for one by one
    i.geometry.dims = {std::int64_t{1} << 58, 1, 1};
    i.padded = {(std::int64_t{1} << 58) / 2 * 3, 2, 2};
  });
}

TEST(Spectrum, TheInverseOfWhatIsNotFiniteIsRefused) {
  const auto f = white_noise(oblique_geometry({4, 5, 6}), 9);
  for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF}) {
    for (const std::size_t at : {std::size_t{0}, std::size_t{77}}) {
      auto spectrum = transform<float>(info_of(f, 1.5), {rows_of(f)});
      spectrum.fields[0][at] = bad;
      EXPECT_THROW((void)inverse(spectrum, 0), Error) << bad << " at " << at;
    }
  }
  auto spectrum = transform<float>(info_of(f, 1.5), {rows_of(f)});  // finite, but their sum is not
  std::fill(spectrum.fields[0].begin(), spectrum.fields[0].end(), 1e38f);
  EXPECT_THROW((void)inverse(spectrum, 0), Error);
}

TEST(Spectrum, PaddedSizes) {
  EXPECT_EQ(padded_size(251, 1), 251);
  EXPECT_EQ(padded_size(251, 2), 502);
  EXPECT_EQ(padded_size(251, 1.5), 378);
  EXPECT_EQ(padded_size(1, 1.25), 2);
  EXPECT_EQ(next_fast_size(11, true), 15);
  EXPECT_EQ(next_fast_size(11), 12);
}

}  // namespace
}  // namespace vol::fourier
