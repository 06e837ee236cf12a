#pragma once
#include <filesystem>

#include "image/image.h"
#include "io/png.h"

namespace vol::io {

/// Reads a picture of any format OpenImageIO knows (OpenEXR, PNG, TIFF, JPEG, Radiance HDR ...), told by its
/// contents; `-` is standard input, for OpenEXR and PNG.
///
/// Result: linear light, colour premultiplied by alpha. OpenEXR and other floating-point files are taken as
/// linear, as they stand; integer files (PNG, 8- and 16-bit TIFF, JPEG) as sRGB and converted, or, with
/// CodeValues::raw, as linear code / largest code.
///
/// OpenEXR and PNG go through our own readers. Everything else is read by OpenImageIO, which is loaded only
/// then (libprecis_oiio.so, found by the program's run path): it brings 262 shared libraries and takes a
/// quarter of a second to start. Throws vol::Error naming the file.
[[nodiscard]] image::Image read_image(const std::filesystem::path& path,
                                      CodeValues values = CodeValues::srgb);

}  // namespace vol::io
