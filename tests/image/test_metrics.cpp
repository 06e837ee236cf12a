#include "image/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "image/ssim.h"

namespace vol::image {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
const std::vector<ChannelPair> kColour{{"R", 0, 0}, {"G", 1, 1}, {"B", 2, 2}};

/// Smooth shapes with some noise on top: neither constant nor white, so that windows differ.
Image picture(int width, int height, std::uint64_t seed, double noise = 0.05) {
  Image image(width, height, {"R", "G", "B"});
  Rng rng(seed);
  const double u = rng.uniform(0.02, 0.3);
  const double v = rng.uniform(0.02, 0.3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        image.at(x, y, c) =
            static_cast<float>(0.5 + 0.3 * std::sin(u * x + c) * std::cos(v * y - c) + noise * rng.normal());
      }
    }
  }
  return image;
}

Image with_noise(const Image& image, double amplitude, std::uint64_t seed) {
  Image result = image;
  Rng rng(seed);
  for (float& value : result.pixels) value += static_cast<float>(amplitude * rng.normal());
  return result;
}

const std::vector<std::pair<int, int>> kSizes{{1, 1},    {11, 11},  {10, 40},  {12, 11},  {37, 53}, {255, 31},
                                              {256, 32}, {257, 33}, {266, 42}, {267, 43}, {523, 97}};

TEST(Metrics, EqualTheDefinitions) {
  for (const auto& [width, height] : kSizes) {
    SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
    const Image a = picture(width, height, 1);
    const Image b = with_noise(a, 0.1, 2);
    const ImageError error = compare(a, b, kColour);
    long double all_squares = 0;
    for (int c = 0; c < 3; ++c) {
      long double squares = 0;
      long double absolutes = 0;
      double maximum = -1;
      int at_x = 0;
      int at_y = 0;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const double d = static_cast<double>(a.at(x, y, c)) - b.at(x, y, c);
          squares += static_cast<long double>(d) * d;
          absolutes += std::abs(d);
          if (std::abs(d) > maximum) {
            maximum = std::abs(d);
            at_x = x;
            at_y = y;
          }
        }
      }
      const auto& channel = error.channels[static_cast<std::size_t>(c)];
      const auto pixels = static_cast<long double>(width) * height;
      EXPECT_NEAR(channel.mse, static_cast<double>(squares / pixels),
                  1e-14 * channel.mse);  // as the header promises
      EXPECT_NEAR(channel.mae, static_cast<double>(absolutes / pixels), 1e-14 * channel.mae);
      EXPECT_EQ(channel.maximum, maximum);
      EXPECT_EQ(channel.maximum_x, at_x);
      EXPECT_EQ(channel.maximum_y, at_y);
      all_squares += squares / pixels;
    }
    EXPECT_NEAR(error.all.mse, static_cast<double>(all_squares / 3), 1e-14 * error.all.mse);
    EXPECT_DOUBLE_EQ(psnr(error.all, 1), -10 * std::log10(error.all.mse));
    EXPECT_DOUBLE_EQ(rmse_byte(error.all, 2), std::sqrt(error.all.mse) * 127.5);
  }
}

TEST(Metrics, AConstantOffset) {
  Image a = picture(64, 48, 3);
  for (float& value : a.pixels) value = std::round(value * 1024) / 1024;  // so that adding 1/4 is exact
  Image b = a;
  for (float& value : b.pixels) value += 0.25f;
  const ImageError error = compare(b, a, kColour);
  EXPECT_EQ(error.all.mse, 0.0625);
  EXPECT_EQ(error.all.mae, 0.25);
  EXPECT_EQ(error.all.maximum, 0.25);
  EXPECT_EQ(error.all.maximum_x, 0);  // the first of equals
  EXPECT_EQ(error.all.maximum_y, 0);
  EXPECT_EQ(error.all.maximum_channel, "R");
  EXPECT_DOUBLE_EQ(psnr(error.all, 1), -20 * std::log10(0.25));
  EXPECT_DOUBLE_EQ(psnr(error.all, 4), 20 * std::log10(16));
}

TEST(Metrics, EqualImages) {
  const Image a = picture(300, 50, 4);
  const ImageError error = compare(a, a, kColour);
  EXPECT_EQ(error.all.mse, 0);
  EXPECT_EQ(error.all.maximum, 0);
  EXPECT_EQ(error.all.maximum_x, -1);
  EXPECT_EQ(error.all.ssim, 1);
  EXPECT_EQ(psnr(error.all, 1), std::numeric_limits<double>::infinity());
}

TEST(Metrics, AnySideMayBeFirst) {
  const Image a = picture(280, 70, 5);
  const Image b = with_noise(a, 0.02, 6);
  const ImageError ab = compare(a, b, kColour);
  const ImageError ba = compare(b, a, kColour);
  EXPECT_EQ(ab.all.mse, ba.all.mse);
  EXPECT_EQ(ab.all.mae, ba.all.mae);
  EXPECT_EQ(ab.all.maximum, ba.all.maximum);
  EXPECT_EQ(ab.all.ssim, ba.all.ssim);
}

TEST(Ssim, ConstantImagesInClosedForm) {
  // No variance: ssim = (2 x y + C1)/(x^2 + y^2 + C1), the second factor being C2/C2.
  for (const double peak : {1.0, 3.5}) {
    Image a(20, 15, {"Y"});
    Image b(20, 15, {"Y"});
    for (float& value : a.pixels) value = 0.25f;
    for (float& value : b.pixels) value = 0.75f;
    const double c1 = std::pow(0.01 * peak, 2);
    const double expected = (2 * 0.25 * 0.75 + c1) / (0.25 * 0.25 + 0.75 * 0.75 + c1);
    EXPECT_NEAR(compare(a, b, {{"Y", 0, 0}}, {.peak = peak}).all.ssim, expected, 1e-15);
    EXPECT_NEAR(ssim_reference(a, 0, b, 0, peak), expected, 1e-14);
  }
}

TEST(Ssim, AScaledCopyInClosedForm) {
  // One window; y = 2 x about a mean of 0: luminance factor 1, structure (4 v + C2)/(5 v + C2).
  Image x(11, 11, {"Y"});
  Image y(11, 11, {"Y"});
  double mean = 0;
  double variance = 0;
  const auto& w = ssim_weights();
  for (int j = 0; j < 11; ++j) {
    for (int i = 0; i < 11; ++i) {
      const double value = (i - 5) * 0.125 + (j - 5) * 0.0625;  // odd about the centre: weighted mean 0
      x.at(i, j, 0) = static_cast<float>(value);
      y.at(i, j, 0) = static_cast<float>(2 * value);
      const double weight = w[static_cast<std::size_t>(i)] * w[static_cast<std::size_t>(j)];
      mean += weight * value;
      variance += weight * value * value;
    }
  }
  ASSERT_NEAR(mean, 0, 1e-15);
  const double c2 = 0.03 * 0.03;
  EXPECT_NEAR(compare(x, y, {{"Y", 0, 0}}).all.ssim, (4 * variance + c2) / (5 * variance + c2), 1e-14);
}

TEST(Ssim, EqualsTheOracle) {
  for (const auto& [width, height] : kSizes) {
    SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
    const Image a = picture(width, height, 7);
    for (const double amplitude : {1e-4, 0.1, 3.0}) {
      const Image b = with_noise(a, amplitude, 8);
      const ImageError error = compare(a, b, kColour);
      double mean = 0;
      for (int c = 0; c < 3; ++c) mean += ssim_reference(a, c, b, c, 1) / 3;
      if (width < 11 || height < 11) {
        EXPECT_TRUE(std::isnan(error.all.ssim));
        EXPECT_TRUE(std::isnan(mean));
      } else {
        // Rounding of either is some 1e-15 range^2 / C2 = 1e-12 range^2, averaged over windows.
        EXPECT_NEAR(error.all.ssim, mean, 1e-12) << amplitude;
      }
    }
  }
}

TEST(Ssim, ASmallSignalOnALargeOffsetKeepsItsDigits) {
  // 4096 + k 2^-11 is exact in float. The oracle's own error (its mean is rounded to 4096 eps, and the
  // residual enters squared) is far below; a version that squared the values themselves would lose 4096^2 eps
  // / C2 = 4e-6.
  Image a = picture(300, 64, 9);
  Image b = with_noise(a, 0.05, 10);
  for (Image* image : {&a, &b}) {
    for (float& value : image->pixels) value = 4096 + std::round(value * 2048) / 2048;
  }
  const ImageError error = compare(a, b, kColour);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(error.channels[static_cast<std::size_t>(c)].ssim, ssim_reference(a, c, b, c, 1), 1e-11);
  }
  EXPECT_LT(error.all.ssim, 0.9);  // and the structure does show
}

TEST(Ssim, ScalesWithThePeak) {
  // All of it is homogeneous: values, and peak, times 2^k change nothing but exponents.
  const Image a = picture(50, 40, 11);
  const Image b = with_noise(a, 0.05, 12);
  const double expected = compare(a, b, kColour).all.ssim;
  for (const int k : {-90, -20, 20, 90}) {
    Image c = a;
    Image d = b;
    for (float& value : c.pixels) value = std::ldexp(value, k);
    for (float& value : d.pixels) value = std::ldexp(value, k);
    EXPECT_NEAR(compare(c, d, kColour, {.peak = std::ldexp(1.0, k)}).all.ssim, expected, 1e-15) << k;
  }
}

void expect_same(const ChannelError& a, const ChannelError& b) {
  EXPECT_EQ(a.mse, b.mse);
  EXPECT_EQ(a.mae, b.mae);
  EXPECT_EQ(a.maximum, b.maximum);
  EXPECT_EQ(a.maximum_x, b.maximum_x);
  EXPECT_EQ(a.maximum_y, b.maximum_y);
  EXPECT_EQ(a.ssim, b.ssim);
}

TEST(Metrics, TheSameBitsForAnyNumberOfThreadsAndAnyInstructionSet) {
  const Image a = picture(1030, 290, 13);
  const Image b = with_noise(a, 0.02, 14);
  const ImageError expected = compare(a, b, kColour);
  for (const int threads : {1, 2, 3, 7}) {
    set_thread_count(threads);
    const ImageError error = compare(a, b, kColour);
    for (std::size_t c = 0; c < 3; ++c) expect_same(error.channels[c], expected.channels[c]);
  }
  set_thread_count(0);
  const auto supported = hwy::SupportedTargets();
  int sets = 0;
  for (auto targets = supported; targets != 0; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets & -targets);
    const ImageError error = compare(a, b, kColour);
    for (std::size_t c = 0; c < 3; ++c) expect_same(error.channels[c], expected.channels[c]);
    ++sets;
  }
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_GE(sets, 1);
}

TEST(Metrics, TheOrderOfChannelsDoesNotMatter) {
  const Image a = picture(70, 60, 15);
  const Image b = with_noise(a, 0.02, 16);
  const auto forward = compare(a, b, kColour);
  const auto backward = compare(a, b, {kColour[2], kColour[1], kColour[0]});
  for (std::size_t c = 0; c < 3; ++c) expect_same(forward.channels[c], backward.channels[2 - c]);
}

TEST(Metrics, InfinityAndNaNAreSaid) {
  Image a = picture(40, 30, 17);
  Image b = a;
  a.at(3, 4, 0) = b.at(3, 4, 0) = kInf;  // equal
  ImageError error = compare(a, b, kColour);
  EXPECT_EQ(error.all.mse, 0);
  EXPECT_EQ(error.all.maximum, 0);
  EXPECT_TRUE(std::isnan(error.channels[0].ssim));  // no window statistics of infinity
  EXPECT_EQ(error.channels[1].ssim, 1);
  EXPECT_EQ(error.channels[0].infinite_tested, 1);
  EXPECT_EQ(error.channels[0].infinite_reference, 1);

  b.at(3, 4, 0) = -kInf;  // opposite
  error = compare(a, b, kColour);
  EXPECT_EQ(error.all.mse, kInf);
  EXPECT_EQ(error.all.mae, kInf);
  EXPECT_EQ(error.all.maximum, kInf);
  EXPECT_EQ(error.all.maximum_x, 3);
  EXPECT_EQ(error.all.maximum_y, 4);
  EXPECT_EQ(psnr(error.all, 1), -kInf);

  b.at(3, 4, 0) = 1e30f;  // against a number
  EXPECT_EQ(compare(a, b, kColour).all.mse, kInf);

  for (const bool both : {false, true}) {
    Image c = picture(40, 30, 18);
    Image d = c;
    c.at(7, 20, 2) = kNaN;
    c.at(2, 2, 0) = 100;
    if (both) d.at(7, 20, 2) = kNaN;
    error = compare(c, d, kColour);
    EXPECT_TRUE(std::isnan(error.all.mse));
    EXPECT_TRUE(std::isnan(error.all.mae));
    EXPECT_TRUE(std::isnan(error.all.maximum));
    EXPECT_EQ(error.all.maximum_x, 7);
    EXPECT_EQ(error.all.maximum_y, 20);
    EXPECT_TRUE(std::isnan(psnr(error.all, 1)));
    EXPECT_EQ(error.all.nan_tested, 1);
    EXPECT_EQ(error.all.nan_reference, both ? 1 : 0);
    EXPECT_EQ(error.channels[0].maximum_x, 2);
    EXPECT_EQ(error.channels[1].mse, 0);
  }
}

TEST(Metrics, ExtremeValues) {
  for (const float scale : {1e30f, 3e38f, 1e-30f, 1e-44f}) {
    Image a(30, 20, {"Y"});
    Image b(30, 20, {"Y"});
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 30; ++x) a.at(x, y, 0) = (x + y) % 2 ? scale : -scale;
    }
    const ImageError error = compare(a, b, {{"Y", 0, 0}});
    EXPECT_NEAR(error.all.mse, static_cast<double>(scale) * scale, 1e-14 * error.all.mse);
    EXPECT_TRUE(std::isfinite(error.all.ssim));
  }
}

TEST(Metrics, WhatCannotBeComparedIsRefused) {
  const Image a = picture(20, 30, 19);
  try {
    (void)compare(a, picture(30, 20, 19), kColour);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("20x30"), testing::HasSubstr("30x20")));
  }
  EXPECT_THROW((void)compare(a, a, {}), Error);
  EXPECT_THROW((void)compare(a, a, {{"A", 3, 3}}), Error);
  for (const double peak : {0.0, -1.0, static_cast<double>(kNaN), static_cast<double>(kInf)}) {
    EXPECT_THROW((void)compare(a, a, kColour, {.peak = peak}), Error);
  }
}

TEST(Composited, OverABackground) {
  Image image(2, 1, {"R", "G", "B", "A"});
  image.pixels = {0.5f, 0.25f, 0, 0.5f, 1, 1, 1, 1};
  const Image over = composited(image, {1, 0.5, 0.25});
  EXPECT_THAT(std::vector<float>(over.pixels.begin(), over.pixels.end()),
              testing::ElementsAre(1.0f, 0.5f, 0.125f, 1, 1, 1, 1, 1));
  EXPECT_EQ(composited(image, {0, 0, 0}).pixels, image.pixels);
  Image grey(1, 1, {"Y", "A"});
  EXPECT_EQ(composited(grey, {0.5, 0.5, 0.5}).pixels[0], 0.5f);
  EXPECT_THROW((void)composited(grey, {0.5, 0.5, 0}), Error);
  EXPECT_THROW((void)colour_channels(Image(1, 1, {"depth"})), Error);
}

TEST(LargestValue, PassesOverInfinity) {
  Image image(3, 1, {"R", "depth"});
  image.pixels = {1, kInf, kNaN, 7, 3, 2};
  EXPECT_EQ(largest_value(image, {0}), 3);
  EXPECT_EQ(largest_value(image, {0, 1}), 7);
}

}  // namespace
}  // namespace vol::image
