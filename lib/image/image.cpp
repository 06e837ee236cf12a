#include "image/image.h"

#include <algorithm>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"

namespace vol::image {

Image::Image(int w, int h, std::vector<std::string> names)
    : Image(w, h, names, std::vector<float>(names.size()), Image()) {}

Image::Image(int w, int h, std::vector<std::string> names, const std::vector<float>& pixel, Image spare)
    : width(w), height(h), channels(std::move(names)), pixels(std::move(spare.pixels)) {
  constexpr int kLargestSide = 65536;
  if (w < 1 || h < 1 || w > kLargestSide || h > kLargestSide) {
    throw Error("image size " + std::to_string(w) + "x" + std::to_string(h) +
                " is outside 1 to 65536 pixels a side");
  }
  if (channels.empty()) throw Error("image without channels");
  if (pixel.size() != channels.size()) throw Error("image: a value a channel is expected");
  const std::size_t across = static_cast<std::size_t>(w) * channels.size();
  const std::size_t count = across * static_cast<std::size_t>(h);
  const auto too_large = [&] {
    return Error("an image of " + std::to_string(w) + "x" + std::to_string(h) + " pixels and " +
                 std::to_string(channels.size()) + " channels takes " +
                 std::to_string(count * sizeof(float) >> 20) +
                 " MiB, more memory than there is; make it smaller");
  };
  try {
    pixels.clear();  // nothing of it is copied
    pixels.resize(count);
  } catch (const std::bad_alloc&) {
    throw too_large();
  } catch (const std::length_error&) {  // more than a pointer reaches
    throw too_large();
  }
  std::vector<float> row;
  row.reserve(across);
  while (row.size() < across) row.insert(row.end(), pixel.begin(), pixel.end());
  parallel_for(0, h, 32, [&](std::int64_t top, std::int64_t bottom) {
    for (auto y = static_cast<std::size_t>(top); y < static_cast<std::size_t>(bottom); ++y) {
      std::copy(row.begin(), row.end(), pixels.begin() + static_cast<std::ptrdiff_t>(y * across));
    }
  });
}

std::optional<int> Image::channel(std::string_view name) const {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c] == name) return static_cast<int>(c);
  }
  return std::nullopt;
}

}  // namespace vol::image
