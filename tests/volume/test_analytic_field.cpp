#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/error.h"
#include "base/rng.h"
#include "generic_grid.h"
#include "volume/analytic_field.h"
#include "volume/analytic_texture.h"

namespace vol::volume {
namespace {

static_assert(FieldSampler<AnalyticField>);

class EveryField : public testing::TestWithParam<std::string_view> {
 protected:
  static AnalyticField field(std::uint64_t seed = 1) {
    return make_analytic_field(GetParam(), {.seed = seed, .geometry = generic_geometry({20, 17, 30})});
  }
  static Vec3 random_point(const AnalyticField& f, Rng& rng) {
    return f.bounds().corner +
           f.bounds().edges * Vec3(rng.uniform(0.02, 0.98), rng.uniform(0.02, 0.98), rng.uniform(0.02, 0.98));
  }
};

// Eighth-order central differences: error h^8 f^(9) / 630 plus 2 eps |f| / h; with h a thousandth of an edge
// and the shortest wave 1/12 of an edge, some 1e-12 of the slope from either.
double derivative(const AnalyticField& f, const Vec3& p, const Vec3& h) {
  const double w[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  double sum = 0;
  for (int n = 1; n <= 4; ++n) sum += w[n - 1] * (f.value(p + n * h) - f.value(p - n * h));
  return sum;
}

TEST_P(EveryField, GradientIsTheDerivative) {
  if (std::set<std::string_view>{"voxel-object", "impulse", "checkerboard"}.count(GetParam())) {
    Rng rng(6);
    for (int n = 0; n < 300; ++n) {
      const auto f = field();
      const Vec3 p = random_point(f, rng);
      EXPECT_EQ(f.gradient(p), Vec3::Zero());
      EXPECT_TRUE(f.value(p) == 0 || f.value(p) == 1);
    }
    return;  // constant in boxes
  }
  // The smooth step of the shapes is C2 only: where the stencil crosses the end of the edge the third
  // derivative, 60 / width^3, makes an error of h^3 times that.
  const bool shape = std::set<std::string_view>{"sphere", "shell", "torus"}.count(GetParam()) > 0;
  // The waves of texture are three times as short as those.
  const bool short_waves = shape || GetParam() == "texture";
  const auto f = field();
  Rng rng(7);
  for (int n = 0; n < 300; ++n) {
    const Vec3 p = random_point(f, rng);
    const Vec3 gradient = f.gradient(p);
    for (int a = 0; a < 3; ++a) {
      const Vec3 h = (short_waves ? 1e-4 : 1e-3) * f.bounds().edges.col(a);
      if (GetParam() == "texture" && texture_region(f.world_to_canonical(p + 4 * h)) !=
                                         texture_region(f.world_to_canonical(p - 4 * h))) {
        continue;  // it jumps between regions
      }
      ASSERT_NEAR(derivative(f, p, h), gradient.dot(h), shape ? 1e-7 : 1e-10)
          << GetParam() << " at " << p.transpose();
    }
  }
}

TEST_P(EveryField, StaysWithinItsRange) {
  const auto f = field();
  const Range range = f.range();
  // Nominal ranges of the seeded forms are met to a tenth.
  const bool nominal =
      std::set<std::string_view>{"gaussians", "bust", "protein", "noise", "texture"}.count(GetParam()) > 0;
  const double slack = nominal ? 0.1 * (range.max - range.min) : 1e-15;
  Rng rng(8);
  double lo = 1e9, hi = -1e9;
  for (int n = 0; n < 20000; ++n) {
    const double v = f.value(random_point(f, rng));
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
  EXPECT_GE(lo, range.min - slack);
  EXPECT_LE(hi, range.max + slack);
  if (GetParam() != "constant" && GetParam() != "impulse") {
    EXPECT_GT(hi - lo, 0.5 * (range.max - range.min));
  }
}

TEST_P(EveryField, SamplesAreTheFieldAtTheVoxels) {
  const auto f = field();
  const bool steps =
      std::set<std::string_view>{"voxel-object", "impulse", "checkerboard"}.count(GetParam()) > 0;
  Rng rng(9);
  for (int n = 0; n < 100 && !steps; ++n) {
    const Vec3 p(static_cast<double>(rng.below(20)), static_cast<double>(rng.below(17)),
                 static_cast<double>(rng.below(30)));
    EXPECT_NEAR(f.sample(static_cast<std::int64_t>(p[0]), static_cast<std::int64_t>(p[1]),
                         static_cast<std::int64_t>(p[2])),
                f.value(f.geometry().index_to_world(p)), 1e-13);
  }
}

TEST_P(EveryField, OneSampleAxesAreConstant) {
  const auto f = make_analytic_field(GetParam(), {.seed = 1, .geometry = generic_geometry({20, 1, 30})});
  const Vec3 p = f.geometry().index_to_world({7.25, -0.4, 11.5});
  const Vec3 q = f.geometry().index_to_world({7.25, 0.3, 11.5});
  EXPECT_NEAR(f.value(p), f.value(q), 1e-14);
  EXPECT_NEAR(f.gradient(p).dot(f.geometry().direction.col(1)), 0, 1e-13);
}

std::vector<std::string_view> all_names() {
  std::vector<std::string_view> names;
  for (const auto& entry : analytic_field_names()) names.push_back(entry.name);
  return names;
}
INSTANTIATE_TEST_SUITE_P(AnalyticField, EveryField, testing::ValuesIn(all_names()), [](const auto& instance) {
  std::string name(instance.param);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(AnalyticField, UnknownNameIsRefusedWithTheNames) {
  try {
    (void)make_analytic_field("sphere2");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("marschner-lobb"), std::string::npos);
  }
}

// Noise turns its waves from sample to sample: over a run of 32 a product of unit complex numbers is off by
// at most 32 ulp, and 64 such waves of amplitude 0.022 sum to less than 1e-14.
TEST(AnalyticField, RowsHoldTheSamples) {
  GridGeometry geometry = canonical_geometry({101, 3, 4});
  for (const auto& entry : analytic_field_names()) {
    const auto f = make_analytic_field(entry.name, {.seed = 11, .geometry = geometry});
    const double tolerance = entry.name == "noise" ? 1e-14 : 0;
    std::vector<double> row(101);
    for (std::int64_t k = 0; k < 4; ++k) {
      f.sample_row(1, k, row);
      for (std::int64_t i = 0; i < 101; ++i) {
        EXPECT_NEAR(row[static_cast<std::size_t>(i)], f.sample(i, 1, k), tolerance) << entry.name << " " << i;
      }
    }
  }
}

TEST(AnalyticField, SeedsMatterAndRepeat) {
  for (const auto* name : {"gaussians", "protein", "noise", "texture"}) {
    const Vec3 p(0.1, 0.2, -0.3);
    EXPECT_EQ(make_analytic_field(name, {.seed = 3}).value(p),
              make_analytic_field(name, {.seed = 3}).value(p));
    EXPECT_NE(make_analytic_field(name, {.seed = 3}).value(p),
              make_analytic_field(name, {.seed = 4}).value(p));
  }
}

// Over a region of some 8^3 independent wavelengths the mean of the samples is off by 1 / (8 sqrt 512) at
// most by chance, their standard deviation by a twentieth. The bands are what tells the regions apart: the
// mean square of the derivative along an axis is the variance times the mean square of k along it.
TEST(AnalyticField, RegionsOfTextureDifferInTextureAlone) {
  const auto f = make_analytic_field("texture", {.seed = 5});
  std::array<double, kTextureRegions> count{}, sum{}, squares{};
  std::array<Vec3, kTextureRegions> slopes;
  slopes.fill(Vec3::Zero());
  Rng rng(12);
  for (int n = 0; n < 100000; ++n) {
    const Vec3 p(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    const auto r = static_cast<std::size_t>(texture_region(p));
    const double v = f.value(p);
    count[r] += 1;
    sum[r] += v;
    squares[r] += (v - 0.5) * (v - 0.5);
    slopes[r] += f.gradient(p).cwiseAbs2();
  }
  std::array<Vec3, kTextureRegions> k;  // root mean square wave number along each axis, cycles an edge
  for (std::size_t r = 0; r < kTextureRegions; ++r) {
    EXPECT_GT(count[r], 15000) << r;
    EXPECT_NEAR(sum[r] / count[r], 0.5, 0.006) << r;
    EXPECT_NEAR(std::sqrt(squares[r] / count[r]), 0.125, 0.006) << r;
    k[r] = (slopes[r] / squares[r]).cwiseSqrt() / M_PI;
  }
  // In all directions k_x^2 is a third of k^2, of 12 and 24.6 on average over the shells; in a cone of 25
  // degrees k along the axis is above 20 cos 25, across it below 28 sin 25. 32 waves have these to a fifth.
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(k[0][a], 12 / std::sqrt(3.0), 0.2 * 12 / std::sqrt(3.0)) << a;
    EXPECT_NEAR(k[1][a], 24.6 / std::sqrt(3.0), 0.2 * 24.6 / std::sqrt(3.0)) << a;
    for (const auto& [region, axis] : {std::pair{2, 0}, {3, 2}}) {
      const double here = k[static_cast<std::size_t>(region)][a];
      if (a == axis) {
        EXPECT_GT(here, 20 * std::cos(25 * M_PI / 180) * 0.98) << region;
      } else {
        EXPECT_LT(here, 28 * std::sin(25 * M_PI / 180)) << region;
      }
    }
  }
}

TEST(AnalyticField, LabelsOfTextureAreItsRegions) {
  const GridGeometry geometry = generic_geometry({20, 1, 30});
  const auto f = make_analytic_field("texture", {.geometry = geometry});
  const Volume labels = texture_labels(geometry);
  EXPECT_EQ(labels.geometry(), geometry);
  const auto& grid = std::get<Grid<std::uint8_t>>(labels.grid);
  for (std::int64_t k = 0; k < 30; ++k) {
    for (std::int64_t i = 0; i < 20; ++i) {
      Vec3 p = f.world_to_canonical(
          geometry.index_to_world(Vec3(static_cast<double>(i), 0, static_cast<double>(k))));
      EXPECT_EQ(grid(i, 0, k), texture_region(p)) << i << " " << k;
    }
  }
}

TEST(AnalyticField, MarschnerLobbByItsFormula) {
  const auto f = make_analytic_field("marschner-lobb");
  EXPECT_NEAR(f.value({0, 0, 0}), (1 + 0.25 * (1 + 1)) / 2.5, 1e-15);  // rho_r(0) = cos(12 pi) = 1
  EXPECT_NEAR(f.value({1, 0, 1}), 0.25 * 2 / 2.5, 1e-15);  // cos(12 pi cos(pi/2)) = 1, sin(pi/2) = 1
}

TEST(AnalyticField, SphereSurfaceIsAtOneHalf) {
  const auto f = make_analytic_field("sphere");
  EXPECT_NEAR(f.value({0.36, 0.48, 0}), 0.5, 1e-14);
  EXPECT_EQ(f.value({0, 0, 0}), 1);
  EXPECT_EQ(f.value({1, 1, 1}), 0);
}

TEST(AnalyticField, ProteinHasBothSigns) {
  const auto f = make_analytic_field("protein");
  const Volume u8 = sampled_volume(f, VoxelType::u8, default_scale(f, VoxelType::u8));
  const Volume i16 = sampled_volume(f, VoxelType::i16, default_scale(f, VoxelType::i16));
  const Range range = value_range(i16);
  EXPECT_LT(range.min, -16000);
  EXPECT_GT(range.max, 16000);
  const auto& voxels = std::get<Grid<std::uint8_t>>(u8.grid).voxels;
  const auto zeros = std::count(voxels.begin(), voxels.end(), 0);
  EXPECT_GT(zeros, static_cast<std::ptrdiff_t>(voxels.size() / 4));  // the negative part is clamped away
}

TEST(GaussianLineIntegral, AgreesWithQuadrature) {
  Rng rng(10);
  for (int n = 0; n < 50; ++n) {
    const Vec3 o(rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-2, 2));
    const Vec3 d(rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-2, 2));
    const double t0 = rng.uniform(-1, 0), t1 = rng.uniform(0, 2), sigma = rng.uniform(0.2, 0.5);
    const Vec3 c(0.1, -0.2, 0.3);
    // Simpson on 4000 intervals: (h/s)^4 / 180 with h/s about 0.01.
    double sum = 0;
    const int m = 4000;
    for (int i = 0; i <= m; ++i) {
      const double t = t0 + (t1 - t0) * i / m;
      const double w = i == 0 || i == m ? 1 : i % 2 == 1 ? 4 : 2;
      sum += w * std::exp(-(o + t * d - c).squaredNorm() / (2 * sigma * sigma));
    }
    EXPECT_NEAR(gaussian_line_integral(c, sigma, o, d, t0, t1), sum * (t1 - t0) / m / 3, 1e-10);
  }
  // Far from the maximum the digits must survive.
  EXPECT_NEAR(gaussian_line_integral(Vec3::Zero(), 1, {10, 0, 0}, {1, 0, 0}, 0, 5) / 1.9100139e-23, 1, 1e-6);
}

}  // namespace
}  // namespace vol::volume
