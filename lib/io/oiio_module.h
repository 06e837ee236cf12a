#pragma once

namespace vol::io {

/// The one entry of libprecis_oiio.so, found by dlsym: reads `path` as io::read_image promises. `values` is a
/// CodeValues. Throws vol::Error.
using ReadWithOpenImageIO = void (*)(const char* path, int values, void* image);
inline constexpr const char* kOiioModule = "libprecis_oiio.so";
inline constexpr const char* kOiioEntry = "precis_read_with_openimageio";

}  // namespace vol::io
