// Observed order under step halving, on a field that does not vanish where rays enter and leave.
#include <gtest/gtest.h>

#include <cmath>

#include "fields.h"

namespace vol::render {
namespace {

const FunctionField kSmooth{
    [](const Vec3& p) {
      return 0.5 + 0.3 * std::sin(1.3 * p[0] + 0.4) * std::cos(0.9 * p[1]) + 0.1 * std::sin(p[2]);
    },
    [](const Vec3& p) {
      return Vec3(0.39 * std::cos(1.3 * p[0] + 0.4) * std::cos(0.9 * p[1]),
                  -0.27 * std::sin(1.3 * p[0] + 0.4) * std::sin(0.9 * p[1]), 0.1 * std::cos(p[2]));
    },
    generic_box()};

/// Order between the steps L/n and L/4n, by the error's ratio; the chord is divided evenly.
double observed_order(Quadrature rule, Model model, bool shaded) {
  Scene scene = scene_of(ramp_transfer(0.7));
  scene.model = model;
  if (shaded) scene.shading = Shading{};
  const Pixel truth = cast(reference_caster(view_of(kSmooth), scene, {}), kSmooth.box, scene);
  const double length = chord_length(kSmooth.box, scene);
  const auto error = [&](int segments) {
    RenderOptions options;
    options.quadrature = rule;
    options.step = length / segments;
    return difference(cast(plain_caster(view_of(kSmooth), scene, options), kSmooth.box, scene), truth);
  };
  return std::log2(error(64) / error(256)) / 2;
}

TEST(Order, RectangleOne) {
  EXPECT_NEAR(observed_order(Quadrature::rectangle, Model::composite, false), 1, 0.1);
  EXPECT_NEAR(observed_order(Quadrature::rectangle, Model::composite, true), 1, 0.1);
  EXPECT_NEAR(observed_order(Quadrature::rectangle, Model::xray, false), 1, 0.1);
}

TEST(Order, TrapezoidTwo) {
  EXPECT_NEAR(observed_order(Quadrature::trapezoid, Model::composite, false), 2, 0.1);
  EXPECT_NEAR(observed_order(Quadrature::trapezoid, Model::composite, true), 2, 0.1);
  EXPECT_NEAR(observed_order(Quadrature::trapezoid, Model::xray, false), 2, 0.1);
}

TEST(Order, PreintegratedTwo) {
  EXPECT_NEAR(observed_order(Quadrature::preintegrated, Model::composite, false), 2, 0.1);
  EXPECT_NEAR(observed_order(Quadrature::preintegrated, Model::composite, true), 2, 0.1);
  EXPECT_NEAR(observed_order(Quadrature::preintegrated, Model::xray, false), 2, 0.1);
}

}  // namespace
}  // namespace vol::render
