#pragma once
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/buffer.h"

namespace vol::image {

/// Float image with named channels, interleaved: pixels[(y width + x) channels.size() + c]; row 0 is the top.
/// Colour channels are named R, G, B, A: linear light, colour premultiplied by A. Data channels (`samples`,
/// `depth`, `error`) go by their own names.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;
  Buffer<float> pixels;
  std::map<std::string, std::string> attributes;

  Image() = default;
  /// All pixels zero. Throws vol::Error unless 1 <= width, height <= 65536 and there is a channel, and on an
  /// image that memory does not hold.
  Image(int width, int height, std::vector<std::string> channels);
  /// All pixels alike: `pixel` has a value a channel. Takes the memory of `spare`, an image that is no longer
  /// needed, where that is large enough: new memory costs more than what is written into it.
  Image(int width, int height, std::vector<std::string> channels, const std::vector<float>& pixel,
        Image spare);

  [[nodiscard]] std::optional<int> channel(std::string_view name) const;
  [[nodiscard]] float& at(int x, int y, int c) { return pixels[index(x, y, c)]; }
  [[nodiscard]] const float& at(int x, int y, int c) const { return pixels[index(x, y, c)]; }

 private:
  [[nodiscard]] std::size_t index(int x, int y, int c) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               channels.size() +
           static_cast<std::size_t>(c);
  }
};

}  // namespace vol::image
