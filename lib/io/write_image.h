#pragma once
#include <array>
#include <filesystem>
#include <string>

#include "image/image.h"

namespace vol::io {

/// Writes a picture as its extension says: `.exr` (all channels, float, linear) or `.png` (8-bit sRGB over
/// `background`, linear RGB, times `exposure`, for looking at). `format` ("exr" or "png") overrules the
/// extension; standard output, `-`, is EXR unless it says else. Throws vol::Error on another extension or
/// format.
void write_image(const std::filesystem::path& path, const image::Image& image, const std::string& format = "",
                 const std::array<double, 3>& background = {0, 0, 0}, double exposure = 1);

/// Throws what write_image would throw for the name alone: call it before the work, not after.
void require_image_format(const std::filesystem::path& path, const std::string& format = "");

}  // namespace vol::io
