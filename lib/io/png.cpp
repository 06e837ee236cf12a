#include "io/png.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "io/file.h"

// libpng reports errors by longjmp, which skips destructors: between setjmp and the jump only memory that
// lives outside the function is touched, and the C++ work (conversion, allocation) stands apart from it.
namespace vol::io {
namespace {

constexpr png_uint_32 kLargestSide = 65536;  // as image::Image
constexpr std::int64_t kLargestPipe = std::int64_t{1} << 33;

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto* text = static_cast<std::string*>(png_get_error_ptr(png));
  if (text->empty()) *text = message;
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

// ------------------------------------------------------------------------------------------------ writing

struct Encoded {
  int width;
  int height;
  int bits;
  std::vector<png_byte> codes;  // RGB rows, 16 bits in network order
};

struct ColourChannels {
  std::array<int, 3> colour;
  int alpha;  // -1: opaque
};

ColourChannels colour_channels(const image::Image& image) {
  const int alpha = image.channel("A").value_or(-1);
  const auto r = image.channel("R");
  const auto g = image.channel("G");
  const auto b = image.channel("B");
  if (r && g && b) return {{*r, *g, *b}, alpha};
  if (const auto y = image.channel("Y")) return {{*y, *y, *y}, alpha};
  throw Error("the image has neither channels R, G, B nor Y, which a PNG needs");
}

void put_code(png_byte* to, int bits, double linear) {
  const double largest = bits == 16 ? 65535.0 : 255.0;
  const auto code =
      static_cast<unsigned>(std::lround(largest * srgb_from_linear(std::clamp(linear, 0.0, 1.0))));
  if (bits == 16) *to++ = static_cast<png_byte>(code >> 8);
  *to = static_cast<png_byte>(code & 255u);
}

Encoded encode(const image::Image& image, const PngOptions& options) {
  if (options.bits != 8 && options.bits != 16)
    throw Error("PNG of " + std::to_string(options.bits) + " bits, expected 8 or 16");
  const ColourChannels channels = colour_channels(image);
  const std::size_t bytes = options.bits == 16 ? 2 : 1;
  const std::size_t row_bytes = static_cast<std::size_t>(image.width) * 3 * bytes;
  Encoded result{image.width, image.height, options.bits, {}};
  result.codes.resize(row_bytes * static_cast<std::size_t>(image.height));
  parallel_for(0, image.height, 16, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      png_byte* to = result.codes.data() + row_bytes * static_cast<std::size_t>(y);
      for (int x = 0; x < image.width; ++x) {
        std::array<double, 3> rgb{};
        bool missing = false;
        for (std::size_t c = 0; c < 3; ++c) {
          rgb[c] = image.at(x, y, channels.colour[c]);
          if (channels.alpha >= 0 && options.background[c] != 0)
            rgb[c] += (1 - image.at(x, y, channels.alpha)) * options.background[c];
          rgb[c] *= options.scale;
          missing = missing || std::isnan(rgb[c]);
        }
        if (missing) rgb = {1, 0, 1};
        for (std::size_t c = 0; c < 3; ++c, to += bytes) put_code(to, options.bits, rgb[c]);
      }
    }
  });
  return result;
}

void append(png_structp png, png_bytep data, png_size_t n) {
  auto* bytes = static_cast<std::vector<png_byte>*>(png_get_io_ptr(png));
  bytes->insert(bytes->end(), data, data + n);
}

void flush(png_structp) {}

/// False where libpng gave up; its reason then stands in `message`.
bool compress(const Encoded& image, std::vector<png_text>& texts, std::vector<png_const_bytep>& rows,
              std::vector<png_byte>& file, std::string& message) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &message, &on_error, &on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &file, &append, &flush);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height),
               image.bits, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  if (!texts.empty()) png_set_text(png, info, texts.data(), static_cast<int>(texts.size()));
  png_write_info(png, info);
  png_write_image(png, const_cast<png_bytepp>(rows.data()));
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

// ------------------------------------------------------------------------------------------------ reading

struct Decoder {
  std::string message;
  const std::byte* at = nullptr;
  std::size_t left = 0;
  png_structp png = nullptr;
  png_infop info = nullptr;
  png_uint_32 width = 0;
  png_uint_32 height = 0;
  std::size_t stored_row_bytes = 0;  // as in the file, before anything is widened
  int bits = 0;
  int channels = 0;
  std::vector<png_byte> codes;
  std::vector<png_bytep> rows;
  Decoder() = default;
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
};

void take(png_structp png, png_bytep to, png_size_t n) {
  auto* decoder = static_cast<Decoder*>(png_get_io_ptr(png));
  if (n > decoder->left) png_error(png, "the file ends early");
  std::memcpy(to, decoder->at, n);
  decoder->at += n;
  decoder->left -= n;
}

bool read_header(Decoder& d) {
  d.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &d.message, &on_error, &on_warning);
  d.info = d.png != nullptr ? png_create_info_struct(d.png) : nullptr;
  if (d.info == nullptr || setjmp(png_jmpbuf(d.png)) != 0) return false;
  png_set_read_fn(d.png, &d, &take);
  png_set_user_limits(d.png, kLargestSide, kLargestSide);
  png_set_chunk_malloc_max(d.png, 1 << 24);
  png_read_info(d.png, d.info);
  d.stored_row_bytes = png_get_rowbytes(d.png, d.info);
  png_set_expand(d.png);
  png_set_gray_to_rgb(d.png);
  if constexpr (std::endian::native == std::endian::little) png_set_swap(d.png);
  (void)png_set_interlace_handling(d.png);
  png_read_update_info(d.png, d.info);
  d.width = png_get_image_width(d.png, d.info);
  d.height = png_get_image_height(d.png, d.info);
  d.bits = png_get_bit_depth(d.png, d.info);
  d.channels = png_get_channels(d.png, d.info);
  return true;
}

bool read_rows(Decoder& d) {
  if (setjmp(png_jmpbuf(d.png)) != 0) return false;
  png_read_image(d.png, d.rows.data());
  png_read_end(d.png, d.info);
  return true;
}

/// libpng takes memory for a chunk of text on its header's word: the lengths are held against the file first.
void check_chunks(std::span<const std::byte> file, const std::string& name) {
  const auto byte = [&](std::size_t at) { return static_cast<std::size_t>(file[at]); };
  for (std::size_t at = 8; at + 8 <= file.size();) {  // length, type, data, checksum
    const std::size_t length = byte(at) << 24 | byte(at + 1) << 16 | byte(at + 2) << 8 | byte(at + 3);
    if (length + 12 > file.size() - at) {
      throw Error(name + ": damaged PNG file: a chunk of " + std::to_string(length) + " bytes, " +
                  std::to_string(file.size() - at - 8) + " bytes before the end");
    }
    if (std::memcmp(&file[at + 4], "IEND", 4) == 0) return;
    at += length + 12;
  }
}

image::Image to_image(const Decoder& d, CodeValues values) {
  const int alpha = d.channels == 4 ? 3 : -1;
  image::Image image(
      static_cast<int>(d.width), static_cast<int>(d.height),
      alpha < 0 ? std::vector<std::string>{"R", "G", "B"} : std::vector<std::string>{"R", "G", "B", "A"});
  const std::size_t codes = d.bits == 16 ? 65536 : 256;
  std::vector<float> value(codes);
  for (std::size_t n = 0; n < codes; ++n) {
    const double code = static_cast<double>(n) / static_cast<double>(codes - 1);
    value[n] = static_cast<float>(values == CodeValues::raw ? code : linear_from_srgb(code));
  }
  const auto per_row = static_cast<std::size_t>(d.width) * static_cast<std::size_t>(d.channels);
  parallel_for(0, image.height, 16, [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<std::size_t>(begin); y < static_cast<std::size_t>(end); ++y) {
      const png_byte* row = d.rows[y];
      float* to = image.pixels.data() + y * per_row;
      for (std::size_t n = 0; n < per_row; ++n) {
        std::uint16_t code = row[n];
        if (d.bits == 16) std::memcpy(&code, row + 2 * n, 2);
        const bool is_alpha = alpha >= 0 && n % 4 == 3;
        to[n] = is_alpha ? static_cast<float>(code) / static_cast<float>(codes - 1) : value[code];
      }
      if (alpha < 0) continue;
      for (std::size_t n = 0; n < per_row; n += 4) {
        for (std::size_t c = 0; c < 3; ++c) to[n + c] *= to[n + 3];
      }
    }
  });
  png_textp texts = nullptr;
  const int count = png_get_text(d.png, d.info, &texts, nullptr);
  for (int n = 0; n < count; ++n)
    image.attributes[texts[n].key] = texts[n].text != nullptr ? texts[n].text : "";
  return image;
}

}  // namespace

double srgb_from_linear(double linear) {
  if (linear < 0) return -srgb_from_linear(-linear);
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double linear_from_srgb(double srgb) {
  if (srgb < 0) return -linear_from_srgb(-srgb);
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

void write_png(const std::filesystem::path& path, const image::Image& image, const PngOptions& options) {
  OutputFile out(path);
  const std::string name = output_name(path);
  Encoded encoded;
  try {
    encoded = encode(image, options);
  } catch (const Error& cause) {
    throw Error(name, cause);
  }
  std::vector<png_const_bytep> rows(static_cast<std::size_t>(encoded.height));
  for (std::size_t y = 0; y < rows.size(); ++y)
    rows[y] = encoded.codes.data() + y * (encoded.codes.size() / rows.size());

  // Texts are UTF-8 (iTXt); libpng reads them only.
  std::vector<png_text> texts;
  for (const auto& [key, value] : image.attributes) {
    if (key.empty() || key.size() > 79)
      throw Error(name + ": attribute name of " + std::to_string(key.size()) +
                  " characters, expected 1 to 79");
    png_text text{};
    text.compression = PNG_ITXT_COMPRESSION_NONE;
    text.key = const_cast<char*>(key.c_str());
    text.text = const_cast<char*>(value.c_str());
    text.itxt_length = value.size();
    texts.push_back(text);
  }
  std::vector<png_byte> file;
  std::string message;
  if (!compress(encoded, texts, rows, file, message)) throw Error(name + ": cannot write PNG: " + message);
  out.write(file.data(), file.size());
  out.commit();
}

image::Image decode_png(std::span<const std::byte> file, const std::string& name, CodeValues values) {
  if (file.size() < 8 || png_sig_cmp(reinterpret_cast<png_const_bytep>(file.data()), 0, 8) != 0) {
    throw Error(name + ": not a PNG file");
  }
  check_chunks(file, name);
  Decoder d;
  d.at = file.data();
  d.left = file.size();
  if (!read_header(d)) throw Error(name + ": damaged PNG file: " + d.message);
  const std::size_t row_bytes = png_get_rowbytes(d.png, d.info);
  if (d.stored_row_bytes * d.height / 1032 > file.size()) {  // deflate packs at most 1032 to 1
    throw Error(name + ": promises " + std::to_string(d.width) + "x" + std::to_string(d.height) +
                " pixels, more than its " + std::to_string(file.size()) + " bytes can hold");
  }
  d.codes.resize(row_bytes * d.height);
  d.rows.resize(d.height);
  for (std::size_t y = 0; y < d.height; ++y) d.rows[y] = d.codes.data() + y * row_bytes;
  if (!read_rows(d)) throw Error(name + ": damaged PNG file: " + d.message);
  return to_image(d, values);
}

image::Image read_png(InputFile& file, CodeValues values) {
  if (file.size() >= 0 && file.size() - file.position() > kLargestPipe)
    throw Error(display_name(file.path()) + ": too large for a PNG");
  const auto bytes = file.read_rest(kLargestPipe);
  return decode_png(bytes, display_name(file.path()), values);
}

image::Image read_png(const std::filesystem::path& path, CodeValues values) {
  InputFile file(path);
  return read_png(file, values);
}

}  // namespace vol::io
