// libprecis_oiio.so: OpenImageIO behind one function, loaded by io/image.cpp when a picture is neither
// OpenEXR nor PNG. It calls nothing of the program's libraries (headers only), so that either side links
// alone.
#include "io/oiio_module.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"

namespace {

constexpr int kLargestSide = 65536;  // as vol::image::Image
constexpr int kLargestChannelCount = 1024;

/// Linear light of every code of an integer type (IEC 61966-2-1; io/png.cpp has it too, but lives on the
/// program's side): a table, since the power is slow and the codes are few.
std::vector<float> linear_codes(std::size_t largest) {
  std::vector<float> values(largest + 1);
  for (std::size_t n = 0; n <= largest; ++n) {
    const double s = static_cast<double>(n) / static_cast<double>(largest);
    values[n] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
  }
  return values;
}

void check_size(const std::string& path, const OIIO::ImageSpec& spec) {
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.width > kLargestSide ||
      spec.height > kLargestSide || spec.nchannels < 1 || spec.nchannels > kLargestChannelCount) {
    throw vol::Error(path + ": image of " + std::to_string(spec.width) + "x" + std::to_string(spec.height) +
                     "x" + std::to_string(spec.depth) + " pixels and " + std::to_string(spec.nchannels) +
                     " channels; expected 1 to 65536 pixels a side and 1 to 1024 channels");
  }
  // No still-image codec packs tighter than this by much; what promises more has not got it.
  constexpr std::uint64_t kDensest = 65536;
  std::error_code ignored;
  const std::uint64_t bytes = std::filesystem::file_size(path, ignored);
  if (!ignored && spec.image_bytes(true) / kDensest > bytes) {
    throw vol::Error(path + ": promises " + std::to_string(spec.width) + "x" + std::to_string(spec.height) +
                     " pixels, more than its " + std::to_string(bytes) + " bytes can hold");
  }
}

bool is_integer(const OIIO::ImageSpec& spec) {
  const auto base = static_cast<OIIO::TypeDesc::BASETYPE>(spec.format.basetype);
  return base == OIIO::TypeDesc::UINT8 || base == OIIO::TypeDesc::UINT16 || base == OIIO::TypeDesc::INT8 ||
         base == OIIO::TypeDesc::INT16 || base == OIIO::TypeDesc::UINT32 || base == OIIO::TypeDesc::INT32;
}

/// sRGB codes to linear light, then colour times alpha: in that order, which is why the file was asked for
/// unassociated alpha.
void convert(vol::image::Image& image, bool from_srgb, bool unassociated, int alpha) {
  const auto linear = linear_codes(65535);  // holds the 8-bit codes too: 65535 = 255 * 257
  const auto channels = image.channels.size();
  std::vector<bool> colour(channels);
  for (std::size_t c = 0; c < channels; ++c) {
    const auto& name = image.channels[c];
    colour[c] = name == "R" || name == "G" || name == "B" || name == "Y";
  }
  for (std::size_t p = 0; p < image.pixels.size(); p += channels) {
    for (std::size_t c = 0; c < channels; ++c) {
      if (!colour[c]) continue;
      float& value = image.pixels[p + c];
      if (from_srgb)
        value = linear[static_cast<std::size_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 65535))];
      if (unassociated) value *= image.pixels[p + static_cast<std::size_t>(alpha)];
    }
  }
}

}  // namespace

extern "C" __attribute__((visibility("default"))) void precis_read_with_openimageio(const char* path,
                                                                                    int values,
                                                                                    void* result) {
  const std::string name = path;
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  config["oiio:RawColor"] = 0;
  const auto complain = [&](const std::string& why) {
    std::string line = why.substr(0, why.find('\n'));
    throw vol::Error(name + ": not an image that OpenImageIO can read" + (line.empty() ? "" : ": " + line));
  };
  const auto file = OIIO::ImageInput::open(name, &config);
  if (!file) complain(OIIO::geterror());
  const OIIO::ImageSpec spec = file->spec();
  check_size(name, spec);

  vol::image::Image image;
  image.width = spec.width;
  image.height = spec.height;
  image.channels = spec.channelnames;
  if (spec.nchannels == 1) image.channels = {"Y"};
  if (spec.nchannels == 2 && spec.alpha_channel == 1) image.channels = {"Y", "A"};
  image.pixels =
      vol::Buffer<float>(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                         static_cast<std::size_t>(spec.nchannels));
  if (!file->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.pixels.data()))
    complain(file->geterror());

  const bool raw = values != 0;
  const bool unassociated =
      spec.alpha_channel >= 0 && spec.get_int_attribute("oiio:UnassociatedAlpha", 0) != 0;
  const bool from_srgb = is_integer(spec) && !raw;
  if (from_srgb || unassociated) convert(image, from_srgb, unassociated, spec.alpha_channel);
  for (const auto& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeDesc::STRING)
      image.attributes[attribute.name().string()] = attribute.get_string();
  }
  *static_cast<vol::image::Image*>(result) = std::move(image);
}
