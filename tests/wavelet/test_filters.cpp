#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "base/error.h"
#include "wavelet/filter_design.h"
#include "wavelet/filters.h"

namespace vol::wavelet {
namespace {

class EveryWavelet : public testing::TestWithParam<std::string> {
 protected:
  Wavelet wavelet_ = make_wavelet(GetParam());
};

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  for (char& c : name) {
    if (c == '-' || c == ':') c = '_';
  }
  return name;
}

/// sum_n a[n] b[n + 2 shift], relative to the common window.
double correlation(const std::vector<double>& a, const std::vector<double>& b, std::int64_t shift) {
  double sum = 0;
  const auto n = static_cast<std::int64_t>(a.size());
  for (std::int64_t i = 0; i < n; ++i) {
    if (i + 2 * shift >= 0 && i + 2 * shift < n) {
      sum += a[static_cast<std::size_t>(i)] * b[static_cast<std::size_t>(i + 2 * shift)];
    }
  }
  return sum;
}

TEST_P(EveryWavelet, LowPassSumsToRootTwo) {
  double sum = 0;
  for (const double h : wavelet_.bank.h) sum += h;
  // Cutting a Battle-Lemarie filter leaves out its tail: sum of the taps beyond 14 is 1.5e-3 at most.
  EXPECT_NEAR(sum, std::numbers::sqrt2, wavelet_.orthonormal ? 1e-15 : 4e-3);
}

// Each tap carries half an ulp of rounding, 1e-16 of the largest.
TEST_P(EveryWavelet, FiltersAreOrthonormalUnderDoubleShifts) {
  const double tolerance = wavelet_.orthonormal ? 1e-15 : 2e-3;
  for (std::int64_t s = -wavelet_.bank.taps(); s <= wavelet_.bank.taps(); ++s) {
    EXPECT_NEAR(correlation(wavelet_.bank.h, wavelet_.bank.h, s), s == 0 ? 1 : 0, tolerance) << s;
    EXPECT_NEAR(correlation(wavelet_.bank.g, wavelet_.bank.g, s), s == 0 ? 1 : 0, tolerance) << s;
    EXPECT_NEAR(correlation(wavelet_.bank.h, wavelet_.bank.g, s), 0, tolerance) << s;
  }
}

TEST_P(EveryWavelet, TruncationIsVisible) {
  double worst = 0;
  for (std::int64_t s = 1; s <= wavelet_.bank.taps(); ++s) {
    worst = std::max(worst, std::abs(correlation(wavelet_.bank.h, wavelet_.bank.h, s)));
  }
  if (wavelet_.orthonormal) {
    EXPECT_LT(worst, 1e-15);
  } else {
    EXPECT_GT(worst, 1e-4);  // 29 taps: 1e-3, 33 taps: 5e-4
  }
}

/// sum f[n] ((n - centre) / scale)^power and the sum of the magnitudes of its terms.
std::pair<double, double> moment(const FilterBank& bank, const std::vector<double>& f, int power,
                                 double centre) {
  const double scale = static_cast<double>(bank.taps()) / 2;
  double sum = 0, magnitude = 0;
  for (std::int64_t i = 0; i < bank.taps(); ++i) {
    const double x = (static_cast<double>(bank.first + i) - centre) / scale;
    const double term = f[static_cast<std::size_t>(i)] * std::pow(x, power);
    sum += term;
    magnitude += std::abs(term);
  }
  return {sum, magnitude};
}

// The double taps are rounded by 1e-16 of the largest one each: 30 of them, hence 1e-15 of the terms'
// scale 1.
TEST_P(EveryWavelet, WaveletHasItsVanishingMomentsAndNoMore) {
  const double centre =
      static_cast<double>(wavelet_.bank.first) + static_cast<double>(wavelet_.bank.taps() - 1) / 2;
  for (int p = 0; p < wavelet_.vanishing_moments; ++p) {
    // What a cut filter has lost of its moments is of the size of the taps left out, 2e-3.
    EXPECT_LT(std::abs(moment(wavelet_.bank, wavelet_.bank.g, p, centre).first),
              wavelet_.orthonormal ? 5e-15 : 5e-3)
        << p;
  }
  const auto [next, magnitude] = moment(wavelet_.bank, wavelet_.bank.g, wavelet_.vanishing_moments, centre);
  if (wavelet_.compact && wavelet_.orthonormal && wavelet_.vanishing_moments < 8) {
    EXPECT_GT(std::abs(next), 1e-3 * magnitude);
  }
}

TEST_P(EveryWavelet, NameIsCanonical) {
  EXPECT_EQ(wavelet_.name, GetParam());
}

// The taps on a period are orthonormal there, whatever the period: to rounding, for the infinite ones too.
TEST_P(EveryWavelet, PeriodisedFiltersAreOrthonormalOnTheirPeriod) {
  for (const std::int64_t period : {2, 4, 6, 10, 16, 38, 64, 250, 1000}) {
    const FilterBank bank = periodised(wavelet_, period);
    ASSERT_LE(bank.taps(), std::max<std::int64_t>(period, 2));
    std::vector<double> h(static_cast<std::size_t>(period)), g = h;
    for (std::int64_t i = 0; i < bank.taps(); ++i) {
      const auto to = static_cast<std::size_t>(((bank.first + i) % period + period) % period);
      h[to] += bank.h[static_cast<std::size_t>(i)];
      g[to] += bank.g[static_cast<std::size_t>(i)];
    }
    const double tolerance = wavelet_.orthonormal ? 2e-15 : 4e-3;
    for (std::int64_t s = 0; s < period / 2; ++s) {
      double hh = 0, gg = 0, hg = 0;
      for (std::int64_t n = 0; n < period; ++n) {
        const auto a = static_cast<std::size_t>(n), b = static_cast<std::size_t>((n + 2 * s) % period);
        hh += h[a] * h[b];
        gg += g[a] * g[b];
        hg += h[a] * g[b];
      }
      EXPECT_NEAR(hh, s == 0 ? 1 : 0, tolerance) << period << " " << s;
      EXPECT_NEAR(gg, s == 0 ? 1 : 0, tolerance) << period << " " << s;
      EXPECT_NEAR(hg, 0, tolerance) << period << " " << s;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Filters, EveryWavelet, testing::ValuesIn(wavelet_names()), test_name);

// Energy arrives as early as it can: the partial energies of a minimum-phase filter are at least those of its
// time reverse and of any filter with a zero moved outside. Zeros inside the circle: |H(z)| has no zero, |z|
// > 1.
TEST(Daubechies, MinimumPhase) {
  for (int taps = 4; taps <= 20; taps += 2) {
    const auto h = daubechies_taps(taps);
    double early = 0, late = 0;
    for (std::size_t n = 0; n < h.size(); ++n) {
      early += h[n] * h[n];
      late += h[h.size() - 1 - n] * h[h.size() - 1 - n];
      EXPECT_GE(early, late - 1e-15) << taps;
    }
    // Argument principle: H as a polynomial in 1/z turns as often as it has zeros outside the unit circle; on
    // a circle a little wider than 1 (the zero at -1 is on it), none.
    double turned = 0;
    std::complex<double> before = 0;
    for (int k = 0; k <= 20000; ++k) {
      const auto inverse_z = std::polar(1 / 1.05, -2 * std::numbers::pi * k / 20000.0);
      std::complex<double> value = 0;
      for (std::size_t n = h.size(); n-- > 0;) value = value * inverse_z + h[n];
      if (k > 0) turned += std::arg(value / before);
      before = value;
    }
    EXPECT_NEAR(turned, 0, 1e-6) << taps;  // else a multiple of 2 pi
  }
}

TEST(Daubechies, FourTapsInClosedForm) {
  const double r = std::sqrt(3.0), s = 4 * std::numbers::sqrt2;
  const auto h = daubechies_taps(4);
  EXPECT_THAT(h, testing::ElementsAre(
                     testing::DoubleNear((1 + r) / s, 1e-16), testing::DoubleNear((3 + r) / s, 3e-16),
                     testing::DoubleNear((3 - r) / s, 1e-16), testing::DoubleNear((1 - r) / s, 1e-16)));
}

TEST(Coiflet, SixTapsInClosedForm) {
  const double r = std::sqrt(7.0), s = 16 * std::numbers::sqrt2;
  const double expected[] = {1 - r, 5 + r, 14 + 2 * r, 14 - 2 * r, 1 - r, -3 + r};
  const auto h = coiflet_taps(6);
  for (std::size_t n = 0; n < 6; ++n) EXPECT_NEAR(h[n], expected[n] / s, 2e-16);  // an ulp either side
}

// Moments 1 .. 2K-1 of phi about its centre 2K vanish with those of h.
TEST(Coiflet, ScalingFunctionHasVanishingMoments) {
  for (int order = 1; order <= 5; ++order) {
    const Wavelet w = make_wavelet("coiflet-" + std::to_string(6 * order));
    EXPECT_NEAR(w.mean, 2 * order, 1e-13);
    for (int p = 1; p < 2 * order; ++p) {
      EXPECT_LT(std::abs(moment(w.bank, w.bank.h, p, 2.0 * order).first), 5e-15) << order << " " << p;
    }
  }
}

// Sigma(w) summed as it stands, against the product form that the filter is made of. The 20000 terms after
// the largest are added to a sum of some 17, each time rounded by up to 1.8e-15 either way: 2.5e-13 in all.
// What is left out is below 1e-16.
TEST(BattleLemarie, ResponseIsTheRatioOfItsSeries) {
  for (const int degree : {1, 3}) {
    const auto series = [degree](double w) {
      double sum = 0;
      for (int k = -20000; k <= 20000; ++k) sum += std::pow(w + 2 * std::numbers::pi * k, -(2 * degree + 2));
      return sum;
    };
    EXPECT_NEAR(series(0.7), degree == 3 ? 17.34665379542919 : series(0.7), 1e-12);
    for (const double w : {0.3, 0.7, 1.9, 2.9, 4.1}) {
      const double expected = std::sqrt(series(w) / (std::pow(2, 2 * degree + 2) * series(2 * w)));
      EXPECT_NEAR(static_cast<double>(battle_lemarie_response(degree, w)), expected, 1e-12)
          << degree << " " << w;
    }
  }
}

TEST(BattleLemarie, TwoHundredAndOneTapsAreEnoughFor1e13) {
  const auto h = battle_lemarie_taps(3, 160);
  double tail = 0;
  for (std::size_t n = 0; n < 60; ++n) tail += 2 * std::abs(h[n]);
  EXPECT_LT(tail, 1e-13);
  EXPECT_GT(tail, 1e-15);
}

// Gross, Lippert, Dreger & Koch 1995, appendix A, to the digits that are right there: the last digits printed
// of Daubechies and Coiflet are exact to 1e-12 (the fifth Coiflet tap is misprinted and left out), those of
// Battle-Lemarie to 6e-7 for |n| <= 1 and 4e-8 beyond; h(+-14) is misprinted by a factor of ten.
TEST(AppendixA, DigitsOfGrossEtAl) {
  const double d4[] = {0.482962913145, 0.836516303738, 0.224143868042, -.129409522551};
  const double c6[] = {-.072732619494, 0.337897662369, 0.852572019987, 0.384864846763, 0, -.015655728131};
  const double bl[] = {0.766130398, 0.433923147, -.050201753, -.110036987, 0.032080869,
                       0.042068328, -.017176331, -.017982291, 0.008685294, 0.008201477,
                       -.004353840, -.003882426, 0.002186714, 0.001882134, -.001103739};
  const auto d = daubechies_taps(4);
  const auto c = coiflet_taps(6);
  const auto b = battle_lemarie_taps(3, 14);
  for (std::size_t n = 0; n < 4; ++n) EXPECT_NEAR(d[n], d4[n], 1e-12) << n;
  for (std::size_t n = 0; n < 6; ++n) {
    if (n == 4) continue;
    EXPECT_NEAR(c[n], c6[n], 5e-10) << n;
  }
  EXPECT_NEAR(c[4], -.072732619513, 1e-12);
  for (std::size_t n = 0; n <= 14; ++n) EXPECT_NEAR(b[14 + n], bl[n], n <= 1 ? 6e-7 : 4e-8) << n;
  EXPECT_NEAR(b[14], 0.766130053760, 1e-12);
  EXPECT_NEAR(b[28], -.001103739820, 1e-12);
}

TEST(MakeWavelet, ShortNamesAndUnknownNames) {
  EXPECT_EQ(make_wavelet("battle-lemarie").name, "battle-lemarie-3");
  EXPECT_EQ(make_wavelet("battle-lemarie:29").name, "battle-lemarie-3:29");
  for (const char* wrong : {"", "daubechies-3", "daubechies-22", "daubechies-2", "coiflet-8",
                            "battle-lemarie-2", "battle-lemarie:31", "Haar", "daubechies-04"}) {
    try {
      (void)make_wavelet(wrong);
      FAIL() << wrong;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr("haar daubechies-4"));
      EXPECT_THAT(e.what(), testing::HasSubstr("battle-lemarie-3:33"));
    }
  }
}

// The bounds hold for what they bound and are attained: sup |H|^2 + ... of the truncated filters is just
// above 1.
TEST(FrameBounds, OneAndZeroForOrthonormalFilters) {
  EXPECT_EQ(frame_bounds(make_wavelet("coiflet-12")).synthesis_norm, 1);
  EXPECT_EQ(frame_bounds(make_wavelet("coiflet-12")).round_trip_error, 0);
  const auto cut = frame_bounds(make_wavelet("battle-lemarie:29"));
  EXPECT_GT(cut.synthesis_norm, 1);
  EXPECT_LT(cut.synthesis_norm, 1.01);
  EXPECT_GT(cut.round_trip_error, 1e-3);
  EXPECT_LT(cut.round_trip_error, 1e-2);
}

}  // namespace
}  // namespace vol::wavelet
