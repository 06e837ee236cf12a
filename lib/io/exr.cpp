#include "io/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>
#include <OpenEXR/openexr.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <mutex>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "io/file.h"

// Reading goes through OpenEXR's C core, which decodes chunks from any thread into any layout: rows land
// interleaved and widened in our image without a copy in between. Writing goes through the C++ interface.
namespace vol::io {
namespace {

constexpr int kLargestSide = 65536;  // as image::Image
constexpr int kLargestChannelCount = 1024;
constexpr std::int64_t kLargestPipe = std::int64_t{1} << 33;

// ------------------------------------------------------------------------------------------------ reading

struct Source {
  std::span<const std::byte> bytes;
  std::mutex mutex;
  std::string message;  // the library's first complaint
};

std::int64_t read_source(exr_const_context_t, void* user, void* to, std::uint64_t n, std::uint64_t offset,
                         exr_stream_error_func_ptr_t) {
  const auto& bytes = static_cast<const Source*>(user)->bytes;
  if (offset >= bytes.size()) return 0;
  const std::size_t got = std::min<std::size_t>(n, bytes.size() - offset);
  std::memcpy(to, bytes.data() + offset, got);
  return static_cast<std::int64_t>(got);
}

std::int64_t source_size(exr_const_context_t, void* user) {
  return static_cast<std::int64_t>(static_cast<const Source*>(user)->bytes.size());
}

void keep_message(exr_const_context_t context, exr_result_t, const char* message) {
  void* user = nullptr;
  if (context == nullptr || exr_get_user_data(context, &user) != EXR_ERR_SUCCESS || user == nullptr) return;
  auto& source = *static_cast<Source*>(user);
  const std::lock_guard lock(source.mutex);
  if (source.message.empty() && message != nullptr) source.message = message;
}

/// One line of plain text from a library's message.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text;
}

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, const std::string& name) : name_(name) {
    constexpr std::array<unsigned char, 4> magic{0x76, 0x2f, 0x31, 0x01};
    if (bytes.size() < magic.size() || std::memcmp(bytes.data(), magic.data(), magic.size()) != 0) {
      throw Error(name_ + ": not an OpenEXR file");
    }
    source_.bytes = bytes;
    exr_context_initializer_t setup{};
    setup.size = sizeof setup;
    setup.error_handler_fn = &keep_message;
    setup.user_data = &source_;
    setup.read_fn = &read_source;
    setup.size_fn = &source_size;
    setup.max_image_width = setup.max_image_height = kLargestSide;
    setup.max_tile_width = setup.max_tile_height = kLargestSide;
    setup.zip_level = -1;
    setup.dwa_quality = -1;
    setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    check(exr_start_read(&context_, name.c_str(), &setup));
  }
  ~Reader() { exr_finish(&context_); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  image::Image read() {
    check_layout();
    image::Image image = allocate();
    read_attributes(image);
    if (tiled_) {
      read_tiles(image);
    } else {
      read_scan_lines(image);
    }
    convert_integers(image);
    return image;
  }

 private:
  std::string name_;
  Source source_;
  exr_context_t context_ = nullptr;
  bool tiled_ = false;
  exr_attr_box2i_t window_{};
  std::vector<std::string> file_channels_;  // in the file's order
  std::vector<std::uint16_t> types_;        // their pixel types
  std::vector<int> position_;               // channel of the image that each goes to

  void check(exr_result_t result) {
    if (result == EXR_ERR_SUCCESS) return;
    const std::lock_guard lock(source_.mutex);
    const char* known = exr_get_default_error_message(result);
    throw Error(name_ + ": damaged or unsupported OpenEXR file: " +
                one_line(source_.message.empty() ? known : source_.message));
  }

  void check_layout() {
    int parts = 0;
    check(exr_get_count(context_, &parts));
    if (parts != 1) {
      throw Error(name_ + ": holds " + std::to_string(parts) +
                  " parts, expected one; take one out with oiiotool --subimage");
    }
    exr_storage_t storage{};
    check(exr_get_storage(context_, 0, &storage));
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) {
      throw Error(name_ + ": holds deep data, expected a flat image; flatten it with oiiotool --flatten");
    }
    tiled_ = storage == EXR_STORAGE_TILED;

    exr_attr_box2i_t display{};
    check(exr_get_data_window(context_, 0, &window_));
    check(exr_get_display_window(context_, 0, &display));
    if (std::memcmp(&window_, &display, sizeof display) != 0) {
      throw Error(name_ +
                  ": its data window is not its display window; pad or crop it with oiiotool --fullpixels or "
                  "--croptofull");
    }
    const exr_attr_chlist_t* list = nullptr;
    check(exr_get_channels(context_, 0, &list));
    if (list->num_channels < 1 || list->num_channels > kLargestChannelCount) {
      throw Error(name_ + ": holds " + std::to_string(list->num_channels) + " channels, expected 1 to " +
                  std::to_string(kLargestChannelCount));
    }
    for (int c = 0; c < list->num_channels; ++c) {
      const auto& entry = list->entries[c];
      file_channels_.emplace_back(entry.name.str, static_cast<std::size_t>(entry.name.length));
      types_.push_back(static_cast<std::uint16_t>(entry.pixel_type));
      if (entry.x_sampling != 1 || entry.y_sampling != 1) {
        throw Error(name_ + ": channel " + file_channels_.back() +
                    " is subsampled, expected one value a pixel");
      }
    }
  }

  image::Image allocate() {
    const std::int64_t width = std::int64_t{window_.max.x} - window_.min.x + 1;
    const std::int64_t height = std::int64_t{window_.max.y} - window_.min.y + 1;
    if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
      throw Error(name_ + ": image size " + std::to_string(width) + "x" + std::to_string(height) +
                  " is outside 1 to 65536 pixels a side");
    }
    // No compression but DWA packs tighter than deflate, 1032 to 1; a constant image in DWA can reach some
    // 10^4.
    exr_compression_t compression{};
    check(exr_get_compression(context_, 0, &compression));
    const bool dwa = compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB;
    const std::int64_t ratio = compression == EXR_COMPRESSION_NONE ? 1 : dwa ? 20000 : 1100;
    std::int64_t bytes_per_pixel = 0;
    for (const auto type : types_) bytes_per_pixel += type == EXR_PIXEL_HALF ? 2 : 4;
    const std::int64_t needed = width * height * bytes_per_pixel;
    const auto have = static_cast<std::int64_t>(source_.bytes.size());
    if (needed / ratio > have) {
      throw Error(name_ + ": promises " + std::to_string(width) + "x" + std::to_string(height) +
                  " pixels of " + std::to_string(types_.size()) + " channels, more than its " +
                  std::to_string(have) + " bytes can hold");
    }

    std::vector<std::string> names;
    for (const char* colour : {"R", "G", "B", "A"}) {
      if (std::find(file_channels_.begin(), file_channels_.end(), colour) != file_channels_.end())
        names.emplace_back(colour);
    }
    for (const auto& channel : file_channels_) {
      if (std::find(names.begin(), names.end(), channel) == names.end()) names.push_back(channel);
    }
    if (names.size() != file_channels_.size()) throw Error(name_ + ": two channels have the same name");
    for (const auto& channel : file_channels_) {
      position_.push_back(static_cast<int>(std::find(names.begin(), names.end(), channel) - names.begin()));
    }
    image::Image image;  // its pixels are about to be overwritten, so not zeroed first
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    image.channels = std::move(names);
    image.pixels = Buffer<float>(static_cast<std::size_t>(width * height) * image.channels.size());
    return image;
  }

  void read_attributes(image::Image& image) {
    std::int32_t count = 0;
    check(exr_get_attribute_count(context_, 0, &count));
    for (std::int32_t n = 0; n < count; ++n) {
      const exr_attribute_t* attribute = nullptr;
      check(exr_get_attribute_by_index(context_, 0, EXR_ATTR_LIST_FILE_ORDER, n, &attribute));
      if (attribute->type != EXR_ATTR_STRING || attribute->string == nullptr) continue;
      const auto& text = *attribute->string;
      image.attributes[attribute->name] =
          text.str ? std::string(text.str, static_cast<std::size_t>(text.length)) : "";
    }
  }

  /// Decodes one chunk to its place; the pipeline keeps its buffers from chunk to chunk.
  void decode(image::Image& image, exr_decode_pipeline_t& pipeline, const exr_chunk_info_t& chunk, int x,
              int y) {
    const bool first = pipeline.channels == nullptr;
    check(first ? exr_decoding_initialize(context_, 0, &chunk, &pipeline)
                : exr_decoding_update(context_, 0, &chunk, &pipeline));
    if (x < 0 || y < 0 || chunk.width < 1 || chunk.height < 1 || chunk.width > image.width - x ||
        chunk.height > image.height - y || pipeline.channel_count != static_cast<int>(position_.size())) {
      throw Error(name_ + ": damaged OpenEXR file: a block of pixels lies outside the image");
    }
    const std::size_t pixel_bytes = image.channels.size() * sizeof(float);
    for (int c = 0; c < pipeline.channel_count; ++c) {
      auto& channel = pipeline.channels[c];
      channel.decode_to_ptr =
          reinterpret_cast<std::uint8_t*>(&image.at(x, y, position_[static_cast<std::size_t>(c)]));
      channel.user_bytes_per_element = sizeof(float);
      channel.user_data_type = channel.data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
      channel.user_pixel_stride = static_cast<std::int32_t>(pixel_bytes);
      channel.user_line_stride =
          static_cast<std::int32_t>(pixel_bytes * static_cast<std::size_t>(image.width));
    }
    if (first) check(exr_decoding_choose_default_routines(context_, 0, &pipeline));
    check(exr_decoding_run(context_, 0, &pipeline));
  }

  struct Pipeline {
    exr_const_context_t context;
    exr_decode_pipeline_t state{};
    explicit Pipeline(exr_const_context_t c) : context(c) {}
    ~Pipeline() { exr_decoding_destroy(context, &state); }
    Pipeline(const Pipeline&) = delete;
    Pipeline& operator=(const Pipeline&) = delete;
  };

  void read_scan_lines(image::Image& image) {
    std::int32_t lines = 0;
    check(exr_get_scanlines_per_chunk(context_, 0, &lines));
    if (lines < 1) throw Error(name_ + ": damaged OpenEXR file: blocks without scan lines");
    const std::int64_t chunks = (std::int64_t{image.height} + lines - 1) / lines;
    parallel_for(0, chunks, 8, [&](std::int64_t begin, std::int64_t end) {
      Pipeline pipeline(context_);
      for (std::int64_t n = begin; n < end; ++n) {
        const int y = static_cast<int>(n) * lines;
        exr_chunk_info_t chunk{};
        check(exr_read_scanline_chunk_info(context_, 0, window_.min.y + y, &chunk));
        decode(image, pipeline.state, chunk, 0, chunk.start_y - window_.min.y);
      }
    });
  }

  void read_tiles(image::Image& image) {
    std::int32_t tile_width = 0;
    std::int32_t tile_height = 0;
    check(exr_get_tile_sizes(context_, 0, 0, 0, &tile_width, &tile_height));
    if (tile_width < 1 || tile_height < 1) throw Error(name_ + ": damaged OpenEXR file: empty tiles");
    const std::int64_t columns = (std::int64_t{image.width} + tile_width - 1) / tile_width;
    const std::int64_t rows = (std::int64_t{image.height} + tile_height - 1) / tile_height;
    parallel_for(0, rows, 1, [&](std::int64_t begin, std::int64_t end) {
      Pipeline pipeline(context_);
      for (std::int64_t row = begin; row < end; ++row) {
        for (std::int64_t column = 0; column < columns; ++column) {
          exr_chunk_info_t chunk{};
          check(exr_read_tile_chunk_info(context_, 0, static_cast<int>(column), static_cast<int>(row), 0, 0,
                                         &chunk));
          decode(image, pipeline.state, chunk, static_cast<int>(column) * tile_width,
                 static_cast<int>(row) * tile_height);
        }
      }
    });
  }

  /// UINT channels were stored as their bits; now as numbers.
  void convert_integers(image::Image& image) {
    for (std::size_t c = 0; c < types_.size(); ++c) {
      if (types_[c] != EXR_PIXEL_UINT) continue;
      const auto stride = image.channels.size();
      for (auto n = static_cast<std::size_t>(position_[c]); n < image.pixels.size(); n += stride) {
        const auto integer = std::bit_cast<std::uint32_t>(image.pixels[n]);
        image.pixels[n] = static_cast<float>(integer);
        if (static_cast<double>(image.pixels[n]) != integer) {
          throw Error(name_ + ": channel " + file_channels_[c] + " holds the integer " +
                      std::to_string(integer) + ", which float cannot hold");
        }
      }
    }
  }
};

// ------------------------------------------------------------------------------------------------ writing

/// Memory that OpenEXR writes to: it goes back to fill in its table of offsets, which a pipe cannot.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : Imf::OStream("memory") {}
  void write(const char* data, int n) override {
    const std::size_t end = position_ + static_cast<std::size_t>(n);
    if (end > bytes_.size()) bytes_.resize(end);
    std::memcpy(bytes_.data() + position_, data, static_cast<std::size_t>(n));
    position_ = end;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t to) override { position_ = to; }
  [[nodiscard]] std::vector<char> take() { return std::move(bytes_); }

 private:
  std::vector<char> bytes_;
  std::size_t position_ = 0;
};

std::vector<char> encode(const image::Image& image) {
  if (image.width < 1 || image.height < 1 || image.channels.empty()) throw Error("the image is empty");
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  const std::size_t pixel_bytes = image.channels.size() * sizeof(float);
  for (std::size_t c = 0; c < image.channels.size(); ++c) {
    const std::string& name = image.channels[c];
    if (name.empty() || name.size() > 255)
      throw Error("channel name of " + std::to_string(name.size()) + " characters, expected 1 to 255");
    if (header.channels().findChannel(name) != nullptr) throw Error("two channels are named " + name);
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    // OpenEXR takes the slice for reading only, though its type says otherwise.
    auto* base = const_cast<char*>(reinterpret_cast<const char*>(image.pixels.data() + c));
    frame.insert(
        name, Imf::Slice(Imf::FLOAT, base, pixel_bytes, pixel_bytes * static_cast<std::size_t>(image.width)));
  }
  for (const auto& [key, value] : image.attributes) {
    if (key.empty() || key.size() > 255)
      throw Error("attribute name of " + std::to_string(key.size()) + " characters, expected 1 to 255");
    const auto existing = header.find(key);
    if (existing != header.end()) throw Error("attribute " + key + " is one of the format's own");
    header.insert(key, Imf::StringAttribute(value));
  }
  // Threads are worth starting for pictures only that take longer to compress than threads to start.
  constexpr std::size_t kLarge = std::size_t{1} << 20;
  const int threads = image.pixels.size() >= kLarge ? thread_count() : 0;
  if (threads > Imf::globalThreadCount()) Imf::setGlobalThreadCount(threads);
  MemoryStream stream;
  {
    Imf::OutputFile file(stream, header, threads);
    file.setFrameBuffer(frame);
    file.writePixels(image.height);
  }
  return stream.take();
}

}  // namespace

image::Image decode_exr(std::span<const std::byte> file, const std::string& name) {
  return Reader(file, name).read();
}

image::Image read_exr(InputFile& file) {
  if (file.size() < 0) return decode_exr(file.read_rest(kLargestPipe), display_name(file.path()));
  Buffer<std::byte> bytes(static_cast<std::size_t>(file.size() - file.position()));
  file.read_exactly(bytes.data(), bytes.size());
  return decode_exr(bytes, display_name(file.path()));
}

image::Image read_exr(const std::filesystem::path& path) {
  InputFile file(path);
  return read_exr(file);
}

void write_exr(const std::filesystem::path& path, const image::Image& image) {
  OutputFile file(path);
  std::vector<char> bytes;
  try {
    bytes = encode(image);
  } catch (const std::exception& cause) {
    throw Error(output_name(path), Error(one_line(cause.what())));
  }
  file.write(bytes.data(), bytes.size());
  file.commit();
}

}  // namespace vol::io
