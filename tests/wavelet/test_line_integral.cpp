#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "random_volume.h"
#include "wavelet/dwt.h"
#include "wavelet/expansion.h"
#include "wavelet/filters.h"
#include "wavelet_label.h"

namespace vol::wavelet {
namespace {

class LineIntegralOf : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Wavelets, LineIntegralOf, testing::ValuesIn(wavelet_names()), wavelet_label);

struct Line {
  Vec3 origin, direction;
  double begin, end;
};

/// Integrals of c w and of |c w| by five Gauss-Legendre nodes (exact to degree 9) between all knots.
std::array<double, 2> by_gauss(const Expansion& expansion, const Band& band, const Term& term,
                               const Line& line) {
  static const double kNode[5] = {0, 0.538469310105683091, -0.538469310105683091, 0.906179845938663993,
                                  -0.906179845938663993};
  static const double kWeight[5] = {0.568888888888888889, 0.478628670499366468, 0.478628670499366468,
                                    0.236926885056189088, 0.236926885056189088};
  const Box3 box = band.box(term);
  double from = line.begin, to = line.end;
  for (int a = 0; a < 3; ++a) {
    const double in = (box.min[a] - line.origin[a]) / line.direction[a];
    const double out = (box.max[a] - line.origin[a]) / line.direction[a];
    from = std::max(from, std::min(in, out));
    to = std::min(to, std::max(in, out));
  }
  if (!(from < to)) return {0, 0};
  std::vector<double> breaks{from, to};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    const PiecewiseCubic& f = expansion.function(band.factor[i]);
    for (std::size_t n = 0; n <= f.pieces.size(); ++n) {
      const double u = f.lower + f.spacing * static_cast<double>(n) + term.k[i];
      const double t = (band.scale[a] * u - band.shift[a] - line.origin[a]) / line.direction[a];
      if (t > from && t < to) breaks.push_back(t);
    }
  }
  std::sort(breaks.begin(), breaks.end());
  double sum = 0, magnitude = 0;
  for (std::size_t n = 0; n + 1 < breaks.size(); ++n) {
    const double middle = 0.5 * (breaks[n] + breaks[n + 1]), half = 0.5 * (breaks[n + 1] - breaks[n]);
    for (int g = 0; g < 5; ++g) {
      const Vec3 p = line.origin + (middle + half * kNode[g]) * line.direction;
      double w = term.c;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto a = static_cast<Eigen::Index>(i);
        w *= expansion.function(band.factor[i]).value((p[a] + band.shift[a]) / band.scale[a] - term.k[i]);
      }
      sum += half * kWeight[g] * w;
      magnitude += half * kWeight[g] * std::abs(w);
    }
  }
  return {sum, magnitude};
}

// Seven coefficients of all levels and orientations, 1000 lines through the box from 0 to 1000 samples away,
// a fifth of them almost along an axis. Both sides are exact for the same piecewise polynomials; lines from
// 1000 samples away know their position to 1e-13.
TEST_P(LineIntegralOf, AgreesWithGaussRulesBetweenAllKnots) {
  const auto volume = random_volume<double>({9, 6, 11}, 12);
  auto d = analyze<double>(volume, {.wavelet = GetParam(), .levels = 2}, volume::value_range(volume));
  Rng rng(77);
  for (auto& band : d.subbands) {
    const auto kept = static_cast<std::size_t>(rng.uniform(0, static_cast<double>(band.coefficients.size())));
    for (std::size_t n = 0; n < band.coefficients.size(); ++n) {
      if (n != kept || (band.level == 1 && band.orientation % 2 == 0)) band.coefficients[n] = 0;
    }
  }
  const Expansion expansion(d, {.depth = 3});
  ASSERT_GT(expansion.coefficients(), 5);
  int met = 0;
  for (int pose = 0; pose < 1000; ++pose) {
    const Vec3 target(rng.uniform(0, 8), rng.uniform(0, 5), rng.uniform(0, 10));
    Vec3 direction(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    if (pose % 5 == 0) {
      direction[pose % 3] *= 1e-9;
      direction[(pose + 1) % 3] *= 1e-4;
    }
    direction.normalize();
    const double away = pose % 2 == 0 ? 1000 : rng.uniform(-5, 5);
    const Line line{target - away * direction, direction, away - rng.uniform(0, 20),
                    away + rng.uniform(0, 20)};
    double sum = 0, truth = 0, magnitude = 0;
    for (const Band& band : expansion.bands()) {
      for (const Term& term : band.terms) {
        sum += line_integral(expansion, band, term, line.origin, line.direction, line.begin, line.end);
        const auto gauss = by_gauss(expansion, band, term, line);
        truth += gauss[0];
        magnitude += gauss[1];
      }
    }
    met += magnitude > 0 ? 1 : 0;
    ASSERT_NEAR(sum, truth, 1e-10 * magnitude) << "pose " << pose;
  }
  EXPECT_GT(met, 500);
}

// Exactly along the axes: two factors are constants.
TEST_P(LineIntegralOf, AlongAnAxisIsAProduct) {
  const auto volume = random_volume<double>({8, 8, 8}, 4);
  const auto d = analyze<double>(volume, {.wavelet = GetParam(), .levels = 1}, volume::value_range(volume));
  const Expansion expansion(d, {.depth = 3});
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a), u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const Band& band : expansion.bands()) {
      const Term& term = band.terms[band.terms.size() / 2];
      const Box3 box = band.box(term);
      const Vec3 p = box.min + 0.37 * (box.max - box.min);
      const auto factor = [&](std::size_t i) {
        const auto e = static_cast<Eigen::Index>(i);
        return expansion.function(band.factor[i]).value((p[e] + band.shift[e]) / band.scale[e] - term.k[i]);
      };
      const double whole = expansion.function(band.factor[axis]).integral() * band.scale[a];
      const double expected = term.c * whole * factor(u) * factor(v);
      EXPECT_NEAR(line_integral(expansion, band, term, p, Vec3::Unit(a), -1e3, 1e3), expected,
                  1e-11 * std::abs(term.c));
      EXPECT_NEAR(line_integral(expansion, band, term, p, -Vec3::Unit(a), -1e3, 1e3), expected,
                  1e-11 * std::abs(term.c));
    }
  }
}

}  // namespace
}  // namespace vol::wavelet
