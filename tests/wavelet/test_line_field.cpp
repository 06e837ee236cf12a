#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "random_volume.h"
#include "wavelet/dwt.h"
#include "wavelet/line_field.h"
#include "wavelet/significance.h"
#include "wavelet_label.h"

namespace vol::wavelet {
namespace {

class LineFieldOf : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Wavelets, LineFieldOf, testing::ValuesIn(wavelet_names()), wavelet_label);

/// A line through a random point of the box, from end to end of it and a little short.
struct Line {
  Vec3 origin, direction;
  double begin, end;
};
Line random_line(Rng& rng, const Box3& box) {
  Line line;
  for (int a = 0; a < 3; ++a) {
    line.origin[a] = rng.uniform(box.min[a], box.max[a]);
    line.direction[a] = rng.normal();
  }
  if (rng.below(4) == 0) line.direction = Vec3::Unit(static_cast<Eigen::Index>(rng.below(3)));
  line.direction.normalize();
  line.begin = -1e9;
  line.end = 1e9;
  for (int a = 0; a < 3; ++a) {
    if (line.direction[a] == 0) continue;
    const double p = (box.min[a] - line.origin[a]) / line.direction[a];
    const double q = (box.max[a] - line.origin[a]) / line.direction[a];
    line.begin = std::max(line.begin, std::min(p, q));
    line.end = std::min(line.end, std::max(p, q));
  }
  return line;
}

LineField::List all_of(const LineField& field) {
  LineField::List list(field.size());
  std::iota(list.begin(), list.end(), 0U);
  return list;
}

/// 9 x 12 x 6, odd and even, whose coarse levels are shorter than the longer functions: those are folded.
Expansion expansion_of(const std::string& wavelet, int depth, std::int64_t keep) {
  const auto volume = random_volume<double>({9, 12, 6}, 31);
  auto d = analyze<double>(volume, {.wavelet = wavelet, .levels = 2}, volume::value_range(volume));
  reject(d, {.keep = keep});
  return Expansion(std::move(d), {.depth = depth});
}

// What the bounds say of an interval holds for any points of it; a periodic function's beyond its pieces too.
TEST_P(LineFieldOf, FactorBoundsHold) {
  Rng rng(3);
  const Prototypes prototypes = make_prototypes(make_wavelet(GetParam()), 3);
  for (const PiecewiseCubic* f : {&prototypes.phi, &prototypes.psi}) {
    for (const bool periodic : {false, true}) {
      const FactorBounds bounds(*f, periodic);
      const auto n = static_cast<double>(f->pieces.size());
      const auto value = [&](double q, int derivative) {
        double v = 0;
        const auto* a = bounds.piece(q, v);
        if (a == nullptr) return 0.0;
        const auto& c = *a;
        return derivative == 0 ? c[0] + v * (c[1] + v * (c[2] + v * c[3]))
                               : c[1] + v * (2 * c[2] + v * 3 * c[3]);
      };
      for (int trial = 0; trial < 300; ++trial) {
        const double width = std::pow(10.0, rng.uniform(-4, 0)) * 1.2 * n;
        const double from = rng.uniform(-0.1 * n, 1.1 * n - 0.5 * width);
        const FactorBound b = bounds.on(from, from + width);
        double before = value(from, 0), slope_before = value(from, 1);
        double variation = 0, slope_variation = 0;
        for (int i = 0; i <= 40; ++i) {
          const double q = from + width * i / 40;
          const double f0 = value(q, 0), f1 = value(q, 1);
          // 1e-12: rounding of values of order 1.
          ASSERT_LE(std::abs(f0), b.value + 1e-12);
          ASSERT_LE(std::abs(f1), b.slope + 1e-12);
          variation += std::abs(f0 - before);
          slope_variation += std::abs(f1 - slope_before);
          before = f0;
          slope_before = f1;
        }
        ASSERT_LE(variation, b.slope * width + b.jump + 1e-11) << from << " " << width << " " << periodic;
        ASSERT_LE(slope_variation, b.bend * width + b.kink + 1e-11)
            << from << " " << width << " " << periodic;
      }
    }
  }
}

// Along a line it is the expansion, from all the terms met and from those of a part alone. Sums of the same
// terms in another order: 1e-12 of the sum of their sizes.
TEST_P(LineFieldOf, IsTheExpansionOnTheLine) {
  for (const std::int64_t keep : {1 << 20, 40}) {
    const Expansion expansion = expansion_of(GetParam(), 3, keep);
    const LineTerms terms(expansion);
    LineField field(terms);
    Rng rng(5);
    for (int n = 0; n < 20; ++n) {
      const Line line = random_line(rng, expansion.index_box());
      field.set(line.origin, line.direction, line.begin, line.end);
      LineField::List list = all_of(field);
      const std::size_t all = list.size();
      for (int i = 0; i < 10; ++i) {
        const double a = rng.uniform(line.begin, line.end), b = rng.uniform(a, line.end);
        field.narrow(list, 0, all, a, b);
        const double size = 1e-12 * (1 + field.bound(a, b, list, all, list.size()).size);
        const double t = rng.uniform(a, b);
        const Vec3 p = line.origin + t * line.direction;
        const auto whole = field.at(t, list, 0, all), part = field.at(t, list, all, list.size());
        EXPECT_NEAR(whole.f, part.f, size);
        EXPECT_NEAR(whole.f, expansion.value_index(p), 10 * size);
        const Vec3 gradient = field.gradient(t, list, all, list.size());
        // Slopes of splines of depth 3 are up to 2^3 times as large; a knot may be met from the other side.
        EXPECT_LT((gradient - expansion.gradient_index(p)).norm(), 1e3 * size);
        EXPECT_NEAR(part.slope, gradient.dot(line.direction), 1e3 * size);
        list.resize(all);
      }
    }
  }
}

TEST_P(LineFieldOf, BoundsHoldAlongTheLine) {
  const Expansion expansion = expansion_of(GetParam(), 3, 60);
  const LineTerms terms(expansion);
  const LineTerms::Global global = terms.global();
  LineField field(terms);
  Rng rng(7);
  for (int n = 0; n < 20; ++n) {
    const Line line = random_line(rng, expansion.index_box());
    field.set(line.origin, line.direction, line.begin, line.end);
    LineField::List list = all_of(field);
    const std::size_t all = list.size();
    for (int i = 0; i < 20; ++i) {
      const double a = rng.uniform(line.begin, line.end),
                   w = std::pow(10.0, rng.uniform(-4, 0)) * (line.end - a);
      field.narrow(list, 0, all, a, a + w);
      const auto b = field.bound(a, a + w, list, all, list.size());
      auto before = field.at(a, list, 0, all);
      double variation = 0, slope_variation = 0;
      for (int k = 0; k <= 50; ++k) {
        const auto s = field.at(a + w * k / 50, list, 0, all);
        variation += std::abs(s.f - before.f);
        slope_variation += std::abs(s.slope - before.slope);
        before = s;
      }
      const double rounding = 1e-11 * (1 + b.size);
      EXPECT_LE(variation, b.slope * w + b.jump + rounding);
      EXPECT_LE(variation, global.slope * w + global.jump + rounding);
      if (b.jump == 0) {
        EXPECT_LE(slope_variation, b.bend * w + b.kink + 1e3 * rounding);
        EXPECT_LE(slope_variation, global.bend * w + global.kink + 1e3 * rounding);
      }
      EXPECT_LE(b.slope, global.slope * (1 + 1e-12));
      list.resize(all);
    }
  }
}

// Cut at its knots a line falls into polynomials of degree 9.
TEST_P(LineFieldOf, BetweenKnotsItIsAPolynomial) {
  const Expansion expansion = expansion_of(GetParam(), 2, 60);
  const LineTerms terms(expansion);
  LineField field(terms);
  Rng rng(9);
  for (int n = 0; n < 20; ++n) {
    const Line line = random_line(rng, expansion.index_box());
    field.set(line.origin, line.direction, line.begin, line.end);
    LineField::List list = all_of(field);
    const std::size_t all = list.size();
    double a = line.begin, b = line.end;
    while (const auto knot = field.middle_knot(a, b, list, 0, all)) {
      ASSERT_GT(*knot, a);
      ASSERT_LT(*knot, b);
      (rng.below(2) == 0 ? a : b) = *knot;
    }
    const auto p = field.polynomial(a, b, list, 0, all);
    const double rounding = 1e-12 * (1 + field.bound(a, b, list, 0, all).size);
    for (const double s : {-0.499, -0.3, 0.0, 0.25, 0.499}) {
      double value = 0;
      for (std::size_t k = p.size(); k-- > 0;) value = value * s + p[k];
      EXPECT_NEAR(value, field.at(0.5 * (a + b) + s * (b - a), list, 0, all).f, rounding);
    }
  }
}

}  // namespace
}  // namespace vol::wavelet
