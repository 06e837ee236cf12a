// VTK XML image data, after "VTK File Formats" (XML formats) and what VTK 9 writes.
#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "base/checked.h"
#include "base/error.h"
#include "io/header_text.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"
#include "io/xml.h"

namespace vol::io {
namespace {

/// One <DataArray> of the piece.
struct Array {
  XmlTag tag;
  bool on_cells = false;
  std::string_view inline_data;
};

struct Document {
  std::string name;  ///< of the file
  XmlTag file, image, piece;
  std::string active[2];  ///< the Scalars of PointData, of CellData
  std::vector<Array> arrays;
  std::map<std::string, std::string> attributes;  ///< string arrays of <FieldData>
  std::string appended;                           ///< encoding of <AppendedData>, "" without one

  [[nodiscard]] Field field(std::string_view which) const { return {name, which}; }
};

/// All text up to the underscore after which appended data begin, or up to the end of the file.
std::string read_text(InputFile& file, const ReadOptions& options) {
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

/// Text from the numbers of the characters, as VTK writes strings in ascii; each ends with 0.
std::string decoded_string(const Document& document, std::string_view text) {
  std::string decoded;
  for (const auto& word : words_of(text)) {
    const std::int64_t code = parse_integer(document.field("a string in FieldData"), word);
    if (code == 0) break;
    decoded += static_cast<char>(static_cast<unsigned char>(code & 0xff));
  }
  return decoded;
}

Document parse_document(const std::string& name, std::string_view text) {
  Document document;
  document.name = name;
  XmlReader xml(name, text);
  enum class Inside { nothing, points, cells, field_data } inside = Inside::nothing;
  int pieces = 0;
  for (XmlTag tag = xml.next(); tag.kind != XmlTag::Kind::end_of_text; tag = xml.next()) {
    const bool opens = tag.kind != XmlTag::Kind::close;
    const bool stays_open = tag.kind == XmlTag::Kind::open;
    if (tag.name == "PointData" || tag.name == "CellData" || tag.name == "FieldData") {
      inside = !stays_open               ? Inside::nothing
               : tag.name == "PointData" ? Inside::points
               : tag.name == "CellData"  ? Inside::cells
                                         : Inside::field_data;
      if (opens && tag.name != "FieldData") document.active[tag.name == "CellData" ? 1 : 0] = tag["Scalars"];
      continue;
    }
    if (!opens) continue;
    if (tag.name == "VTKFile") {
      document.file = tag;
      if (tag["type"] != "ImageData") document.field("VTKFile type").refuse(tag["type"], "ImageData");
    } else if (tag.name == "ImageData") {
      document.image = tag;
    } else if (tag.name == "Piece") {
      if (++pieces > 1)
        throw Error(name + ": image data in several pieces; merge them into one (in ParaView: Save Data)");
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
        document.arrays.push_back(
            {tag, inside == Inside::cells, stays_open ? xml.text_here() : std::string_view()});
      }
    }
  }
  if (document.file.name.empty()) throw Error(name + ": XML without a VTKFile element");
  return document;
}

bool is_scalar(const Array& array) {
  const std::string components = array.tag["NumberOfComponents"];
  return components.empty() || components == "1";
}

/// The array asked for; else the active scalars, else the first scalar array, of points before cells.
const Array& choose_array(const Document& document, const std::string& wanted) {
  const Array* chosen = nullptr;
  int best = 0;
  std::string names;
  for (const Array& array : document.arrays) {
    const std::string name = array.tag["Name"];
    names += (names.empty() ? "" : ", ") + in_quotes(name) +
             (is_scalar(array) ? "" : " (" + array.tag["NumberOfComponents"] + " components)");
    int rank = 0;
    if (!wanted.empty()) {
      rank = name != wanted ? 0 : array.on_cells ? 1 : 2;
    } else if (is_scalar(array)) {
      const std::string& active = document.active[array.on_cells ? 1 : 0];
      rank = (array.on_cells ? 1 : 3) + (!active.empty() && active == name ? 1 : 0);
    }
    if (rank > best) {
      best = rank;
      chosen = &array;
    }
  }
  if (chosen == nullptr) {
    throw Error(document.name + ": has no " +
                (wanted.empty() ? "scalar array" : "array " + in_quotes(wanted)) +
                (names.empty() ? "; there is none at all" : "; there are " + names));
  }
  if (!is_scalar(*chosen)) {
    throw Error(document.name + ": array " + in_quotes(chosen->tag["Name"]) + " has " +
                in_quotes(chosen->tag["NumberOfComponents"]) + " components, expected a scalar");
  }
  return *chosen;
}

volume::VoxelType voxel_type(const Document& document, const XmlTag& array) {
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

volume::GridGeometry parse_geometry(const Document& document, bool on_cells) {
  const std::string extent_text =
      document.piece["Extent"].empty() ? document.image["WholeExtent"] : document.piece["Extent"];
  const auto extent = parse_integers(document.field("Extent"), extent_text, 6);
  volume::GridGeometry geometry;
  if (const auto text = document.image["Spacing"]; !text.empty()) {
    geometry.spacing = parse_vector(document.field("Spacing"), text);
  }
  if (const auto text = document.image["Origin"]; !text.empty()) {
    geometry.origin = parse_vector(document.field("Origin"), text);
  }
  if (const auto text = document.image["Direction"]; !text.empty()) {
    const auto rows = parse_numbers(document.field("Direction"), text, 9);
    for (int i = 0; i < 9; ++i) geometry.direction(i / 3, i % 3) = rows[static_cast<std::size_t>(i)];
  }
  Vec3 first;  // index of the first sample, in points from the image's origin
  for (int a = 0; a < 3; ++a) {
    const std::int64_t low = extent[static_cast<std::size_t>(2 * a)],
                       high = extent[static_cast<std::size_t>(2 * a + 1)];
    constexpr std::int64_t kLargest = std::int64_t{1} << 40;
    if (low < -kLargest || high > kLargest || high < low) {
      document.field("Extent").refuse(extent_text, "first and last index of each axis");
    }
    const std::int64_t points = high - low + 1;
    const bool shifted = on_cells && points > 1;
    geometry.dims[static_cast<std::size_t>(a)] = shifted ? points - 1 : points;
    first[a] = static_cast<double>(low) + (shifted ? 0.5 : 0.0);
  }
  geometry.origin = geometry.index_to_world(first);
  return geometry;
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

volume::Volume read_encoded(ByteSource& source, const Document& document, const VoxelLayout& layout,
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

bool is_vtk_xml(std::string_view start) {
  return start.compare(0, 5, "<?xml") == 0 || start.compare(0, 8, "<VTKFile") == 0;
}

volume::Volume read_vti(InputFile& file, const ReadOptions& options) {
  const std::string text = read_text(file, options);
  const std::string name = display_name(file.path());
  Document document = parse_document(name, text);
  const Array& array = choose_array(document, options.array);
  VoxelLayout layout;
  layout.type = voxel_type(document, array.tag);
  layout.geometry = parse_geometry(document, array.on_cells);
  const std::string order = document.file["byte_order"];
  if (!order.empty() && order != "LittleEndian" && order != "BigEndian") {
    document.field("byte_order").refuse(order, "LittleEndian or BigEndian");
  }
  layout.big_endian = order == "BigEndian";
  if (const auto space = document.attributes.find("precis.space"); space != document.attributes.end()) {
    layout.geometry.space = space->second == "LPS"   ? volume::Space::lps
                            : space->second == "RAS" ? volume::Space::ras
                                                     : volume::Space::none;
    document.attributes.erase(space);
  }

  const std::string format = array.tag["format"];
  volume::Volume volume;
  if (format == "appended") {
    if (document.appended.empty())
      throw Error(name + ": array is 'appended' but the file has no AppendedData");
    FileSource source(file);
    const std::int64_t offset = parse_integer(document.field("offset"), array.tag["offset"]);
    if (offset < 0) document.field("offset").refuse(array.tag["offset"], "0 or more");
    source.skip(offset);
    Base64Source decoded(source);
    volume = read_encoded(document.appended == "raw" ? static_cast<ByteSource&>(source) : decoded, document,
                          layout, options);
  } else if (format == "binary") {
    MemorySource source(name, array.inline_data);
    Base64Source decoded(source);
    volume = read_encoded(decoded, document, layout, options);
  } else if (format == "ascii" || format.empty()) {
    MemorySource source(name, array.inline_data);
    Scanner scanner(source);
    volume = read_ascii(scanner, layout, options);
    if (!scanner.word().empty()) throw Error(name + ": array holds more numbers than its extent has samples");
  } else {
    document.field("DataArray format").refuse(format, "ascii, binary or appended");
  }
  volume.attributes = std::move(document.attributes);
  return volume;
}

}  // namespace vol::io
