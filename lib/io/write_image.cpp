#include "io/write_image.h"

#include "base/error.h"
#include "io/exr.h"
#include "io/file.h"
#include "io/png.h"

namespace vol::io {
namespace {

std::string format_of(const std::filesystem::path& path, const std::string& format) {
  if (!format.empty()) {
    if (format != "exr" && format != "png")
      throw Error("image format " + format + " is unknown, expected exr or png");
    return format;
  }
  if (is_standard_stream(path)) return "exr";
  const std::string extension = path.extension().string();
  if (extension == ".exr" || extension == ".png") return extension.substr(1);
  throw Error(path.string() + ": images are written as .exr or .png; rename it or give --format");
}

}  // namespace

void require_image_format(const std::filesystem::path& path, const std::string& format) {
  (void)format_of(path, format);
  require_writable(path);
}

void write_image(const std::filesystem::path& path, const image::Image& image, const std::string& format,
                 const std::array<double, 3>& background, double exposure) {
  if (format_of(path, format) == "exr") {
    write_exr(path, image);
  } else {
    write_png(path, image, {.background = background, .scale = exposure});
  }
}

}  // namespace vol::io
