#include "render/extinction_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/rng.h"

namespace vol::render {
namespace {

constexpr std::size_t kMost = 16;

Optics optics(std::vector<transfer::OpacityPoint> opacities) {
  return Optics(transfer::TransferFunction({{0, {1, 1, 1}}}, std::move(opacities)), 1);
}

double evaluated(const std::vector<ExtinctionPiece>& pieces, double value, double range) {
  const auto behind = std::upper_bound(pieces.begin() + 1, pieces.end(), value,
                                       [](double v, const ExtinctionPiece& p) { return v < p.from; });
  const ExtinctionPiece& piece = *(behind - 1);
  double y = 0;
  for (int j = ExtinctionPiece::kDegree; j >= 0; --j) {
    y = y * (value - piece.origin) / range + piece.coefficient[j];
  }
  return y;
}

/// The largest error, over what is allowed, at places all over [lo, hi] and at every point.
double worst(const Optics& function, const std::vector<ExtinctionPiece>& pieces, double lo, double hi) {
  std::vector<double> values;
  for (int i = 0; i <= 4000; ++i) values.push_back(lo + (hi - lo) * i / 4000.0);
  for (const auto& point : function.transfer().opacities()) {
    for (const double v : {std::nextafter(point.value, lo), point.value, std::nextafter(point.value, hi)}) {
      if (v >= lo && v <= hi) values.push_back(v);
    }
  }
  double most = 0;
  for (const double v : values) {
    const double exact = -std::log1p(-function.transfer().opacity(v)) / std::numbers::ln2;
    // 1e-14: rounding in double precision of the polynomial and of the place in it.
    const double allowed = std::max(1e-9 / std::numbers::ln2, 2e-6 * exact) + 1e-14;
    most = std::max(most, std::abs(exact + evaluated(pieces, v, hi - lo)) / allowed);
  }
  return most;
}

TEST(ExtinctionPieces, AreAsCloseAsTheySay) {
  Rng rng(31);
  int found = 0;
  for (int round = 0; round < 300; ++round) {
    const double scale = std::pow(10, rng.uniform(-8, 8)), offset = scale * rng.uniform(-3, 3);
    std::vector<transfer::OpacityPoint> opacities;
    double value = offset;
    const int points = 2 + static_cast<int>(rng.below(5));
    for (int k = 0; k < points; ++k) {
      const double opacity = rng.uniform() < 0.4 ? 0 : rng.uniform(0, 0.95) * std::pow(rng.uniform(), 3);
      opacities.push_back({value, opacity});
      if (rng.uniform() < 0.2) opacities.push_back({value, rng.uniform(0, 0.9)});  // a jump
      value += scale * rng.uniform(0.01, 1);
    }
    const double lo = offset + (value - offset) * rng.uniform(-0.2, 0.4);
    const double hi = rng.uniform() < 0.3 ? opacities.back().value : value + scale * rng.uniform();
    const Optics function = optics(opacities);
    const auto pieces = extinction_pieces(function, lo, hi, kMost);
    if (pieces.empty()) continue;
    ++found;
    EXPECT_LE(pieces.size(), kMost);
    EXPECT_EQ(pieces.front().from, lo);
    EXPECT_TRUE(std::is_sorted(pieces.begin(), pieces.end(),
                               [](const auto& a, const auto& b) { return a.from < b.from; }));
    EXPECT_LE(worst(function, pieces, lo, hi), 1) << "round " << round;
  }
  EXPECT_GT(found, 200);
}

TEST(ExtinctionPieces, OneIsEnoughForASoftRampAndFewForASteepOne) {
  EXPECT_EQ(extinction_pieces(optics({{0, 0}, {255, 0.05}}), 0, 250, kMost).size(), 1U);
  // Chords of the same accuracy at its end: 0.95 / 0.05 / sqrt(8 2e-6 3), more than 2000.
  const auto steep = extinction_pieces(optics({{0, 0}, {255, 0.95}}), 0, 255, kMost);
  EXPECT_GT(steep.size(), 1U);
  EXPECT_LE(steep.size(), 9U);  // the largest value is one of its own
}

TEST(ExtinctionPieces, AreExactlyTransparentWhereOpacityIsZero) {
  const auto pieces = extinction_pieces(optics({{10, 0}, {20, 0.3}, {30, 0}, {40, 0}}), 0, 50, kMost);
  ASSERT_FALSE(pieces.empty());
  for (const double v : {0.0, 5.0, 10.0, 30.0, 33.0, 50.0}) EXPECT_EQ(evaluated(pieces, v, 50), 0) << v;
}

// The way that the packets' tables take to a float's origin.
TEST(ExtinctionPieces, AroundAnotherOriginIsTheSamePolynomial) {
  const auto pieces = extinction_pieces(optics({{1, 0.1}, {3, 0.7}}), 1, 3, kMost);
  ASSERT_FALSE(pieces.empty());
  for (const ExtinctionPiece& piece : pieces) {
    const double origin = piece.origin + 0.037;
    const ExtinctionPiece other = piece.around(origin, 0.037 / 2);
    EXPECT_EQ(other.origin, origin);
    for (const double v : {1.0, 1.4, 2.0}) {
      EXPECT_NEAR(evaluated({piece}, v, 2), evaluated({other}, v, 2), 1e-13);
    }
  }
}

TEST(ExtinctionPieces, NoneWhereTheyAreTooManyTooNarrowOrOpaque) {
  EXPECT_TRUE(extinction_pieces(optics({{0, 0}, {1, 1}}), 0, 1, kMost).empty());
  EXPECT_FALSE(extinction_pieces(optics({{0, 0}, {2, 1}}), 0, 1, kMost).empty());  // the data end before
  EXPECT_TRUE(extinction_pieces(optics({{0, 0}, {1, 0.95}}), 0, 1, 2).empty());
  EXPECT_TRUE(extinction_pieces(optics({{0, 0}, {1e-6, 0.5}}), 0, 1, kMost).empty());
}

}  // namespace
}  // namespace vol::render
