#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "random_volume.h"
#include "volume/field_sampler.h"
#include "wavelet/dwt.h"
#include "wavelet/expansion.h"
#include "wavelet/filters.h"
#include "wavelet/layout.h"
#include "wavelet_label.h"

namespace vol::wavelet {
namespace {

static_assert(volume::FieldSampler<Expansion>);

class ExpansionOf : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Wavelets, ExpansionOf, testing::ValuesIn(wavelet_names()), wavelet_label);

/// All but the truncated filters.
std::vector<std::string> orthonormal_wavelets() {
  std::vector<std::string> names = wavelet_names();
  std::erase_if(names, [](const std::string& name) { return !make_wavelet(name).orthonormal; });
  return names;
}
class OrthonormalExpansionOf : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Wavelets, OrthonormalExpansionOf, testing::ValuesIn(orthonormal_wavelets()),
                         wavelet_label);

Decomposition<double> transformed(const volume::Volume& volume, const std::string& wavelet, int levels) {
  return analyze<double>(volume, {.wavelet = wavelet, .levels = levels}, volume::value_range(volume));
}

double voxel(const volume::Volume& volume, std::size_t n) {
  return grid_of<double>(volume).voxels[n];
}

TEST_P(ExpansionOf, IntegralsOfPhiAndPsiAreOneAndZero) {
  for (const int depth : {1, 2, 5, 9}) {
    const Prototypes p = make_prototypes(make_wavelet(GetParam()), depth);
    EXPECT_NEAR(p.phi.integral(), 1, 1e-13) << depth;
    EXPECT_NEAR(p.psi.integral(), 0, 1e-13) << depth;
  }
}

TEST_P(ExpansionOf, TranslatesOfPhiAddUpToOne) {
  Rng rng(5);
  for (const int depth : {1, 2, 7}) {
    const PiecewiseCubic phi = make_prototypes(make_wavelet(GetParam()), depth).phi;
    for (int n = 0; n < 50; ++n) {
      const double x = rng.uniform(0, 1);
      double sum = 0;
      for (int k = -120; k <= 120; ++k) sum += phi.value(x - k);
      EXPECT_NEAR(sum, 1, 1e-12) << "depth " << depth << ", x " << x;
    }
  }
}

// At the dyadic points the splines are the functions themselves: the refinement equations hold there.
TEST_P(ExpansionOf, RefinementEquationsHoldAtDyadicPoints) {
  const Wavelet wavelet = make_wavelet(GetParam());
  const FilterBank bank = wavelet.family == Family::battle_lemarie
                              ? make_wavelet("battle-lemarie-" + std::to_string(wavelet.degree)).bank
                              : wavelet.bank;
  const Prototypes p = make_prototypes(wavelet, 4);
  for (int i = -16 * 12; i < 16 * 32; ++i) {
    const double x = i / 16.0;
    double phi = 0, psi = 0;
    for (std::int64_t n = 0; n < bank.taps(); ++n) {
      const double at = p.phi.value(2 * x - static_cast<double>(bank.first + n));
      phi += std::sqrt(2.0) * bank.h[static_cast<std::size_t>(n)] * at;
      psi += std::sqrt(2.0) * bank.g[static_cast<std::size_t>(n)] * at;
    }
    ASSERT_NEAR(p.phi.value(x), phi, 1e-12) << x;
    ASSERT_NEAR(p.psi.value(x), psi, 1e-12) << x;
  }
}

// Between them they come closer with the depth; the coarser splines' deviation is as stated.
TEST_P(ExpansionOf, DeviationIsWhatAFinerSplineShows) {
  const Wavelet wavelet = make_wavelet(GetParam());
  const Prototypes coarse = make_prototypes(wavelet, 5), fine = make_prototypes(wavelet, 8);
  double phi = 0, psi = 0;
  for (double x = -8; x < 31; x += 1 / 256.0) {
    phi = std::max(phi, std::abs(coarse.phi.value(x) - fine.phi.value(x)));
    psi = std::max(psi, std::abs(coarse.psi.value(x) - fine.psi.value(x)));
  }
  EXPECT_NEAR(phi, coarse.phi_deviation, 1e-12);
  EXPECT_NEAR(psi, coarse.psi_deviation, 1e-12);
  EXPECT_LE(fine.phi_deviation, coarse.phi_deviation);
  EXPECT_LE(fine.psi_deviation, coarse.psi_deviation);
}

// The uncentred expansion at voxel n is sum_k c[k] phi(n - k), phi at the integers from the eigenvector: in
// index space that is x = n - mu. 7 x 12 x 9 is extended to 8 x 12 x 12; the sum wraps around it.
TEST_P(ExpansionOf, AtVoxelsItIsTheSumOverSamples) {
  const Wavelet wavelet = make_wavelet(GetParam());
  const auto volume = random_volume<double>({7, 12, 9}, 3);
  const auto d = transformed(volume, GetParam(), 2);
  const Expansion expansion(d, {.depth = 3});
  const PiecewiseCubic phi = make_prototypes(wavelet, 1).phi;
  std::array<std::vector<double>, 3> at;  // of the period
  for (std::size_t a = 0; a < 3; ++a) {
    const PiecewiseCubic f = periodised(phi, d.extended_dims[a]);
    for (std::int64_t n = 0; n < d.extended_dims[a]; ++n) {
      double sum = 0;
      for (int j = -20; j <= 20; ++j) sum += f.value(static_cast<double>(n + j * d.extended_dims[a]));
      at[a].push_back(sum);
    }
  }
  const auto phi_at = [&](std::size_t a, std::int64_t n) {
    return at[a]
             [static_cast<std::size_t>((n % d.extended_dims[a] + d.extended_dims[a]) % d.extended_dims[a])];
  };
  const auto sample = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const Dims& n = d.geometry.dims;
    return grid_of<double>(volume)(std::min(i, n[0] - 1), std::min(j, n[1] - 1), std::min(k, n[2] - 1));
  };
  // Truncated filters are not orthonormal: the transform and the functions belong to filters 1e-3 apart.
  const double tolerance = wavelet.orthonormal ? 1e-12 : 2e-2;
  const auto first = static_cast<std::int64_t>(std::ceil(wavelet.mean));
  for (std::int64_t z = first; z < 9; z += 2) {
    for (std::int64_t y = first; y < 12; y += 3) {
      for (std::int64_t x = first; x < 7; ++x) {
        double sum = 0;
        for (std::int64_t k = 0; k < d.extended_dims[2]; ++k) {
          for (std::int64_t j = 0; j < d.extended_dims[1]; ++j) {
            for (std::int64_t i = 0; i < d.extended_dims[0]; ++i) {
              sum += sample(i, j, k) * phi_at(0, x - i) * phi_at(1, y - j) * phi_at(2, z - k);
            }
          }
        }
        const Vec3 p = Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)).array() -
                       wavelet.mean;
        ASSERT_NEAR(expansion.value_index(p), sum, tolerance) << p.transpose();
      }
    }
  }
}

TEST_P(ExpansionOf, ConstantsAreReproduced) {
  auto volume = random_volume<double>({9, 6, 1}, 1);
  for (double& v : std::get<volume::Grid<double>>(volume.grid).voxels) v = -2.5;
  const Expansion expansion(transformed(volume, GetParam(), 1), {.depth = 4});
  Rng rng(8);
  // A truncated filter's scaling and wavelet coefficients of 1 are off by at most e each, on two axes.
  const Wavelet wavelet = make_wavelet(GetParam());
  const double tolerance = 1e-11 + 2.5 * 4 * frame_bounds(wavelet).round_trip_error;
  for (int n = 0; n < 100; ++n) {
    const Vec3 p(rng.uniform(0, 8), rng.uniform(0, 5), rng.uniform(-0.5, 0.5));
    EXPECT_NEAR(expansion.value_index(p), -2.5, tolerance);
    EXPECT_LT(expansion.gradient_index(p).norm(), 100 * tolerance);
  }
}

// Functions longer than the period are folded to it, and jump where they are cut. A point that rounding next
// to a cut puts in none of two images, or in both, makes the sum wrong by some 0.1.
TEST_P(ExpansionOf, EveryPointIsInOneImageOfAFoldedFunction) {
  auto volume = random_volume<double>({8, 12, 8}, 1);
  for (double& v : std::get<volume::Grid<double>>(volume.grid).voxels) v = 1;
  const Expansion f(transformed(volume, GetParam(), 2), {.depth = 3, .b_splines = false});
  const double tolerance = 1e-9 + 12 * frame_bounds(make_wavelet(GetParam())).round_trip_error;
  Rng rng(2);
  for (int axis = 0; axis < 3; ++axis) {
    for (double knot = 0; knot <= f.index_box().max[axis]; knot += 0.125) {
      const Vec3 inside(rng.uniform(0, 7), rng.uniform(0, 7), rng.uniform(0, 7));
      for (const double nearby : {-1e-15, -2e-16, 0.0, 1e-16, 1e-15}) {
        Vec3 p = inside;
        p[axis] = std::clamp(knot + nearby, 0.0, f.index_box().max[axis]);
        EXPECT_NEAR(f.value_index(p), 1, tolerance) << axis << " " << knot << " " << nearby;
      }
    }
  }
}

TEST(Expansion, ACopyOfCoarseLevelsIsCountedBeforeItIsTaken) {
  const auto volume = random_volume<double>({16, 16, 16}, 3);
  const Expansion all(transformed(volume, "daubechies-4", 2));
  std::int64_t terms = 0, coarse = 0;
  for (const Band& band : all.bands()) {
    (band.level == 2 ? coarse : terms) += static_cast<std::int64_t>(band.terms.size() * sizeof(Term));
  }
  EXPECT_GE(all.bytes_from(2), coarse);
  EXPECT_LE(all.bytes_from(2), 2 * coarse);
  EXPECT_GE(all.bytes_from(1), terms + coarse);
  EXPECT_EQ(all.from_level(2, all.bytes_from(1) + all.bytes_from(2)).bytes_from(1), all.bytes_from(2));
  EXPECT_THROW((void)all.from_level(2, all.bytes_from(1) + all.bytes_from(2) - 1), Error);
}

TEST_P(ExpansionOf, GradientIsTheDerivative) {
  const auto volume = random_volume<double>({8, 5, 6}, 17);
  const Expansion expansion(transformed(volume, GetParam(), 2), {.depth = 3});
  Rng rng(4);
  const volume::FieldBounds& bounds = expansion.bounds();
  for (int n = 0; n < 30; ++n) {
    const Vec3 u(rng.uniform(0.1, 0.9), rng.uniform(0.1, 0.9), rng.uniform(0.1, 0.9));
    const Vec3 p = bounds.corner + bounds.edges * u;
    const Vec3 g = expansion.gradient(p);
    for (int a = 0; a < 3; ++a) {
      // A knot within 1e-6 of one of 30 points has probability below 1e-2; the seed is fixed.
      const Vec3 e = 1e-6 * Vec3::Unit(a);
      const double quotient = (expansion.value(p + e) - expansion.value(p - e)) / 2e-6;
      EXPECT_NEAR(g[a], quotient, 1e-4 * (1 + g.norm())) << p.transpose();
    }
  }
}

// Over a period the integral of f is the sum of the samples. By the trapezoidal rule on the knots of the
// finest splines, corrected by nothing: exact, since the translates' sums at the knots are.
TEST_P(ExpansionOf, IntegralIsTheSumOfSamples) {
  const Wavelet wavelet = make_wavelet(GetParam());
  const auto volume = random_volume<double>({8, 1, 1}, 23);
  const auto d = transformed(volume, GetParam(), 2);
  double sum = 0, integral = 0;
  for (std::size_t n = 0; n < 8; ++n) sum += voxel(volume, n);
  const Prototypes p = make_prototypes(wavelet, 4);
  for (const auto& band : d.subbands) {
    const double size = std::ldexp(1.0, band.level);
    const PiecewiseCubic f = periodised(band.orientation == 0 ? p.phi : p.psi, 8 >> band.level);
    for (const double c : band.coefficients) integral += c * std::sqrt(size) * f.integral();
  }
  EXPECT_NEAR(integral, sum, wavelet.orthonormal ? 1e-12 : 2e-2);
}

constexpr double kNode[4] = {-0.861136311594052575, -0.339981043584856265, 0.339981043584856265,
                             0.861136311594052575};
constexpr double kWeight[4] = {0.347854845137453857, 0.652145154862546143, 0.652145154862546143,
                               0.347854845137453857};

/// L2 distance of two functions of the same support, by Gauss rules on the finer one's pieces: exact but for
/// rounding.
double distance(const PiecewiseCubic& coarse, const PiecewiseCubic& fine) {
  double sum = 0;
  for (std::size_t i = 0; i < fine.pieces.size(); ++i) {
    for (int g = 0; g < 4; ++g) {
      const double x = fine.lower + fine.spacing * (static_cast<double>(i) + 0.5 * (1 + kNode[g]));
      const double d = coarse.value(x) - fine.value(x);
      sum += 0.5 * fine.spacing * kWeight[g] * d * d;
    }
  }
  return std::sqrt(sum);
}

// f^2 over a period of 16 samples by Gauss rules on all pieces, against the sum of c^2. The true functions
// are orthonormal; splines that are off by r and s in L2 make f off by at most sum |c| r + sum |d| s, over 8
// coefficients c of phi and 8 d of psi: sqrt(8 (r^2 + s^2)) of its norm, by Cauchy and Schwarz.
TEST_P(OrthonormalExpansionOf, EnergyIsTheSumOfSquares) {
  const Wavelet wavelet = make_wavelet(GetParam());
  const auto volume = random_volume<double>({16, 1, 1}, 29);
  const auto d = transformed(volume, GetParam(), 1);
  constexpr int kDepth = 7;
  const Expansion expansion(d, {.depth = kDepth});
  // Pieces of level 1 begin at multiples of 2 * 2^-depth less mu (Haar and Battle-Lemarie: of 1); over 16
  // samples from -mu on the field is seen once. What lies outside the box is reached by the period.
  const Prototypes p = make_prototypes(wavelet, kDepth);
  double energy_of_f = 0;
  const double h = std::ldexp(2.0, -kDepth);
  for (double x = 0; x < 16; x += h) {
    for (int g = 0; g < 4; ++g) {
      const double u = (x + 0.5 * h * (1 + kNode[g])) / 2;
      double f = 0;
      for (const auto& band : d.subbands) {
        const PiecewiseCubic b = periodised(band.orientation == 0 ? p.phi : p.psi, 8);
        for (int k = 0; k < 8; ++k) {
          for (int j = -8; j <= 8; ++j) {
            f += band.coefficients[static_cast<std::size_t>(k)] * b.value(u - k - 8 * j) / std::sqrt(2.0);
          }
        }
      }
      energy_of_f += 0.5 * h * kWeight[g] * f * f;
    }
  }
  const Prototypes finer = make_prototypes(wavelet, kDepth + 1),
                   finest = make_prototypes(wavelet, kDepth + 5);
  const auto distance_of = [&](const Prototypes& q) {
    return std::hypot(distance(periodised(q.phi, 8), periodised(finest.phi, 8)),
                      distance(periodised(q.psi, 8), periodised(finest.psi, 8)));
  };
  const double known = distance_of(p);
  // A level of depth takes off a third at least, so that beyond the finest there is less than 1/6 of the
  // whole.
  if (known > 1e-10) {
    EXPECT_LT(distance_of(finer), known * 2 / 3);
  }
  const double deviation = std::sqrt(8.0) * 1.2 * known;
  EXPECT_NEAR(energy_of_f / energy(d), 1, 1e-12 + 2 * deviation + deviation * deviation);
}

TEST(Expansion, StoresWhatIsNotZeroAndRefusesWhatItCannotKnow) {
  const auto volume = random_volume<double>({16, 8, 8}, 2);
  auto d = transformed(volume, "daubechies-4", 1);
  for (auto& band : d.subbands) std::fill(band.coefficients.begin(), band.coefficients.end(), 0.0);
  EXPECT_EQ(Expansion(d).coefficients(), 0);
  EXPECT_EQ(Expansion(d).value_index({1, 2, 3}), 0);
  d.subbands[3].coefficients[40] = 1e30;
  const Expansion one(d);
  EXPECT_EQ(one.coefficients(), 1);
  EXPECT_EQ(one.bands().size(), 1U);
  const auto symmetric = analyze<double>(
      volume, {.wavelet = "haar", .levels = 1, .boundary = Boundary::symmetric}, volume::value_range(volume));
  EXPECT_THROW(Expansion{symmetric}, Error);
  EXPECT_THROW((Expansion{d, {.depth = 15}}), Error);
  EXPECT_THROW((Expansion{d, {.depth = 0}}), Error);
}

TEST_P(ExpansionOf, TakesWhatItSaysBeforehand) {
  const auto d = transformed(random_volume<double>({9, 8, 12}, 41), GetParam(), 2);
  const ExpansionOptions options{.depth = 1,
                                 .b_splines = false};  // B-splines: what is 0 of them is not known before
  const Expansion expansion(d, options);
  std::int64_t bytes = 0, coefficients = 0;
  for (const auto& band : d.subbands) coefficients += static_cast<std::int64_t>(band.coefficients.size());
  for (const auto& band : expansion.bands()) {
    EXPECT_EQ(band.terms.size(), band.terms.capacity());
    bytes += static_cast<std::int64_t>(band.terms.size() * sizeof(Term));
    for (const auto& nodes : band.nodes)
      bytes += static_cast<std::int64_t>(nodes.size() * sizeof(Band::Node));
  }
  EXPECT_GT(bytes, 0);
  // When the last band is made, its coefficients are still there; at first, all are.
  const auto last = static_cast<std::int64_t>(d.subbands.back().coefficients.size() * sizeof(double));
  EXPECT_GE(expansion.planned_bytes(), bytes + last);
  EXPECT_LE(expansion.planned_bytes(), bytes + coefficients * static_cast<std::int64_t>(sizeof(double)));
  const std::int64_t limit = expansion.planned_bytes();
  EXPECT_NO_THROW((Expansion{d, {.depth = 1, .b_splines = false, .memory_limit = limit}}));
  EXPECT_THROW((Expansion{d, {.depth = 1, .b_splines = false, .memory_limit = limit - 1}}), Error);
}

// A change of basis changes no value: B-splines in place of Battle's and Lemarie's functions, to the rounding
// of both sums. Sizes that the levels do not divide, an axis of one sample, periods shorter than a B-spline,
// few and all coefficients.
TEST(Expansion, BSplinesAreTheSameField) {
  int turned = 0;
  for (const char* name : {"battle-lemarie-1", "battle-lemarie-3", "battle-lemarie-3:29"}) {
    for (const Dims dims : {Dims{7, 12, 9}, Dims{17, 1, 30}, Dims{2, 3, 33}}) {
      for (const double kept : {1.0, 0.2}) {
        auto d = transformed(random_volume<double>(dims, 7), name, 2);
        std::size_t n = 0;
        double sum = 0;
        for (auto& band : d.subbands) {
          for (double& c : band.coefficients) {
            if (std::fmod(0.618034 * static_cast<double>(n++), 1.0) > kept) c = 0;
            sum += std::abs(c);
          }
        }
        const Expansion own(d, {.b_splines = false}), splines(d);
        for (const Band& band : splines.bands()) turned += band.b_splines;
        for (const Band& band : own.bands()) EXPECT_FALSE(band.b_splines);
        EXPECT_EQ(own.coefficients(), splines.coefficients());
        for (int i = 0; i < 60; ++i) {
          Vec3 p;
          for (int a = 0; a < 3; ++a) {
            p[a] = std::fmod(0.754877 * (i + 1) * (a + 1), 1.0) *
                   static_cast<double>(std::max<std::int64_t>(1, dims[a] - 1));
          }
          // Functions are cut where their coefficients fall below 1e-16, B-splines are not: 1e-15 a
          // coefficient.
          ASSERT_NEAR(own.value_index(p), splines.value_index(p), 2e-15 * sum)
              << name << " at " << p.transpose();
          ASSERT_NEAR((own.gradient_index(p) - splines.gradient_index(p)).norm(), 0, 1e-14 * sum);
        }
        std::int64_t bytes = 0;
        for (const auto& band : splines.bands())
          bytes += static_cast<std::int64_t>(band.terms.capacity() * sizeof(Term));
        EXPECT_LE(bytes, splines.planned_bytes());
      }
    }
  }
  EXPECT_GT(turned, 20);
}

// Morton order of a line is that of its places, however long: 2^21 and 0 do not fall together.
TEST(Expansion, OrderOfLongAxes) {
  volume::Volume volume;
  volume.grid = volume::Grid<float>{{}, Buffer<float>((1 << 22) + 2, 0.0F)};
  std::get<volume::Grid<float>>(volume.grid).geometry.dims = {(1 << 22) + 2, 1, 1};
  auto d = analyze<float>(volume, {.wavelet = "haar", .levels = 1}, {0, 0});
  auto& detail = d.subbands.back().coefficients;
  for (const std::size_t k : {0, 1, 5, 1 << 20, 1 << 21}) detail[k] = 1;
  const Expansion expansion(std::move(d));
  ASSERT_EQ(expansion.bands().size(), 1U);
  std::vector<std::int32_t> order;
  for (const Term& term : expansion.bands()[0].terms) order.push_back(term.k[0]);
  EXPECT_THAT(order, testing::ElementsAre(0, 1, 5, 1 << 20, 1 << 21));
}

}  // namespace
}  // namespace vol::wavelet
