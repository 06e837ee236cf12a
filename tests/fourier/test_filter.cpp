#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "fourier/filter.h"

namespace vol::fourier {
namespace {

double sinc(double x) {
  return x == 0 ? 1 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

const char* const kNames[] = {"nearest", "trilinear", "catmull-rom", "catmull-rom-fast",
                              "sinc:5",  "sinc:8",    "es:4",        "es:5",
                              "es:6",    "es:8",      "es:12",       "es:16"};

TEST(Filter, TransformsAreTheClosedForms) {
  for (const double x : {0.0, 1e-9, 0.1, 0.25, 0.4999, 1.3}) {
    EXPECT_NEAR(Filter("nearest", 1).transform(x), sinc(x), 1e-14);
    EXPECT_NEAR(Filter("trilinear", 1).transform(x), sinc(x) * sinc(x), 1e-14);
    const double c = std::cos(std::numbers::pi * x), c3 = std::cos(3 * std::numbers::pi * x);
    EXPECT_NEAR(Filter("catmull-rom-fast", 1).transform(x), sinc(x) * sinc(x) * (9 * c - c3) / 8, 1e-14);
  }
  // Keys 1981: 3/(pi x)^2 (sinc^2 x - sinc 2x) + a 2/(pi x)^2 (3 sinc^2 2x - 2 sinc 2x - sinc 4x), a = -1/2.
  for (const double x : {0.1, 0.25, 0.4999, 1.3}) {
    const double p2 = std::pow(std::numbers::pi * x, 2);
    const double keys = 3 / p2 * (sinc(x) * sinc(x) - sinc(2 * x)) -
                        (3 * sinc(2 * x) * sinc(2 * x) - 2 * sinc(2 * x) - sinc(4 * x)) / p2;
    EXPECT_NEAR(Filter("catmull-rom", 1).transform(x), keys, 1e-13);  // the closed form cancels at small x
  }
}

// The quadrature of transform() against the trapezoid rule, which converges for the semicircle only as its
// jump of exp(-beta) at the ends allows: enough to catch a wrong stretch or piece.
TEST(Filter, TransformOfTheSemicircleIsItsIntegral) {
  for (const char* name : {"es:4", "es:9", "sinc:5"}) {
    const Filter filter(name, 2);
    const int n = 200000;
    for (const double x : {0.0, 0.13, 0.25}) {
      double sum = 0;
      for (int i = 0; i < n; ++i) {
        const double t = filter.taps() * ((i + 0.5) / n - 0.5);
        sum += filter.weight(t) * std::cos(2 * std::numbers::pi * x * t) * filter.taps() / n;
      }
      EXPECT_NEAR(filter.transform(x), sum, 1e-8) << name << " at " << x;
    }
  }
}

TEST(Filter, InterpolatingKernelsAreOneAtZeroAndZeroAtOtherGridPoints) {
  for (const char* name : kNames) {
    const Filter filter(name, 2);
    if (!filter.interpolates()) continue;
    EXPECT_EQ(filter.weight(0), 1) << name;
    for (int k = 1; 2 * k < filter.taps(); ++k)
      EXPECT_NEAR(filter.weight(k), 0, 1e-16) << name << " at " << k;
  }
}

// The promise of polynomials(): float's rounding of the largest weight, or the height of es at its ends,
// where its derivative is infinite.
TEST(Filter, PolynomialsAreTheWeights) {
  for (const char* name : kNames) {
    for (const double padding : {1.0, 1.5, 2.0, 4.0}) {
      const Filter filter(name, padding);
      const auto p = filter.polynomials();
      double worst = 0;
      for (int j = 0; j < filter.taps(); ++j) {
        for (int i = 0; i < 400; ++i) {
          const double z = (i + 0.37) / 400, s = 2 * z - 1;
          double value = 0;
          for (int d = p.degree; d >= 0; --d) value = value * s + p.coefficients[d * filter.taps() + j];
          worst = std::max(worst, std::abs(value - filter.weight(z + 0.5 * filter.taps() - 1 - j)));
        }
      }
      const double bound = filter.beta() > 0 ? std::max(1e-7, std::exp(-filter.beta())) : 1e-7;
      EXPECT_LT(worst, bound) << name << " padding " << padding << " degree " << p.degree;
    }
  }
}

TEST(Filter, NamesAreCanonical) {
  EXPECT_EQ(Filter("es:06", 2).name(), "es:6");
  EXPECT_EQ(Filter("sinc:005", 2).name(), "sinc:5");
}

TEST(Filter, RefusesWhatItDoesNotKnow) {
  for (const char* name : {"", "cubic", "es:", "es:1", "es:17", "es:4x", "sinc:0", "sinc:-3"}) {
    EXPECT_THROW(Filter(name, 2), Error) << name;
  }
  EXPECT_THROW(Filter("es:4", 0.5), Error);
}

}  // namespace
}  // namespace vol::fourier
