#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "noise_volume.h"
#include "render/expansion_line.h"
#include "render/extinction_integral.h"
#include "render/raycast.h"
#include "render/wavelet_composite.h"
#include "wavelet/dwt.h"
#include "wavelet/significance.h"

namespace vol::render {
namespace {

wavelet::Decomposition<double> transformed(const volume::Volume& volume, const std::string& wavelet,
                                           int levels, std::int64_t keep = 1 << 30) {
  auto d =
      wavelet::analyze<double>(volume, {.wavelet = wavelet, .levels = levels}, volume::value_range(volume));
  wavelet::reject(d, {.keep = keep});
  return d;
}

/// A ray through two random points of the box's inside; every fourth along an axis of the grid.
struct Line {
  camera::Ray ray;
  Chord chord;
};
Line random_line(const wavelet::Expansion& f, Rng& rng, int number) {
  const auto& b = f.bounds();
  const auto point = [&] {
    return Vec3(b.corner +
                b.edges * Vec3(rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95)));
  };
  const Vec3 at = point();
  Vec3 direction = point() - at;
  if (number % 4 == 3) direction = b.edges.col(number / 4 % 3);
  direction.normalize();
  const double far = 1000 * rng.uniform(0, 1);
  Line line{{at - far * direction, direction}, {}};
  const auto chord = RayBox(b).chord(line.ray, 0);
  line.chord = *chord;
  return line;
}

/// Places on the chord where any basis function has a knot, and its ends. Of a factor read at u = (x + shift)
/// / scale - k the knots are at multiples of its spacing, for every k the same.
std::vector<double> knots(const wavelet::Expansion& f, const Line& line) {
  std::vector<double> at{line.chord.entry, line.chord.exit};
  const Vec3 o = f.geometry().world_to_index(line.ray.origin);
  const Vec3 d = f.geometry().world_to_index_matrix() * line.ray.direction;
  for (const auto& band : f.bands()) {
    for (int a = 0; a < 3; ++a) {
      if (std::abs(d[a]) < 1e-12 || band.period[static_cast<std::size_t>(a)] == 0) continue;
      const double step = f.function(band.factor[static_cast<std::size_t>(a)]).spacing * band.scale[a];
      const double from = (o[a] + line.chord.entry * d[a] + band.shift[a]) / step;
      const double to = (o[a] + line.chord.exit * d[a] + band.shift[a]) / step;
      for (double j = std::ceil(std::min(from, to)); j <= std::floor(std::max(from, to)); ++j) {
        const double t = (j * step - band.shift[a] - o[a]) / d[a];
        if (t > line.chord.entry && t < line.chord.exit) at.push_back(t);
      }
    }
  }
  std::sort(at.begin(), at.end());
  // Knots of nested levels are the same but for rounding.
  std::vector<double> apart;
  for (const double t : at) {
    if (apart.empty() || t - apart.back() > 1e-9) apart.push_back(t);
  }
  apart.back() = line.chord.exit;
  return apart;
}

double field_at(const wavelet::Expansion& f, const Line& line, double t) {
  return f.value_index(f.geometry().world_to_index(line.ray.origin + t * line.ray.direction));
}

/// The truth by adaptive quadrature of point values, which knows nothing of polynomials: the integral of
/// emission(f, t) T, T = exp(-integral of sigma(f)), from knot to knot. A panel is halved until it agrees
/// with its halves; the rule is Gauss-Legendre with five nodes, and five more up to each of them for T.
struct Truth {
  double emission = 0, depth = 0;
  [[nodiscard]] Truth then(const Truth& behind) const {
    return {emission + std::exp(-depth) * behind.emission, depth + behind.depth};
  }
};
template <class Sigma, class Emission>
class Quadrature5 {
 public:
  Quadrature5(const Sigma& sigma, const Emission& emission) : sigma_(sigma), emission_(emission) {}

  Truth operator()(double a, double b, double tolerance, int level = 0) const {
    return refined(a, b, panel(a, b), tolerance, level);
  }

 private:
  static constexpr double kX[5] = {-0.906179845938663993, -0.538469310105683091, 0, 0.538469310105683091,
                                   0.906179845938663993};
  static constexpr double kW[5] = {0.236926885056189088, 0.478628670499366468, 0.568888888888888889,
                                   0.478628670499366468, 0.236926885056189088};
  [[nodiscard]] double depth(double a, double b) const {
    double sum = 0;
    for (int i = 0; i < 5; ++i) sum += 0.5 * (b - a) * kW[i] * sigma_(0.5 * (a + b) + 0.5 * (b - a) * kX[i]);
    return sum;
  }
  [[nodiscard]] Truth panel(double a, double b) const {
    Truth sum{0, depth(a, b)};
    for (int i = 0; i < 5; ++i) {
      const double t = 0.5 * (a + b) + 0.5 * (b - a) * kX[i];
      sum.emission += 0.5 * (b - a) * kW[i] * emission_(t) * std::exp(-depth(a, t));
    }
    return sum;
  }
  [[nodiscard]] Truth refined(double a, double b, const Truth& whole, double tolerance, int level) const {
    const double m = 0.5 * (a + b);
    const Truth left = panel(a, m), right = panel(m, b), both = left.then(right);
    const double off = std::max(std::abs(both.emission - whole.emission), std::abs(both.depth - whole.depth));
    if (level > 0 && (off <= tolerance || level == 36)) return both;
    return refined(a, m, left, 0.5 * tolerance, level + 1)
        .then(refined(m, b, right, 0.5 * tolerance, level + 1));
  }
  const Sigma& sigma_;
  const Emission& emission_;
};
using Kinks = std::vector<std::function<double(double)>>;
Kinks crossings(const wavelet::Expansion& f, const Line& line, const std::vector<double>& values) {
  Kinks kinks;
  for (const double v : values)
    kinks.push_back([&f, &line, v](double t) { return field_at(f, line, t) - v; });
  return kinks;
}
/// And of |N.L|.
Kinks crossings(const wavelet::Expansion& f, const Line& line, const std::vector<double>& values,
                const Scene& scene) {
  Kinks kinks = crossings(f, line, values);
  if (scene.shading) {
    const Vec3 light = scene.shading->light.value_or(line.ray.direction);
    kinks.push_back([&f, &line, light](double t) {
      return f.gradient(line.ray.origin + t * line.ray.direction).dot(light);
    });
  }
  return kinks;
}
template <class Sigma, class Emission>
Truth truth(const wavelet::Expansion& f, const Line& line, double tolerance, const Kinks& kinks,
            const Sigma& sigma, const Emission& emission) {
  const auto s = [&](double t) { return sigma(field_at(f, line, t)); };
  const auto e = [&](double t) { return emission(field_at(f, line, t), t); };
  const Quadrature5<decltype(s), decltype(e)> quadrature(s, e);
  Truth sum;
  auto at = knots(f, line);
  const std::size_t knots_only = at.size();
  for (std::size_t n = 0; n + 1 < knots_only; ++n) {
    for (const auto& less : kinks) {
      for (int i = 0; i < 16; ++i) {
        double a = at[n] + (at[n + 1] - at[n]) * std::max<double>(i, 1e-9) / 16;
        double b = at[n] + (at[n + 1] - at[n]) * std::min<double>(i + 1, 16 - 1e-9) / 16;
        const double sign = less(a);
        if (sign * less(b) >= 0) continue;
        for (int step = 0; step < 60; ++step) (less(0.5 * (a + b)) * sign > 0 ? a : b) = 0.5 * (a + b);
        at.push_back(0.5 * (a + b));
      }
    }
  }
  std::sort(at.begin(), at.end());
  for (std::size_t n = 0; n + 1 < at.size(); ++n) {
    sum = sum.then(quadrature(at[n], at[n + 1], tolerance * (at[n + 1] - at[n]) / line.chord.length()));
  }
  return sum;
}

Scene plain_scene() {
  Scene scene;
  scene.model = Model::composite;
  return scene;
}

struct Cast {
  Pixel pixel;
  RenderCounts spent;
  CompositeCounts counts;
};
Cast cast(const wavelet::Expansion& f, const Line& line, const Scene& scene, const RenderOptions& options,
          const CompositeOptions& composite) {
  Cast result;
  result.pixel =
      WaveletComposite(f, scene, options, composite).cast(line.ray, line.chord, result.spent, result.counts);
  return result;
}

class CompositeOf : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Wavelets, CompositeOf,
                         testing::Values("haar", "daubechies-4", "daubechies-8", "coiflet-6",
                                         "battle-lemarie-1", "battle-lemarie-3"),
                         [](const auto& wavelet) {
                           std::string name = wavelet.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(CompositeOf, PiecesAreTheFieldBetweenItsKnots) {
  const wavelet::Expansion f(transformed(noise({9, 6, 11}, 3, -0.5, 1), GetParam(), 2), {.depth = 2});
  const wavelet::LineTerms terms(f);
  ExpansionLine expansion(terms);
  Rng rng(7);
  for (int n = 0; n < 16; ++n) {
    const Line line = random_line(f, rng, n);
    double at = line.chord.entry;
    const Vec3 o = f.geometry().world_to_index(line.ray.origin);
    expansion.visit(line.ray, line.chord, [&](const RayPiece& piece) {
      EXPECT_NEAR(piece.t0, at, 1e-12 * (1 + std::abs(at)));
      EXPECT_GT(piece.t1, piece.t0);
      at = piece.t1;
      const double u = rng.uniform(0.01, 0.99), t = piece.t0 + u * (piece.t1 - piece.t0);
      const Vec3 p = line.ray.origin + t * line.ray.direction;
      // 432 terms of size 1; t is up to 1000, whose rounding moves p by 1e-13, times slopes up to 100.
      EXPECT_NEAR(piece.p(u), f.value(p), 1e-10) << "piece " << piece.t0 << " " << o.transpose();
      EXPECT_LT((expansion.gradient(t) - f.gradient(p)).norm(), 1e-8) << t;
      return true;
    });
    EXPECT_NEAR(at, line.chord.exit, 1e-12 * (1 + at));
  }
}

TEST_P(CompositeOf, EqualsAdaptiveQuadratureOfPointValues) {
  const wavelet::Expansion f(transformed(noise({9, 6, 11}, 3, -0.5, 1), GetParam(), 2, 60), {.depth = 2});
  Rng rng(8);
  for (int n = 0; n < 8; ++n) {
    const Line line = random_line(f, rng, n);
    for (const bool keep : {false, true}) {
      constexpr double kScale = 0.8;
      const auto sigma = [&](double v) { return kScale * (keep ? v : std::max(v, 0.0)); };
      const Truth t =
          truth(f, line, 1e-10, crossings(f, line, {0}), sigma, [&](double v, double) { return sigma(v); });
      const auto c = cast(f, line, plain_scene(), {}, {.extinction = kScale, .keep_negative = keep});
      EXPECT_NEAR(c.pixel.colour[0], t.emission, 2e-10) << n << keep;
      EXPECT_NEAR(c.pixel.alpha, -std::expm1(-t.depth), 2e-10) << n << keep;
      EXPECT_EQ(c.pixel.colour[0], c.pixel.colour[2]);
      EXPECT_EQ(c.counts.clamped_pieces > 0, c.counts.clamped_depth > 1e-9) << n << keep;
      if (keep) {
        EXPECT_EQ(c.counts.clamped_pieces, 0);
      }
    }
  }
}

Scene shaded_scene() {
  Scene scene = plain_scene();
  scene.shading =
      Shading{.ambient = 0.2, .diffuse = 0.7, .specular = 0.3, .exponent = 8, .light = Vec3(1, 2, 3)};
  return scene;
}

TEST_P(CompositeOf, LightFromTheSideKeepsItsTolerance) {
  const wavelet::Expansion f(transformed(noise({6, 5, 7}, 4, 0.05, 1), GetParam(), 1, 80), {.depth = 1});
  Rng rng(9);
  for (const bool headlight : {false, true}) {
    Scene scene = shaded_scene();
    if (headlight) scene.shading->light.reset();
    const BlinnPhong shading(*scene.shading);
    for (int n = 0; n < 3; ++n) {
      const Line line = random_line(f, rng, n);
      const auto sigma = [&](double v) { return std::max(v, 0.0); };
      const Truth t = truth(f, line, 1e-9, crossings(f, line, {0}, scene), sigma, [&](double v, double at) {
        return sigma(v) * shading(f.gradient(line.ray.origin + at * line.ray.direction),
                                  line.ray.direction)(Vec3::Ones())[0];
      });
      for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
        const auto c = cast(f, line, scene, {.tolerance = tolerance}, {});
        EXPECT_NEAR(c.pixel.colour[0], t.emission, tolerance + 1e-8) << headlight << n;
        EXPECT_NEAR(c.pixel.alpha, -std::expm1(-t.depth), 1e-8);
        EXPECT_GT(c.spent.gradients, 0);
      }
    }
  }
}

Scene transfer_scene(bool shaded) {
  Scene scene = shaded ? shaded_scene() : plain_scene();
  scene.transfer = transfer::TransferFunction({{-0.5, {0.2, 0.1, 0.9}}, {1, {1, 0.8, 0.3}}},
                                              {{-0.2, 0}, {0.1, 0.3}, {0.5, 0.05}, {1, 0.9}});
  scene.reference_length = 1.5;
  return scene;
}

TEST_P(CompositeOf, ThroughATransferFunctionKeepsItsTolerance) {
  const wavelet::Expansion f(transformed(noise({6, 5, 7}, 5, -0.5, 1), GetParam(), 1, 80), {.depth = 1});
  Rng rng(10);
  for (const bool shaded : {false, true}) {
    const Scene scene = transfer_scene(shaded);
    const auto sigma = [&](double v) {
      return -std::log1p(-scene.transfer.opacity(v)) / scene.reference_length;
    };
    for (int n = 0; n < 3; ++n) {
      const Line line = random_line(f, rng, n);
      const int channel = n;
      const Truth t =
          truth(f, line, 1e-9, crossings(f, line, {-0.5, -0.2, 0.1, 0.5, 1}, scene), sigma,
                [&](double v, double at) {
                  Vec3 colour = scene.transfer.colour(v);
                  if (shaded) {
                    colour = BlinnPhong(*scene.shading)(f.gradient(line.ray.origin + at * line.ray.direction),
                                                        line.ray.direction)(colour);
                  }
                  return sigma(v) * colour[channel];
                });
      for (const double tolerance : {1e-3, shaded ? 1e-6 : 1e-8}) {  // kinks of |N.L| are not cut
        const auto c = cast(f, line, scene, {.tolerance = tolerance}, {.transfer = true});
        EXPECT_NEAR(c.pixel.colour[channel], t.emission, tolerance + 1e-8) << shaded << n;
        EXPECT_NEAR(c.pixel.alpha, -std::expm1(-t.depth), tolerance + 1e-8) << shaded << n;
        EXPECT_GT(c.counts.evaluations, 0);
      }
    }
  }
}

// 1 - exp(-v L) on a constant field; T falls to 1/2 at ln 2 / v.
TEST_P(CompositeOf, ConstantFieldHasItsClosedForm) {
  const wavelet::Expansion f(transformed(noise({9, 6, 11}, 1, 0.3, 0.3), GetParam(), 2), {.depth = 3});
  Rng rng(11);
  for (int n = 0; n < 6; ++n) {
    const Line line = random_line(f, rng, n);
    const double length = line.chord.length();
    for (const bool lit : {false, true}) {
      const auto c =
          cast(f, line, lit ? shaded_scene() : plain_scene(), {.tolerance = 1e-9}, {.extinction = 2});
      const double alpha = -std::expm1(-0.6 * length);
      EXPECT_NEAR(c.pixel.alpha, alpha, 1e-11);
      // The gradient of a constant is rounding, and so is its direction: at least ambient light, at most all
      // of it.
      if (lit) {
        EXPECT_GT(c.pixel.colour[0], 0.19 * alpha);
        EXPECT_LT(c.pixel.colour[0], 1.21 * alpha);
      } else {
        EXPECT_NEAR(c.pixel.colour[0], alpha, 1e-11);
      }
      if (0.6 * length > std::log(2) + 1e-3) {
        EXPECT_NEAR(c.pixel.depth - line.chord.entry, std::log(2) / 0.6, 1e-9);
      } else if (0.6 * length < std::log(2) - 1e-3) {
        EXPECT_EQ(c.pixel.depth, std::numeric_limits<double>::infinity());
      }
    }
  }
}

// exp(-r^2 / (2 s^2)), s = 4 voxels of 32, whose line integral at distance b from the centre is exp(-b^2 / (2
// s^2)) s sqrt(2 pi), through the voxels: the cubic splines are of order 4, (h / s)^4 / 384 times the fourth
// derivative's 3 of the largest value; at the box's end the Gaussian is 6e-4.
TEST(WaveletComposite, AGaussianNearItsClosedForm) {
  volume::Grid<double> grid;
  grid.geometry.dims = {32, 32, 32};
  grid.voxels.resize(32 * 32 * 32);
  constexpr double kS = 4, kMiddle = 15.5;
  for (std::int64_t n = 0; n < 32 * 32 * 32; ++n) {
    const Vec3 p(static_cast<double>(n % 32), static_cast<double>(n / 32 % 32),
                 static_cast<double>(n / 1024));
    grid.voxels[static_cast<std::size_t>(n)] =
        std::exp(-(p - Vec3::Constant(kMiddle)).squaredNorm() / (2 * kS * kS));
  }
  volume::Volume volume;
  volume.grid = std::move(grid);
  const wavelet::Expansion f(wavelet::analyze<double>(
      volume,
      {.wavelet = "battle-lemarie-3", .levels = 2, .initialisation = wavelet::Initialisation::interpolate},
      {0, 1}));
  for (const double b : {0.0, 2.3, 5.1}) {
    const Vec3 direction = Vec3(0.3, 0, 1).normalized();
    const Vec3 aside = Vec3(0, b, 0);
    Line line{{Vec3::Constant(kMiddle) + aside - 60 * direction, direction}, {}};
    line.chord = *RayBox(f.bounds()).chord(line.ray, 0);
    const double depth = 0.2 * std::exp(-b * b / (2 * kS * kS)) * kS * std::sqrt(2 * 3.14159265358979323846);
    const auto c = cast(f, line, plain_scene(), {}, {.extinction = 0.2});
    EXPECT_NEAR(c.pixel.alpha, -std::expm1(-depth), 3e-4) << b;
  }
}

// Haar's wavelet of 8 samples: 1/sqrt 2 on one voxel, -1/sqrt 2 on the next. Clamped, the optical depth is
// that of the first; kept, the two cancel.
TEST(WaveletComposite, OneHaarWaveletIsClampedToItsPositiveHalf) {
  auto d = transformed(noise({8, 1, 1}, 1, -0.5, 1), "haar", 1, 0);
  d.subbands[1].coefficients[1] = 1;
  const wavelet::Expansion f(d);
  Line line{{f.geometry().index_to_world({0, 0, 0}), f.geometry().direction.col(0)}, {}};
  line.chord = *RayBox(f.bounds()).chord(line.ray, -1);
  const double depth = 0.7 / std::sqrt(2.0);
  const auto clamped = cast(f, line, plain_scene(), {}, {});
  EXPECT_NEAR(clamped.pixel.alpha, -std::expm1(-depth), 1e-14);
  EXPECT_EQ(clamped.counts.clamped_pieces, 1);
  EXPECT_NEAR(clamped.counts.clamped_depth, depth, 1e-14);
  const auto kept = cast(f, line, plain_scene(), {}, {.keep_negative = true});
  EXPECT_NEAR(kept.pixel.alpha, 0, 1e-14);
  EXPECT_EQ(kept.counts.clamped_pieces, 0);
}

// (40): one term's (c dW)^2 / 2 an interval, whose number is 1 / length: order 1. (41) has no intervals to
// refine.
TEST(WaveletComposite, LinearisedByIntervalIsOfFirstOrderAndByBasisOfNone) {
  for (const char* name : {"daubechies-4", "daubechies-8"}) {
    Rng rng(12);
    const auto d = transformed(noise({9, 6, 11}, 3, 0, 0.3), name, 2);
    std::array<double, 5> interval{}, basis{};
    for (int n = 0; n < 6; ++n) {
      const std::uint64_t seed = 100 + static_cast<std::uint64_t>(n);
      for (int depth = 3; depth < 8; ++depth) {
        const wavelet::Expansion f(d, {.depth = depth});
        Rng own(seed);
        const Line line = random_line(f, own, n % 3);
        const auto error = [&](Linearised linearised) {
          const auto exact = cast(f, line, plain_scene(), {}, {.keep_negative = true});
          const auto c = cast(f, line, plain_scene(), {}, {.linearised = linearised});
          return std::max(std::abs(c.pixel.alpha - exact.pixel.alpha),
                          std::abs(c.pixel.colour[0] - exact.pixel.colour[0]));
        };
        const auto at = static_cast<std::size_t>(depth - 3);
        interval[at] = std::max(interval[at], error(Linearised::interval));
        basis[at] = std::max(basis[at], error(Linearised::basis));
      }
    }
    for (std::size_t n = 0; n + 1 < 5; ++n) {
      EXPECT_NEAR(std::log2(interval[n] / interval[n + 1]), 1, 0.2) << name << n;
      EXPECT_NEAR(std::log2(basis[n] / basis[n + 1]), 0, 0.2) << name << n;
    }
    EXPECT_GT(basis[4], 10 * interval[4]) << name;
  }
}

TEST(WaveletComposite, Extremes) {
  const auto pixel = [](const wavelet::Expansion& f, double extinction) {
    Rng rng(13);
    const Line line = random_line(f, rng, 1);
    return cast(f, line, plain_scene(), {}, {.extinction = extinction}).pixel;
  };
  const auto volume = noise({17, 33, 64}, 5, 0, 1);
  const Pixel none = pixel(wavelet::Expansion(transformed(volume, "battle-lemarie-3", 3, 0)), 1);
  EXPECT_EQ(none.alpha, 0);
  EXPECT_EQ(none.depth, std::numeric_limits<double>::infinity());
  const wavelet::Expansion all(transformed(volume, "battle-lemarie-3", 3));
  const Pixel dim = pixel(all, 1e-30), bright = pixel(all, 1e-3), opaque = pixel(all, 1e30);
  EXPECT_NEAR(dim.alpha / 1e-30, -std::log1p(-bright.alpha) / 1e-3, 1e-9);
  EXPECT_EQ(opaque.alpha, 1);
  // Values of 1e30 and 1e-30 are values of 1 with another extinction.
  for (const double size : {1e30, 1e-30}) {
    const wavelet::Expansion f(transformed(noise({16, 8, 8}, 5, 0, size), "daubechies-6", 2, 40));
    const wavelet::Expansion one(transformed(noise({16, 8, 8}, 5, 0, 1), "daubechies-6", 2, 40));
    EXPECT_NEAR(pixel(f, 0.1 / size).alpha, pixel(one, 0.1).alpha, 1e-12);
    EXPECT_NEAR(pixel(f, 2 / size).depth, pixel(one, 2).depth, 1e-9);
  }
  // Opaque in front, and lit: all of the light of where the ray enters.
  const wavelet::Expansion wall(transformed(noise({16, 8, 8}, 5, 8e29, 1e30), "battle-lemarie-3", 2));
  Rng rng(13);
  const Line line = random_line(wall, rng, 1);
  const BlinnPhong shading(*shaded_scene().shading);
  const double lit = shading(wall.gradient(line.ray.origin + line.chord.entry * line.ray.direction),
                             line.ray.direction)(Vec3::Ones())[0];
  EXPECT_NEAR(cast(wall, line, shaded_scene(), {}, {}).pixel.colour[0], lit, 1e-5);
  // One coefficient, and depth to the last level.
  const Pixel one =
      pixel(wavelet::Expansion(transformed(noise({8, 8, 8}, 6, 0, 1), "daubechies-4", 3, 1)), 1);
  EXPECT_GT(one.alpha, 0.1);
  EXPECT_LT(one.alpha, 1);
}

TEST(WaveletComposite, LightWithoutBoundIsAnErrorAndNoEndlessLoop) {
  const wavelet::Expansion f(transformed(noise({8, 8, 8}, 6, -1e30, -1e29), "battle-lemarie-3", 1));
  for (Scene scene : {plain_scene(), shaded_scene()}) {
    EXPECT_THROW((void)WaveletComposite(f, scene, {.width = 4, .height = 4}, {.keep_negative = true}).draw(),
                 Error);
    CompositeCounts counts;
    const auto black = WaveletComposite(f, scene, {.width = 4, .height = 4}, {}).draw(&counts);
    EXPECT_EQ(black.image.at(2, 2, 0), 0);
    EXPECT_GT(counts.clamped_pieces, 0);
  }
}

TEST(WaveletComposite, RefusesWhatDoesNotGoTogether) {
  const wavelet::Expansion f(transformed(noise({8, 8, 8}, 6, -0.5, 1), "haar", 1));
  const auto refuses = [&](const Scene& scene, const CompositeOptions& composite) {
    EXPECT_THROW((WaveletComposite{f, scene, {}, composite}), Error);
  };
  refuses(plain_scene(), {.extinction = -1});
  refuses(plain_scene(), {.transfer = true, .linearised = Linearised::interval});
  refuses(shaded_scene(), {.linearised = Linearised::basis});
}

// The picture is that of the plain caster, which samples the field, as its steps get short; and the same
// whatever the threads.
TEST(WaveletComposite, DrawsWhatThePlainCasterDraws) {
  const wavelet::Expansion f(transformed(noise({9, 6, 11}, 3, -0.5, 1), "daubechies-8", 2, 30), {.depth = 3});
  for (const bool shaded : {false, true}) {
    Scene scene = transfer_scene(shaded);
    scene.view.azimuth = 33;
    scene.view.elevation = 21;
    const RenderOptions options{.width = 9, .height = 7, .step = 0.01, .tolerance = 1e-6};
    const auto plain = raycast_plain(f, scene, options);
    const int before = thread_count();
    set_thread_count(1);
    const auto one = WaveletComposite(f, scene, options, {.transfer = true}).draw();
    set_thread_count(2);
    const auto two = WaveletComposite(f, scene, options, {.transfer = true}).draw();
    set_thread_count(before);
    EXPECT_TRUE(one.image.pixels == two.image.pixels);
    EXPECT_EQ(one.counts.samples, two.counts.samples);
    for (int y = 0; y < 7; ++y) {
      for (int x = 0; x < 9; ++x) {
        for (int c = 0; c < 4; ++c)
          EXPECT_NEAR(one.image.at(x, y, c), plain.image.at(x, y, c), 2e-3) << x << y;
      }
    }
  }
}

}  // namespace
}  // namespace vol::render
