#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "image/metrics.h"

namespace vol::image {

std::array<int, 3> colour_channels(const Image& image) {
  const auto r = image.channel("R");
  const auto g = image.channel("G");
  const auto b = image.channel("B");
  if (r && g && b) return {*r, *g, *b};
  if (const auto y = image.channel("Y")) return {*y, *y, *y};
  std::string names;
  for (const auto& name : image.channels) names += (names.empty() ? "" : ", ") + name;
  throw Error("neither R, G, B nor Y among its channels (" + names + ")");
}

Image composited(Image image, const std::array<double, 3>& background) {
  const auto alpha = image.channel("A");
  if (!alpha || (background[0] == 0 && background[1] == 0 && background[2] == 0)) return image;
  const auto colour = colour_channels(image);
  const bool grey = colour[0] == colour[1];
  if (grey && (background[0] != background[1] || background[0] != background[2])) {
    throw Error("a grey image over a coloured background");
  }
  parallel_for(0, image.height, 16, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < image.width; ++x) {
        float& a = image.at(x, y, *alpha);
        const double through = 1.0 - a;
        for (std::size_t c = 0; c < (grey ? 1u : 3u); ++c) {
          float& value = image.at(x, y, colour[c]);
          value = static_cast<float>(value + through * background[c]);
        }
        a = 1;
      }
    }
  });
  return image;
}

double largest_value(const Image& image, const std::vector<int>& channels) {
  return parallel_reduce<std::vector<double>>(
             0, image.height, 64,
             [&](std::int64_t begin, std::int64_t end) {
               double largest = -std::numeric_limits<double>::infinity();
               for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
                 for (int x = 0; x < image.width; ++x) {
                   for (const int c : channels) {
                     const double value = image.at(x, y, c);
                     if (std::isfinite(value)) largest = std::max(largest, value);
                   }
                 }
               }
               return std::vector<double>{largest};
             },
             [](std::vector<double>& total, const std::vector<double>& part) {
               if (total.empty() || part[0] > total[0]) total = part;
             })
      .at(0);
}

}  // namespace vol::image
