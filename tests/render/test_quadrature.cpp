#include "render/quadrature.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "render/gauss.h"
#include "transfer/opacity.h"

namespace vol::render {
namespace {

Node node_at(const Optics& optics, double value) {
  return {value, optics.transfer().opacity(value), optics.transfer().colour(value), {}};
}

Segment joined(const Segment& a, const Segment& b) {
  return {a.emission + a.transmittance * b.emission, a.alpha + a.transmittance * b.alpha,
          a.transmittance * b.transmittance, a.optical_depth + b.optical_depth};
}

const transfer::TransferFunction kSteps{{{0, Vec3(0, 0, 0.2)}, {0.3, Vec3(1, 0, 0)}, {0.8, Vec3(0, 1, 0.5)}},
                                        {{0.1, 0}, {0.25, 0.7}, {0.4, 0.1}, {0.4, 0.6}, {0.9, 0.3}}};

TEST(Quadrature, ConstantSegmentIsTheSameByEveryRule) {
  const Optics optics(kSteps, 0.5);
  const Node node = node_at(optics, 0.21);
  const double tau = -std::log1p(-node.opacity) * 0.3 / 0.5;
  for (const auto& s : {rectangle(node, 0.3, optics), trapezoid(node, node, 0.3, optics),
                        preintegrated(node, node, 0.3, optics)}) {
    EXPECT_NEAR(s.optical_depth, tau, 1e-15);
    EXPECT_NEAR(s.alpha, -std::expm1(-tau), 1e-15);
    EXPECT_NEAR((s.emission - node.colour * s.alpha).norm(), 0, 1e-15);
  }
}

TEST(Quadrature, PreintegratedIsAdditive) {
  // The integral over a segment is that over its two parts, wherever it is cut.
  const Optics optics(kSteps, 0.5);
  Rng rng(5);
  for (int trial = 0; trial < 200; ++trial) {
    const double f0 = rng.uniform(-0.1, 1.1), f1 = rng.uniform(-0.1, 1.1), h = rng.uniform(0.01, 3);
    const double cut = rng.uniform();
    const Node a = node_at(optics, f0), m = node_at(optics, f0 + cut * (f1 - f0)), b = node_at(optics, f1);
    const Segment whole = preintegrated(a, b, h, optics);
    const Segment parts =
        joined(preintegrated(a, m, cut * h, optics), preintegrated(m, b, (1 - cut) * h, optics));
    EXPECT_NEAR((whole.emission - parts.emission).norm(), 0, 1e-12) << trial;
    EXPECT_NEAR(whole.optical_depth, parts.optical_depth, 1e-12 * (1 + whole.optical_depth)) << trial;
    EXPECT_NEAR(whole.alpha, parts.alpha, 1e-13) << trial;
  }
}

TEST(Quadrature, PreintegratedIsTheIntegralOfTheRamp) {
  // One interval, against nested quadrature of the definition itself.
  const Optics optics({{{0, Vec3(0.1, 0, 1)}, {1, Vec3(0.9, 1, 0)}}, {{0, 0.05}, {1, 0.8}}}, 1);
  const double f0 = 0.1, f1 = 0.85, h = 1.7;
  const auto a = [&](double u) { return optics.transfer().opacity(f0 + u * (f1 - f0)); };
  const auto tau = [&](double u) {
    return h * gauss_kronrod([&](double v) { return -std::log1p(-a(v)); }, 0, u, 1e-14);
  };
  const Segment s = preintegrated(node_at(optics, f0), node_at(optics, f1), h, optics);
  EXPECT_NEAR(s.optical_depth, tau(1), 1e-13);
  for (int c = 0; c < 3; ++c) {
    const double emission = gauss_kronrod(
        [&](double u) {
          return h * optics.transfer().colour(f0 + u * (f1 - f0))[c] * -std::log1p(-a(u)) * std::exp(-tau(u));
        },
        0, 1, 1e-13);
    EXPECT_NEAR(s.emission[c], emission, 1e-12);
  }
}

TEST(Quadrature, OpaqueEnds) {
  const Optics optics({{{0, Vec3(1, 0, 0)}, {1, Vec3(0, 1, 0)}}, {{0, 0}, {1, 1}}}, 2);
  const Node clear = node_at(optics, 0), half = node_at(optics, 0.5), solid = node_at(optics, 1);
  EXPECT_EQ(rectangle(solid, 1e-9, optics).transmittance, 0);
  EXPECT_EQ(rectangle(solid, 1e-9, optics).emission, solid.colour);
  EXPECT_EQ(trapezoid(solid, solid, 1e-9, optics).transmittance, 0);
  // A ramp from opacity 0 to 1 has the mean depth 1 a reference length.
  EXPECT_NEAR(trapezoid(clear, solid, 1, optics).optical_depth, 0.5, 1e-15);
  EXPECT_NEAR(preintegrated(clear, solid, 1, optics).optical_depth, 0.5, 1e-15);
  EXPECT_NEAR(preintegrated(solid, half, 1, optics).optical_depth, 0.5 * (1 - std::log(0.5)), 1e-15);
  EXPECT_EQ(preintegrated(solid, solid, 1e-12, optics).transmittance, 0);
  // A stretch of opacity 1 is opaque, entered with its own colour; what lies behind does not count.
  const Optics wall({{{0, Vec3(1, 0, 0)}, {1, Vec3(0, 1, 0)}}, {{0.4, 0}, {0.4, 1}, {0.6, 1}, {0.6, 0}}}, 2);
  const Segment through = preintegrated(node_at(wall, 0), node_at(wall, 1), 5, wall);
  EXPECT_EQ(through.transmittance, 0);
  EXPECT_NEAR((through.emission - Vec3(0.6, 0.4, 0)).norm(), 0, 1e-15);
  const Segment back = preintegrated(node_at(wall, 1), node_at(wall, 0), 5, wall);
  EXPECT_NEAR((back.emission - Vec3(0.4, 0.6, 0)).norm(), 0, 1e-15);
}

TEST(Quadrature, TrapezoidIgnoresTheColourOfAnInvisibleNode) {
  const Optics optics(kSteps, 0.5);
  Node unseen = node_at(optics, 0.05);
  const Node seen = node_at(optics, 0.3);
  const Segment a = trapezoid(unseen, seen, 0.4, optics);
  unseen.colour = Vec3(100, 100, 100);
  EXPECT_EQ(a.emission, trapezoid(unseen, seen, 0.4, optics).emission);
  EXPECT_EQ(trapezoid(unseen, unseen, 0.4, optics).transmittance, 1);
}

TEST(Quadrature, TinyOpacitiesKeepTheirDigits) {
  const Optics optics({{{0, Vec3(0, 0, 0)}, {1, Vec3(1, 1, 1)}}, {{0, 0}, {1, 1e-20}}}, 1);
  const Segment s = preintegrated(node_at(optics, 0), node_at(optics, 1), 1, optics);
  EXPECT_NEAR(s.alpha / 0.5e-20, 1, 1e-14);
  EXPECT_NEAR(s.emission[0] * 3e20, 1, 1e-6);  // integral of u^2; the rule's tolerance is absolute
}

TEST(Shading, TwoSidedAndAmbientWhereFlat) {
  const BlinnPhong phong({0.2, 0.7, 0.1, 10, std::nullopt});
  const Vec3 d = Vec3(1, 2, -2) / 3;
  EXPECT_DOUBLE_EQ(phong(Vec3::Zero(), d).diffuse, 0.2);
  EXPECT_DOUBLE_EQ(phong(Vec3::Zero(), d).specular, 0);
  for (const double scale : {1.0, -1.0, 1e-200, 1e200}) {  // facing the viewer, either way, at any magnitude
    const Lit lit = phong(scale * d, d);
    EXPECT_NEAR(lit.diffuse, 0.9, 1e-15);
    EXPECT_NEAR(lit.specular, 0.1, 1e-14);
  }
  const Lit edge = phong(Vec3(2, -1, 0), d);  // normal across the view
  EXPECT_NEAR(edge.diffuse, 0.2, 1e-15);
  const BlinnPhong side({0, 1, 1, 2, Vec3(0, 0, 5)});
  EXPECT_NEAR(side(Vec3(0, 0, 1), Vec3(-1, 0, 0)).diffuse, 1, 1e-15);
  EXPECT_NEAR(side(Vec3(0, 0, 1), Vec3(-1, 0, 0)).specular, 0.5, 1e-15);  // H halfway: cos 45 squared
}

}  // namespace
}  // namespace vol::render
