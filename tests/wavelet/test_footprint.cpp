#include "wavelet/footprint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "wavelet/filters.h"

namespace vol::wavelet {
namespace {

/// The integral along one line by many nodes on every piece of z.
double by_gauss(const FootprintLines& l, double x, double y, double begin, double end) {
  static const double kNode = std::sqrt(0.6);
  const int count = 4 * static_cast<int>(l.z->pieces.size());
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const double from = begin + (end - begin) * i / count, half = 0.5 * (end - begin) / count;
    for (int n = -1; n <= 1; ++n) {
      const double u = from + half * (1 + n * kNode);
      sum += (n == 0 ? 8.0 : 5.0) / 9 * half * l.z->value(u) * l.x->value(x + l.alpha * u) *
             l.y->value(y + l.beta * u);
    }
  }
  return sum;
}

// With smooth factors (Battle-Lemarie: cubic splines on the integers) the cubic between samples is of order
// 4: from h to h/2 the error falls by 16, and by more than 8 at random places.
TEST(Footprint, ConvergesToTheLineIntegralsOfSmoothFunctions) {
  const Prototypes p = make_prototypes(make_wavelet("battle-lemarie-3"), 6);
  const FootprintLines lines{&p.phi, &p.psi, &p.phi, 0.37, -0.61};
  const std::vector<double> limits{-0.7, 0.4, p.phi.upper()};
  double before = 0;
  for (const double h : {0.25, 0.125, 0.0625}) {
    const auto tables = make_footprints(lines, limits, true, h);
    ASSERT_EQ(tables.size(), limits.size());
    Rng rng(5);
    double worst = 0;
    for (int n = 0; n < 100; ++n) {
      const double x = rng.uniform(-3, 3), y = rng.uniform(-3, 3);
      for (std::size_t i = 0; i < limits.size(); ++i) {
        worst =
            std::max(worst, std::abs(tables[i].value(x, y) - by_gauss(lines, x, y, p.phi.lower, limits[i])));
      }
    }
    if (before > 0) {
      EXPECT_LT(worst, before / 8) << h;
    }
    before = worst;
  }
  EXPECT_LT(before, 2e-4);
}

// What is below a limit and what is above it make the whole.
TEST(Footprint, PartsOnBothSidesOfALimitAddUp) {
  for (const char* name : {"daubechies-4", "coiflet-6", "daubechies-8"}) {
    const Prototypes p = make_prototypes(make_wavelet(name), 4);
    const FootprintLines lines{&p.psi, &p.phi, &p.psi, -1.7, 0.3};
    const std::vector<double> limits{0.31, 1.0, 1.93};
    const auto below = make_footprints(lines, limits, true, 1.0 / 64);
    const auto above = make_footprints(lines, limits, false, 1.0 / 64);
    Rng rng(8);
    double largest = 0;
    for (int n = 0; n < 300; ++n) {
      const double u = rng.uniform(0, p.psi.upper());
      const double x = rng.uniform(0, p.psi.upper()) - lines.alpha * u,
                   y = rng.uniform(0, p.phi.upper()) - lines.beta * u;
      const double whole = by_gauss(lines, x, y, p.psi.lower, p.psi.upper());
      largest = std::max(largest, std::abs(whole));
      for (std::size_t i = 0; i < limits.size(); ++i) {
        // On knots 1/16 apart, samples 1/64 apart: within 1e-3 of the largest value.
        EXPECT_NEAR(below[i].value(x, y) + above[i].value(x, y), whole, 1e-3) << name << " " << limits[i];
      }
    }
    EXPECT_GT(largest, 0.1);
  }
}

TEST(Footprint, IsNothingBeyondTheSupport) {
  const Prototypes p = make_prototypes(make_wavelet("daubechies-4"), 3);
  const FootprintLines lines{&p.phi, &p.phi, &p.phi, 0.5, 0.25};
  const std::vector<double> limits{p.phi.upper()};
  const auto table = make_footprints(lines, limits, true, 0.125).front();
  EXPECT_EQ(table.value(1e9, 0), 0);
  EXPECT_EQ(table.value(0, -1e9), 0);
  EXPECT_EQ(table.value(table.x0 - 1, 0), 0);
  EXPECT_EQ(table.value(table.x0 + table.h, table.y0 + table.h), 0);
  EXPECT_GT(table.value(0.5, 0.5), 0);
}

TEST(Footprint, KnowsWhatJumps) {
  const Prototypes haar = make_prototypes(make_wavelet("haar"), 6);
  EXPECT_FALSE(continuous(haar.phi));
  EXPECT_FALSE(continuous(haar.psi));
  for (const char* name : {"daubechies-4", "coiflet-6", "battle-lemarie-1", "battle-lemarie-3"}) {
    const Prototypes p = make_prototypes(make_wavelet(name), 5);
    EXPECT_TRUE(continuous(p.phi)) << name;
    EXPECT_TRUE(continuous(p.psi)) << name;
    EXPECT_NEAR(integral(p.phi, p.phi.lower, p.phi.upper()), p.phi.integral(), 1e-13);
    EXPECT_NEAR(integral(p.psi, -100, 0.3) + integral(p.psi, 0.3, 100), 0, 1e-13);
  }
  EXPECT_FALSE(continuous(periodised(make_prototypes(make_wavelet("daubechies-4"), 5).phi, 2)));
}

}  // namespace
}  // namespace vol::wavelet
