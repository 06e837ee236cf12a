#include "io/vtk_xml.h"

#include <algorithm>
#include <array>
#include <memory>

#include "base/error.h"

namespace vol::io {
namespace {

/// Text from the numbers of the characters, as VTK writes strings in ascii; each ends with 0.
std::string decoded_string(const VtkDocument& document, std::string_view text) {
  std::string decoded;
  for (const auto& word : words_of(text)) {
    const std::int64_t code = parse_integer(document.field("a string in FieldData"), word);
    if (code == 0) break;
    decoded += static_cast<char>(static_cast<unsigned char>(code & 0xff));
  }
  return decoded;
}

/// Lengths before the data are 32 or 64 bit, in the file's byte order.
class HeaderWords {
 public:
  HeaderWords(bool wide, bool big_endian) : size_(wide ? 8 : 4), big_endian_(big_endian) {}
  [[nodiscard]] std::uint64_t next(ByteSource& source) const {
    std::array<unsigned char, 8> bytes{};
    source.read_exactly(bytes.data(), size_);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size_; ++i) value = value << 8 | bytes[big_endian_ ? i : size_ - 1 - i];
    return value;
  }

 private:
  std::size_t size_;
  bool big_endian_;
};

/// vtkZLibDataCompressor: number of blocks, their size, size of the last if it is shorter, compressed size of
/// each, then one zlib stream a block.
class ZlibBlocksSource : public ByteSource {
 public:
  ZlibBlocksSource(ByteSource& from, const HeaderWords& words, std::int64_t bytes)
      : ByteSource(from.name()), from_(from) {
    const std::uint64_t blocks = words.next(from);
    block_size_ = words.next(from);
    last_size_ = words.next(from);
    const std::uint64_t full = last_size_ == 0 ? blocks : blocks - 1;
    const auto total = static_cast<std::uint64_t>(bytes);
    if (blocks == 0 || blocks > total || block_size_ == 0 || last_size_ > block_size_ ||
        (full > 0 && block_size_ > total / full) || full * block_size_ + last_size_ != total) {
      throw Error(name() + ": compressed blocks hold " + std::to_string(blocks) + " x " +
                  std::to_string(block_size_) + " bytes (last " + std::to_string(last_size_) +
                  "), expected " + std::to_string(bytes) + " in all");
    }
    for (std::uint64_t b = 0; b < blocks; ++b) packed_sizes_.push_back(words.next(from));
  }
  std::size_t read(void* to, std::size_t n) override {
    auto* out = static_cast<char*>(to);
    std::size_t done = 0;
    while (done < n) {
      if (left_ == 0) {
        close_block();
        if (next_ == packed_sizes_.size()) break;
        open_block();
      }
      const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(n - done, left_));
      inflated_->read_exactly(out + done, part);
      done += part;
      left_ -= part;
    }
    return done;
  }

 private:
  ByteSource& from_;
  std::uint64_t block_size_ = 0, last_size_ = 0, left_ = 0;
  std::vector<std::uint64_t> packed_sizes_;
  std::size_t next_ = 0;
  std::unique_ptr<LimitedSource> limited_;
  std::unique_ptr<InflateSource> inflated_;

  void open_block() {
    const std::uint64_t packed = packed_sizes_[next_++];
    const bool last = next_ == packed_sizes_.size();
    left_ = last && last_size_ != 0 ? last_size_ : block_size_;
    limited_ = std::make_unique<LimitedSource>(
        from_, static_cast<std::int64_t>(packed >> 1 > (1ULL << 61) ? 1ULL << 62 : packed));
    inflated_ = std::make_unique<InflateSource>(*limited_);
  }
  void close_block() {
    if (!inflated_) return;
    expect_end(*inflated_, static_cast<std::int64_t>(block_size_));
    std::array<char, 4096> rest;
    while (limited_->read(rest.data(), rest.size()) == rest.size()) {
    }
    inflated_.reset();
  }
};

volume::Volume read_encoded(ByteSource& source, const VtkDocument& document, const VoxelLayout& layout,
                            const ReadOptions& options) {
  const std::int64_t bytes = checked_bytes(document.name, layout, options);
  const std::string header_type = document.file["header_type"];
  if (!header_type.empty() && header_type != "UInt32" && header_type != "UInt64") {
    document.field("header_type").refuse(header_type, "UInt32 or UInt64");
  }
  const HeaderWords words(header_type == "UInt64", layout.big_endian);
  const std::string compressor = document.file["compressor"];
  if (compressor == "vtkZLibDataCompressor") {
    ZlibBlocksSource blocks(source, words, bytes);
    volume::Volume volume = read_binary(blocks, layout, options);
    expect_end(blocks, bytes);
    return volume;
  }
  if (!compressor.empty()) document.field("compressor").refuse(compressor, "vtkZLibDataCompressor or none");
  const std::uint64_t stated = words.next(source);
  if (stated != static_cast<std::uint64_t>(bytes)) {
    throw Error(document.name + ": array holds " + std::to_string(stated) +
                " bytes, its extent and type take " + std::to_string(bytes));
  }
  return read_binary(source, layout, options);
}

}  // namespace

bool VtkDocument::big_endian() const {
  const std::string order = file["byte_order"];
  if (!order.empty() && order != "LittleEndian" && order != "BigEndian") {
    field("byte_order").refuse(order, "LittleEndian or BigEndian");
  }
  return order == "BigEndian";
}

std::string read_vtk_text(InputFile& file, const ReadOptions& options) {
  static constexpr std::string_view kMark = "<AppendedData";
  std::string text;
  std::size_t mark = std::string::npos, searched = 0;
  for (;;) {
    const std::string_view next = file.peek(4096);
    if (next.empty()) return text;
    const std::size_t before = text.size();
    text += next;
    if (mark == std::string::npos) {
      mark = text.find(kMark, searched);
      searched = text.size() > kMark.size() ? text.size() - kMark.size() : 0;
    }
    std::size_t stop = text.size();
    bool found = false;
    if (mark != std::string::npos) {
      const std::size_t close = text.find('>', mark);
      const std::size_t underscore = close == std::string::npos ? close : text.find('_', close);
      found = underscore != std::string::npos;
      if (found) stop = underscore + 1;
      if (!found && close != std::string::npos && text.size() - close > 4096) {
        throw Error(display_name(file.path()) + ": appended data do not begin with an underscore");
      }
    }
    text.resize(stop);
    file.skip(static_cast<std::int64_t>(stop - before));
    if (found) return text;
    // Base64 and ascii data take more than their voxels do; a header of gigabytes is none.
    if (static_cast<double>(text.size()) > 16.0 * static_cast<double>(options.memory_limit) + 1e6) {
      throw Error(display_name(file.path()) + ": XML text takes more than the memory there is");
    }
  }
}

VtkDocument parse_vtk_document(const std::string& name, std::string_view text, const std::string& data_set) {
  VtkDocument document;
  document.name = name;
  XmlReader xml(name, text);
  enum class Inside { nothing, points, cells, positions, field_data } inside = Inside::nothing;
  int pieces = 0;
  for (XmlTag tag = xml.next(); tag.kind != XmlTag::Kind::end_of_text; tag = xml.next()) {
    const bool opens = tag.kind != XmlTag::Kind::close;
    const bool stays_open = tag.kind == XmlTag::Kind::open;
    if (tag.name == "PointData" || tag.name == "CellData" || tag.name == "FieldData" ||
        tag.name == "Points") {
      inside = !stays_open               ? Inside::nothing
               : tag.name == "PointData" ? Inside::points
               : tag.name == "CellData"  ? Inside::cells
               : tag.name == "Points"    ? Inside::positions
                                         : Inside::field_data;
      if (opens && tag.name != "FieldData" && tag.name != "Points")
        document.active[tag.name == "CellData" ? 1 : 0] = tag["Scalars"];
      continue;
    }
    if (!opens) continue;
    if (tag.name == "VTKFile") {
      document.file = tag;
      if (tag["type"] != data_set) document.field("VTKFile type").refuse(tag["type"], data_set);
    } else if (tag.name == data_set) {
      document.data_set = tag;
    } else if (tag.name == "Piece") {
      if (++pieces > 1)
        throw Error(name + ": data in several pieces; merge them into one (in ParaView: Save Data)");
      document.piece = tag;
    } else if (tag.name == "AppendedData") {
      document.appended = tag["encoding"];
      if (document.appended != "raw" && document.appended != "base64") {
        document.field("AppendedData encoding").refuse(document.appended, "raw or base64");
      }
      return document;
    } else if (tag.name == "DataArray" || tag.name == "Array") {
      if (inside == Inside::field_data) {
        if (tag["type"] == "String" && tag["format"] == "ascii" && stays_open) {
          document.attributes[tag["Name"]] = decoded_string(document, xml.text_here());
        }
      } else if (inside != Inside::nothing) {
        document.arrays.push_back({tag,
                                   inside == Inside::cells       ? VtkArray::On::cells
                                   : inside == Inside::positions ? VtkArray::On::positions
                                                                 : VtkArray::On::points,
                                   stays_open ? xml.text_here() : std::string_view()});
      }
    }
  }
  if (document.file.name.empty()) throw Error(name + ": XML without a VTKFile element");
  return document;
}

volume::VoxelType voxel_type(const VtkDocument& document, const XmlTag& array) {
  using enum volume::VoxelType;
  static const std::map<std::string, volume::VoxelType> kTypes = {
      {"Int8", i8},   {"UInt8", u8},   {"Int16", i16},   {"UInt16", u16},
      {"Int32", i32}, {"UInt32", u32}, {"Float32", f32}, {"Float64", f64}};
  const auto found = kTypes.find(array["type"]);
  if (found == kTypes.end()) {
    document.field("type of array " + in_quotes(array["Name"]))
        .refuse(array["type"], "Int8 ... UInt32, Float32 or Float64");
  }
  return found->second;
}

std::vector<std::int64_t> parse_extent(const VtkDocument& document) {
  const std::string text =
      document.piece["Extent"].empty() ? document.data_set["WholeExtent"] : document.piece["Extent"];
  auto extent = parse_integers(document.field("Extent"), text, 6);
  constexpr std::int64_t kLargest = std::int64_t{1} << 40;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t low = extent[2 * a], high = extent[2 * a + 1];
    if (low < -kLargest || high > kLargest || high < low) {
      document.field("Extent").refuse(text, "first and last index of each axis");
    }
  }
  return extent;
}

volume::Volume read_vtk_array(const VtkDocument& document, const VtkArray& array, const VoxelLayout& layout,
                              ByteSource* appended, const ReadOptions& options) {
  const std::string format = array.tag["format"];
  if (format == "appended") {
    if (document.appended.empty() || appended == nullptr)
      throw Error(document.name + ": array is 'appended' but the file has no AppendedData");
    const std::int64_t offset = parse_integer(document.field("offset"), array.tag["offset"]);
    if (offset < 0) document.field("offset").refuse(array.tag["offset"], "0 or more");
    appended->skip(offset);
    Base64Source decoded(*appended);
    return read_encoded(document.appended == "raw" ? *appended : decoded, document, layout, options);
  }
  if (format == "binary") {
    MemorySource source(document.name, array.inline_data);
    Base64Source decoded(source);
    return read_encoded(decoded, document, layout, options);
  }
  if (format != "ascii" && !format.empty()) {
    document.field("DataArray format").refuse(format, "ascii, binary or appended");
  }
  MemorySource source(document.name, array.inline_data);
  Scanner scanner(source);
  volume::Volume volume = read_ascii(scanner, layout, options);
  if (!scanner.word().empty()) {
    throw Error(document.name + ": array holds more numbers than its extent has samples");
  }
  return volume;
}

}  // namespace vol::io
