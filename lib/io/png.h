#pragma once
#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "image/image.h"

namespace vol::io {

class InputFile;

/// The sRGB transfer function (IEC 61966-2-1), extended as an odd function below zero, so that out-of-range
/// values survive a round trip:  s = 12.92 l  for l <= 0.0031308, else  1.055 l^(1/2.4) - 0.055.
[[nodiscard]] double srgb_from_linear(double linear);
/// Its inverse:  l = s / 12.92  for s <= 0.04045, else  ((s + 0.055) / 1.055)^2.4.
[[nodiscard]] double linear_from_srgb(double srgb);

struct PngOptions {
  std::array<double, 3> background{0, 0, 0};  ///< linear RGB under what is transparent
  double scale = 1;                           ///< linear values are multiplied by this first: the exposure
  int bits = 8;                               ///< a channel: 8 or 16
};

/// Writes an image for looking at: (C + (1 - A) background) scale, clamped to [0, 1], as sRGB, rounded to the
/// nearest code; RGB without alpha. Grey (Y) goes in as equal R, G, B; other channels are left out. NaN comes
/// out magenta. The attributes go in as text; no date. `-` is standard output. The file appears whole or not
/// at all. Throws vol::Error where the image has neither R, G, B nor Y.
void write_png(const std::filesystem::path& path, const image::Image& image, const PngOptions& options = {});

/// How display-referred code values become numbers.
enum class CodeValues {
  srgb,  ///< linear light, by the sRGB transfer function
  raw    ///< code / largest code, taken as linear
};

/// Reads 8- and 16-bit PNG: R, G, B and, where there is transparency, A, by which the
/// colour is then multiplied. Grey comes as equal R, G, B. Code
/// values are sRGB whatever gAMA or iCCP say, as viewers without colour management show them. `-` is standard
/// input. Sizes are checked against the file's before memory is taken. Throws vol::Error naming the file.
[[nodiscard]] image::Image read_png(const std::filesystem::path& path, CodeValues values = CodeValues::srgb);
[[nodiscard]] image::Image read_png(InputFile& file, CodeValues values = CodeValues::srgb);
/// The same of a file already in memory; `name` is what messages call it.
[[nodiscard]] image::Image decode_png(std::span<const std::byte> file, const std::string& name,
                                      CodeValues values = CodeValues::srgb);

}  // namespace vol::io
