#include "image/exposure.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace vol::image {

double exposure_to_white(const Image& picture) {
  float largest = 0;
  for (const char* name : {"R", "G", "B"}) {
    const auto channel = picture.channel(name);
    if (!channel) throw Error(std::string("a picture to be exposed has no channel ") + name);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const float value = picture.at(x, y, *channel);
        if (std::isfinite(value)) largest = std::max(largest, value);
      }
    }
  }
  return largest > 0 ? 1 / static_cast<double>(largest) : 1;
}

}  // namespace vol::image
