#include "image/image.h"

#include <new>
#include <stdexcept>

#include "base/error.h"

namespace vol::image {

Image::Image(int w, int h, std::vector<std::string> names) : width(w), height(h), channels(std::move(names)) {
  constexpr int kLargestSide = 65536;
  if (w < 1 || h < 1 || w > kLargestSide || h > kLargestSide) {
    throw Error("image size " + std::to_string(w) + "x" + std::to_string(h) +
                " is outside 1 to 65536 pixels a side");
  }
  if (channels.empty()) throw Error("image without channels");
  const std::size_t count = static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * channels.size();
  const auto too_large = [&] {
    return Error("an image of " + std::to_string(w) + "x" + std::to_string(h) + " pixels and " +
                 std::to_string(channels.size()) + " channels takes " +
                 std::to_string(count * sizeof(float) >> 20) +
                 " MiB, more memory than there is; make it smaller");
  };
  try {
    pixels.assign(count, 0.0f);
  } catch (const std::bad_alloc&) {
    throw too_large();
  } catch (const std::length_error&) {  // more than a pointer reaches
    throw too_large();
  }
}

std::optional<int> Image::channel(std::string_view name) const {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c] == name) return static_cast<int>(c);
  }
  return std::nullopt;
}

}  // namespace vol::image
