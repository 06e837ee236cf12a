#include "render/refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>

#include "base/error.h"
#include "packet_scenes.h"
#include "render/packet.h"

namespace vol::render {
namespace {

/// An image whose rays give f(x, y) in every channel; counts rays and insists that none comes twice.
template <class F>
image::Image refined(int width, int height, int step, double tolerance, const F& f,
                     std::size_t* rays = nullptr) {
  image::Image image(width, height, {"R", "G", "B", "A", "samples", "depth"});
  std::set<std::pair<int, int>> cast;
  cast_refined(image, step, tolerance, [&](std::span<const PixelPosition> pixels) {
    for (const auto& [x, y] : pixels) {
      EXPECT_TRUE(cast.emplace(x, y).second) << "cast twice: " << x << "," << y;
      for (int c = 0; c < 4; ++c) image.at(x, y, c) = static_cast<float>(f(x, y));
      image.at(x, y, 4) = 1;
      image.at(x, y, 5) = static_cast<float>(f(x, y));
    }
  });
  if (rays) *rays = cast.size();
  return image;
}

template <class F>
double largest_error(const image::Image& image, const F& f) {
  double most = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x)
      most = std::max(most, std::abs(double(image.at(x, y, 0)) - f(x, y)));
  }
  return most;
}

TEST(Refinement, IsExactForBilinearPicturesFromAFewRays) {
  const auto f = [](int x, int y) { return 0.5 + 0.25 * x - 0.5 * y + 0.125 * x * y; };
  std::size_t rays = 0;
  for (const auto& [w, h] :
       {std::pair{65, 33}, {64, 31}, {37, 50}, {1, 40}, {40, 1}, {1, 1}, {2, 2}, {3, 5}}) {
    const auto image = refined(w, h, 8, 1e-2, f, &rays);
    EXPECT_LE(largest_error(image, f), 1e-4) << w << " x " << h << ": float rounding of values up to 500";
    if (w > 30 && h > 30) {
      EXPECT_LT(rays, static_cast<std::size_t>(w * h / 10));
    }
  }
}

TEST(Refinement, CastsEveryRayWhereToleranceIsZeroAndThePictureBends) {
  const auto f = [](int x, int y) { return std::sin(1.3 * x + 0.7 * y * x); };
  std::size_t rays = 0;
  const auto image = refined(45, 37, 16, 0, f, &rays);
  EXPECT_EQ(rays, 45U * 37U);
  EXPECT_EQ(largest_error(image, [&](int x, int y) { return double(static_cast<float>(f(x, y))); }), 0);
}

TEST(Refinement, KeepsItsToleranceOnSmoothPicturesAndSavesRays) {
  const auto f = [](int x, int y) {
    return std::exp(-(std::pow(x - 61.0, 2) + std::pow(y - 40.0, 2)) / 800);
  };
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    std::size_t rays = 0;
    const auto image = refined(133, 97, 8, tolerance, f, &rays);
    // Cubics err by third differences and mixed ones alone, less than the bilinear misfit that is held
    // against the tolerance.
    EXPECT_LE(largest_error(image, f), tolerance);
    EXPECT_LT(rays, tolerance > 5e-3 ? 133U * 97U / 3 : 133U * 97U);
  }
}

TEST(Refinement, IsExactForQuadraticsBetweenOtherCells) {
  const auto f = [](int x, int y) {
    return (0.3 * x * x - 0.2 * y * y + 0.1 * x * y + 0.7 * x - 0.4 * y) / 1000 + 0.5;
  };
  constexpr int kStep = 8;
  std::size_t rays = 0;
  const auto image = refined(8 * kStep + 1, 6 * kStep + 1, kStep, 1, f, &rays);
  ASSERT_EQ(rays, 9U * 7U);
  for (int y = kStep; y < 5 * kStep; ++y) {
    for (int x = kStep; x < 7 * kStep; ++x) {
      // Sums of a dozen floats up to 3.
      EXPECT_NEAR(image.at(x, y, 0), f(x, y), 3e-6) << x << "," << y;
    }
  }
}

TEST(Refinement, OfTwoValuesHasNoThird) {
  // Where lines of three pixels and more do not bend they have one value, and a flat cell has it everywhere:
  // cubics must not reach for pixels that flatness was not told by, nor differences overflow.
  std::mt19937 random(7);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int n = 0; n < 2000; ++n) {
    const int width = 1 + below(70), height = 1 + below(70), step = 1 << below(7);
    const int x0 = below(width), y0 = below(height), radius = 1 + below(60);
    const bool disc = below(2) == 0;
    const float one = n % 2 == 0 ? 0.5F : 3e38F, other = n % 2 == 0 ? 0.0F : -3e38F;
    const auto f = [&](int x, int y) {
      const bool inside = disc ? (x - x0) * (x - x0) + (y - y0) * (y - y0) < radius * radius
                               : 3 * (x - x0) + (radius - 30) * (y - y0) < 0;
      return double(inside ? one : other);
    };
    const auto image = refined(width, height, step, 1e-3, f);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double value = image.at(x, y, 0);
        const double apart = std::min(std::abs(value - double(one)), std::abs(value - double(other)));
        ASSERT_LE(apart, 1e-6 * double(one)) << value << " at " << x << "," << y << " of " << width << " x "
                                             << height << ", step " << step << ", picture " << n;
      }
    }
  }
}

TEST(Refinement, LeavesBlankWhatNoRayMeetsAndKeepsTheDepthOfBlackThings) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  for (const float behind : {kFar, 7.0F}) {
    image::Image image(33, 41, {"R", "G", "B", "A", "samples", "depth"});
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) image.at(x, y, 5) = kFar;
    }
    cast_refined(image, 8, 1e-3, [&](std::span<const PixelPosition> pixels) {
      for (const auto& [x, y] : pixels) image.at(x, y, 5) = x < 16 ? 2 : behind;
    });
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        EXPECT_EQ(image.at(x, y, 0), 0);
        if (x >= 8 && x < 16) continue;  // between two rays of different depth
        EXPECT_EQ(image.at(x, y, 5), x < 8 ? 2 : behind) << x << "," << y;
      }
    }
  }
}

TEST(Refinement, TakesTheNearestDepthWhereOneCornerHasNone) {
  const auto f = [](int, int) { return 0.25; };
  image::Image image(9, 9, {"R", "G", "B", "A", "samples", "depth"});
  cast_refined(image, 8, 1, [&](std::span<const PixelPosition> pixels) {
    for (const auto& [x, y] : pixels) {
      for (int c = 0; c < 4; ++c) image.at(x, y, c) = static_cast<float>(f(x, y));
      image.at(x, y, 5) = x == 0 ? 3.0F : std::numeric_limits<float>::infinity();
    }
  });
  EXPECT_EQ(image.at(1, 1, 5), 3);
  EXPECT_EQ(image.at(7, 2, 5), std::numeric_limits<float>::infinity());
}

TEST(Refinement, RefusesOtherSteps) {
  image::Image image(9, 9, {"R", "G", "B", "A", "samples", "depth"});
  const auto none = [](std::span<const PixelPosition>) {};
  for (const int step : {0, -2, 3, 128}) EXPECT_THROW(cast_refined(image, step, 1e-3, none), Error);
  EXPECT_THROW(cast_refined(image, 2, std::nan(""), none), Error);
}

TEST(Refinement, OfARenderedPictureIsNearIt) {
  const auto v = packet_volume<std::uint8_t>(255, {61, 47, 70});
  RenderOptions options = packet_options();
  options.width = 150;
  options.height = 120;
  const RenderResult whole = raycast_packet(v, packet_soft_scene(255), options);
  options.image_step = 8;
  options.image_tolerance = 2e-3;
  const RenderResult packet = raycast_packet(v, packet_soft_scene(255), options);
  const RenderResult plain = raycast_plain(v, packet_soft_scene(255), options);
  double sum = 0, apart = 0;
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      sum += std::pow(double(whole.image.at(x, y, 0)) - packet.image.at(x, y, 0), 2);
      apart += std::pow(double(plain.image.at(x, y, 0)) - packet.image.at(x, y, 0), 2);
    }
  }
  EXPECT_LE(std::sqrt(sum / (150 * 120)), options.image_tolerance);
  EXPECT_LE(std::sqrt(apart / (150 * 120)),
            options.image_tolerance);  // a cell at the brink may be cut in one alone
  EXPECT_LT(packet.counts.rays, whole.counts.rays / 2);
}

}  // namespace
}  // namespace vol::render
