#include "image/difference.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::image {
namespace {

constexpr std::size_t kColours = 9;
using Rgb = std::array<double, 3>;
using ColourMap = std::array<Rgb, kColours>;  // sRGB codes at equal distances

constexpr ColourMap kSequential{{{0, 0, 4},
                                 {31, 12, 72},
                                 {85, 15, 109},
                                 {136, 34, 106},
                                 {186, 54, 85},
                                 {227, 89, 51},
                                 {249, 140, 10},
                                 {249, 201, 50},
                                 {252, 255, 164}}};
constexpr ColourMap kDiverging{{{33, 102, 172},
                                {67, 147, 195},
                                {146, 197, 222},
                                {209, 229, 240},
                                {247, 247, 247},
                                {253, 219, 199},
                                {244, 165, 130},
                                {214, 96, 77},
                                {178, 24, 43}}};

/// sRGB code to linear light (IEC 61966-2-1).
double linear(double code) {
  const double s = code / 255;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// Colour at u in [0, 1], linear between the points in sRGB, where they are evenly spaced to the eye.
Rgb colour_at(const ColourMap& map, double u) {
  const double place = std::clamp(u, 0.0, 1.0) * (kColours - 1);
  const std::size_t n = std::min(static_cast<std::size_t>(place), kColours - 2);
  const double t = place - static_cast<double>(n);
  Rgb rgb{};
  for (std::size_t c = 0; c < 3; ++c) rgb[c] = linear((1 - t) * map[n][c] + t * map[n + 1][c]);
  return rgb;
}

}  // namespace

Image difference(const Image& tested, const Image& reference, const std::vector<ChannelPair>& channels,
                 DifferenceKind kind) {
  if (tested.width != reference.width || tested.height != reference.height)
    throw Error("difference of images of different size");
  std::vector<std::string> names;
  for (const auto& pair : channels) names.push_back(pair.name);
  Image result(tested.width, tested.height, std::move(names));
  parallel_for(0, result.height, 16, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < result.width; ++x) {
        for (std::size_t c = 0; c < channels.size(); ++c) {
          const float t = tested.at(x, y, channels[c].tested);
          const float r = reference.at(x, y, channels[c].reference);
          const float d = t == r ? 0.0f : t - r;
          result.at(x, y, static_cast<int>(c)) = kind == DifferenceKind::absolute ? std::abs(d) : d;
        }
      }
    }
  });
  return result;
}

double largest_magnitude(const Image& difference) {
  double largest = 0;
  for (const float value : difference.pixels) {
    if (std::isfinite(value)) largest = std::max(largest, std::abs(static_cast<double>(value)));
  }
  return largest;
}

Image false_colour(const Image& difference, double scale, DifferenceKind kind) {
  if (!(scale > 0) || !std::isfinite(scale))
    throw Error("difference scale " + std::to_string(scale) + ": expected a positive number");
  Image result(difference.width, difference.height, {"R", "G", "B"});
  const std::size_t channels = difference.channels.size();
  parallel_for(0, result.height, 16, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < result.width; ++x) {
        double shown = 0;
        for (std::size_t c = 0; c < channels && !std::isnan(shown); ++c) {
          const double d = difference.at(x, y, static_cast<int>(c));
          if (std::isnan(d) || std::abs(d) > std::abs(shown)) shown = d;
        }
        Rgb rgb{0, 1, 0};
        if (!std::isnan(shown)) {
          rgb = kind == DifferenceKind::absolute
                    ? colour_at(kSequential, shown / scale)
                    : colour_at(kDiverging, 0.5 + 0.5 * std::clamp(shown / scale, -1.0, 1.0));
        }
        for (std::size_t c = 0; c < 3; ++c) result.at(x, y, static_cast<int>(c)) = static_cast<float>(rgb[c]);
      }
    }
  });
  return result;
}

ChannelInColours channel_in_false_colours(const Image& picture, const std::string& channel) {
  const auto from = picture.channel(channel);
  if (!from) throw Error("the picture has no channel " + channel);
  Image values(picture.width, picture.height, {channel});
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) values.at(x, y, 0) = picture.at(x, y, *from);
  }
  const double largest = largest_magnitude(values);
  ChannelInColours shown{false_colour(values, largest > 0 ? largest : 1, DifferenceKind::absolute), largest};
  shown.image.attributes = picture.attributes;
  return shown;
}

}  // namespace vol::image
