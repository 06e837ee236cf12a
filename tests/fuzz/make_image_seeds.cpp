// make_image_seeds FOLDER: small good pictures for the fuzzers to start from.
#include <filesystem>

#include "io/exr.h"
#include "io/png.h"

int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : "seeds";
  for (const char* reader : {"exr", "png"}) std::filesystem::create_directories(folder / reader);
  vol::image::Image image(7, 5, {"R", "G", "B", "A", "depth"});
  for (std::size_t n = 0; n < image.pixels.size(); ++n) image.pixels[n] = static_cast<float>(n % 13) / 12;
  image.attributes["precis.tool"] = "seed";
  vol::io::write_exr(folder / "exr/colour.exr", image);
  vol::io::write_exr(folder / "exr/grey.exr", vol::image::Image(40, 40, {"Y"}));
  vol::io::write_png(folder / "png/8.png", image);
  vol::io::write_png(folder / "png/16.png", image, {.bits = 16});
}
