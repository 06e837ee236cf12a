#include "io/image.h"

#include <dlfcn.h>

#include <string_view>

#include "base/error.h"
#include "io/exr.h"
#include "io/file.h"
#include "io/oiio_module.h"

namespace vol::io {
namespace {

image::Image read_with_openimageio(const std::filesystem::path& path, CodeValues values) {
  // Never closed: its libraries register themselves in ways that do not survive being unloaded.
  static void* const module = ::dlopen(kOiioModule, RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) {
    throw Error(path.string() +
                ": neither OpenEXR nor PNG, and OpenImageIO cannot be loaded: " + ::dlerror());
  }
  const auto read = reinterpret_cast<ReadWithOpenImageIO>(::dlsym(module, kOiioEntry));
  if (read == nullptr)
    throw Error(path.string() + ": " + kOiioModule + " is not of this build: " + ::dlerror());
  image::Image image;
  read(path.c_str(), static_cast<int>(values), &image);
  return image;
}

}  // namespace

image::Image read_image(const std::filesystem::path& path, CodeValues values) {
  using namespace std::string_view_literals;
  InputFile file(path);
  const std::string_view magic = file.peek(8);
  if (magic.starts_with("\x76\x2f\x31\x01"sv)) return read_exr(file);
  if (magic == "\x89PNG\r\n\x1a\n"sv) return read_png(file, values);
  if (magic.empty()) throw Error(display_name(path) + ": empty, expected an image");
  if (is_standard_stream(path))
    throw Error("standard input: neither OpenEXR nor PNG; other formats are read from files only");
  return read_with_openimageio(path, values);
}

}  // namespace vol::io
