// What the packet kernels compute with, on every instruction set, against double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/rng.h"
#include "render/packet_transfer.h"

// The targets come before Highway:
#include "render/packet_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "test_packet_math.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file again:
#include <hwy/highway.h>

#include "instruction_sets.h"
#include "render/packet_cubic-inl.h"
#include "render/packet_optics-inl.h"

#ifndef VOL_TEST_PACKET_MATH_ONCE
#define VOL_TEST_PACKET_MATH_ONCE
namespace vol::render {
/// Numbers of which `count` are looked at; as many as a register more are readable and writable.
struct Inverses {
  std::vector<float> v, reciprocal, root;
};
/// Cubics c, monotone on [from, to], and where they take `value`.
struct Crossings {
  std::vector<float> c[4], from, to, value, place;
};
/// Values and the y of nodes there.
struct Extinctions {
  std::vector<float> value, y;
};
}  // namespace vol::render
#endif

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {

void invert(Inverses& x, std::size_t count) {
  const DF d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const F v = hn::LoadU(d, x.v.data() + i);
    hn::StoreU(reciprocal(v), d, x.reciprocal.data() + i);
    hn::StoreU(reciprocal_root(v), d, x.root.data() + i);
  }
}

void cross(Crossings& x, std::size_t count) {
  const DF d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto at = [&](const std::vector<float>& v) HWY_ATTR { return hn::LoadU(d, v.data() + i); };
    const Cubic p{{at(x.c[0]), at(x.c[1]), at(x.c[2]), at(x.c[3])}};
    const F from = at(x.from), to = at(x.to);
    hn::StoreU(crossing(p, from, to, p(from), p(to), at(x.value)), d, x.place.data() + i);
  }
}

void look(const PacketTransfer& transfer, Extinctions& x, std::size_t count) {
  const DF d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    hn::StoreU(Look<1>(transfer, hn::LoadU(d, x.value.data() + i)).extinction(), d, x.y.data() + i);
  }
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::render {
HWY_EXPORT(invert);
HWY_EXPORT(cross);
HWY_EXPORT(look);

namespace {

TEST(PacketMath, ReciprocalsAndTheirRootsAreAsCloseAsTheySay) {
  constexpr std::size_t kCount = 20000;
  Rng rng(41);
  Inverses x;
  for (auto* list : {&x.v, &x.reciprocal, &x.root}) list->resize(kCount + kMaxLanes, 1);
  for (std::size_t i = 0; i < kCount; ++i) {
    x.v[i] = static_cast<float>(std::pow(10, i % 2 ? rng.uniform(-37, 37) : rng.uniform(-0.1, 0.1)));
  }
  on_every_instruction_set([&] {
    HWY_DYNAMIC_DISPATCH(invert)(x, kCount);
    double worst = 0, worst_root = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      const double v = x.v[i];
      worst = std::max(worst, std::abs(x.reciprocal[i] * v - 1));
      worst_root = std::max(worst_root, std::abs(x.root[i] * std::sqrt(v) - 1));
    }
    EXPECT_LE(worst, 3e-7);
    EXPECT_LE(worst_root, 3e-7);
  });
}

/// 3 a s^2 + 2 b s + c does not change its sign on [from, to].
bool monotone(const double* c, double from, double to) {
  const auto slope = [&](double s) { return c[1] + s * (2 * c[2] + s * 3 * c[3]); };
  const double turn = c[3] == 0 ? -1 : -c[2] / (3 * c[3]);
  double least = std::min(slope(from), slope(to)), most = std::max(slope(from), slope(to));
  if (turn > from && turn < to) least = std::min(least, slope(turn)), most = std::max(most, slope(turn));
  return least > 0 || most < 0;
}

// Beside inflections too, where a Newton step leaves more than the second derivative says.
TEST(PacketMath, CrossingsAreWhereTheCubicTakesTheValue) {
  Rng rng(42);
  Crossings x;
  std::vector<double> c[4];
  const auto add = [&](const double* p, double from, double to, double share) {
    const auto at = [&](double s) { return p[0] + s * (p[1] + s * (p[2] + s * p[3])); };
    for (int j = 0; j < 4; ++j) x.c[j].push_back(static_cast<float>(p[j])), c[j].push_back(x.c[j].back());
    x.from.push_back(static_cast<float>(from));
    x.to.push_back(static_cast<float>(to));
    x.value.push_back(static_cast<float>(at(from) + share * (at(to) - at(from))));
  };
  while (x.value.size() < 20000) {
    double p[4];
    if (x.value.size() % 2) {
      for (double& v : p) v = rng.uniform(-1, 1);
    } else {  // around an inflection inside
      const double u = rng.uniform(), steep = std::pow(10, rng.uniform(-2, 0)), b = rng.uniform(0.2, 1);
      p[0] = -steep * u - b * u * u * u, p[1] = steep + 3 * b * u * u, p[2] = -3 * b * u, p[3] = b;
    }
    const double from = rng.uniform(0, 0.5), to = rng.uniform(from + 0.1, 1);
    if (monotone(p, from, to)) add(p, from, to, rng.uniform());
  }
  // u / 4 + u^3, u = s - 3/4, in numbers that are exact: the secant leads to the inflection, where the second
  // derivative is 0, and Newton's step from there to u = -0.375, far beside the place, -0.273. In all lanes.
  const double inflected[4] = {-0.609375, 1.9375, -2.25, 1};
  for (int lane = 0; lane < 2 * kMaxLanes; ++lane) add(inflected, 0, 1, 0.75);
  const std::size_t count = x.value.size();
  x.place.resize(count);
  for (auto* list : {&x.c[0], &x.c[1], &x.c[2], &x.c[3], &x.from, &x.to, &x.value, &x.place}) {
    list->resize(count + kMaxLanes, 0);
  }
  on_every_instruction_set([&] {
    HWY_DYNAMIC_DISPATCH(cross)(x, count);
    for (std::size_t i = 0; i < count; ++i) {
      const double s = x.place[i];
      ASSERT_GE(s, double(x.from[i]));
      ASSERT_LE(s, double(x.to[i]));
      const double off = c[0][i] + s * (c[1][i] + s * (c[2][i] + s * c[3][i])) - double(x.value[i]);
      const double slope = c[1][i] + s * (2 * c[2][i] + s * 3 * c[3][i]);
      // Rounding of the value, at most 4 ulps of the terms' sum, over the slope; and of the place.
      const double terms = std::abs(c[0][i]) + std::abs(c[1][i]) + std::abs(c[2][i]) + std::abs(c[3][i]);
      EXPECT_LE(std::abs(off), 2.5e-7 * terms + 3e-7 * std::abs(slope)) << i;
    }
  });
}

// A small signal on a large offset: rounding of a cell's cubic leads an ulp beyond the data, which is several
// pieces of the extinction there.
TEST(PacketMath, ExtinctionsBeyondTheDataAreThoseOfItsEnds) {
  const float lo = 1e6F, hi = 1e6F + 0.875F;
  const Optics optics(transfer::TransferFunction({{0, {1, 1, 1}}}, {{lo, 0.3}, {hi - 0.25, 0}, {hi, 0.95}}),
                      1);
  PacketTransfer table;
  ASSERT_TRUE(tabulate(optics, {lo, hi}, false, 0.5, PacketRule::rectangle, table));
  Extinctions x;
  x.value = {lo, hi, lo - 0.0625F, hi + 0.0625F};
  const std::size_t count = x.value.size();
  x.value.resize(count + kMaxLanes, lo);
  x.y.resize(x.value.size());
  on_every_instruction_set([&] {
    HWY_DYNAMIC_DISPATCH(look)(table, x, count);
    for (const std::size_t i : {0, 1}) {
      const double exact = 0.5 * std::log2(1 - optics.transfer().opacity(x.value[i]));
      EXPECT_NEAR(x.y[i], exact, 3e-6 * std::abs(exact));  // the table's 2e-6, and rounding
      EXPECT_EQ(x.y[i + 2], x.y[i]);
    }
  });
}

}  // namespace
}  // namespace vol::render
#endif
