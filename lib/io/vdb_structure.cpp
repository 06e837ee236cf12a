#include "io/vdb_structure.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>

#include "base/error.h"

namespace vol::io {
namespace {

constexpr std::size_t kHeader = 57;  // magic 8, version 4, library 8, offsets flag 1, id 36
constexpr std::uint32_t kOldestVersion = 222;
constexpr std::uint32_t kNewestVersion = 224;
constexpr std::uint32_t kZip = 1;
constexpr std::uint32_t kActiveMask = 2;
constexpr std::uint32_t kBlosc = 4;

/// Bytes of a value, and of a value stored in half precision (0: there is no such thing).
struct ValueSize {
  std::size_t full;
  std::size_t half;
};
const std::map<std::string_view, ValueSize> kTrees = {
    {"Tree_float_5_4_3", {4, 2}},  {"Tree_double_5_4_3", {8, 2}}, {"Tree_int32_5_4_3", {4, 0}},
    {"Tree_int64_5_4_3", {8, 0}},  {"Tree_vec3s_5_4_3", {12, 6}}, {"Tree_vec3d_5_4_3", {24, 6}},
    {"Tree_vec3i_5_4_3", {12, 0}},
};
const std::map<std::string_view, std::size_t> kMaps = {
    {"AffineMap", 128},
    {"UnitaryMap", 128},
    {"TranslationMap", 24},
    {"ScaleMap", 120},
    {"UniformScaleMap", 120},
    {"ScaleTranslateMap", 144},
    {"UniformScaleTranslateMap", 144},
};
const std::map<std::string_view, std::size_t> kMetadata = {
    {"bool", 1}, {"float", 4}, {"double", 8}, {"int32", 4}, {"int64", 8},
};
constexpr std::string_view kHalfSuffix = "_HalfFloat";

class Walker {
 public:
  explicit Walker(std::span<std::byte> file) : file_(file) {}

  void walk() {
    take(8);
    const auto version = number<std::uint32_t>();
    if (version < kOldestVersion || version > kNewestVersion) {
      throw Error("OpenVDB format " + std::to_string(version) + ", expected " +
                  std::to_string(kOldestVersion) + " to " + std::to_string(kNewestVersion));
    }
    take(kHeader - 12);
    metadata(nullptr);
    const auto grids = number<std::int32_t>();
    if (grids < 0) damaged();
    for (std::int32_t n = 0; n < grids; ++n) grid();
  }

 private:
  [[noreturn]] static void damaged() { throw Error("OpenVDB data end early or are damaged"); }

  std::span<std::byte> take(std::size_t n) {
    if (n > file_.size() - at_) damaged();
    at_ += n;
    return file_.subspan(at_ - n, n);
  }
  template <class T>
  T number() {
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::span<std::byte> string() { return take(number<std::uint32_t>()); }
  static std::string_view text(std::span<std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  /// The beginning of a name from the file, fit for one line.
  static std::string shown(std::string_view name) {
    std::string line(name.substr(0, 64));
    for (char& c : line) {
      if (c < ' ' || c > '~') c = '?';
    }
    return line;
  }

  /// A map of names to values. `half`, if given, receives the flag of half precision, -1 where there is none.
  void metadata(int* half) {
    const auto count = number<std::uint32_t>();
    for (std::uint32_t n = 0; n < count; ++n) {
      const auto name = text(string());
      const auto type = string();
      const auto value = string();
      if (text(type) == "string") continue;
      const auto known = kMetadata.find(text(type));
      if (known == kMetadata.end()) {
        if (!type.empty()) type[0] = std::byte{'~'};
      } else if (known->second != value.size()) {
        damaged();
      }
      if (half != nullptr && name == "is_saved_as_half_float" && text(type) == "bool")
        *half = value[0] != std::byte{0};
    }
  }

  void grid() {
    const std::string name(text(string()));
    auto type = text(string());
    half_ = type.ends_with(kHalfSuffix);
    if (half_) type.remove_suffix(kHalfSuffix.size());
    const bool instance = !string().empty();
    take(3 * 8);  // positions in a file that can seek
    const auto tree = kTrees.find(type);
    if (tree == kTrees.end() || (half_ && tree->second.half == 0)) {
      throw Error("grid '" + shown(std::string_view(name).substr(0, name.find('\x1e'))) +
                  "' is of the type " + shown(type) +
                  ", expected float, double, int or vector values in a standard tree");
    }
    value_ = tree->second;
    compression_ = number<std::uint32_t>();
    if ((compression_ & ~(kZip | kActiveMask | kBlosc)) != 0) damaged();
    int flag = -1;
    metadata(&flag);
    if (half_ ? flag != 1 : flag == 1) damaged();
    const auto map = text(string());
    const auto size = kMaps.find(map);
    if (size == kMaps.end()) {
      throw Error("transform " + shown(map) + " is not linear, or the data are damaged");
    }
    take(size->second);
    if (!instance) tree_nodes();
  }

  void tree_nodes() {
    if (number<std::int32_t>() != 1) damaged();  // buffers a leaf
    take(value_.full);                           // background
    const auto tiles = number<std::uint32_t>();
    const auto children = number<std::uint32_t>();
    for (std::uint32_t n = 0; n < tiles; ++n) take(12 + value_.full + 1);
    std::uint64_t leaves = 0;
    for (std::uint32_t n = 0; n < children; ++n) {
      take(12);
      leaves += upper_node();
    }
    for (std::uint64_t n = 0; n < leaves; ++n) {
      const auto mask = take(512 / 8);
      values(mask, 512);
    }
  }

  /// Topology of a node of 32^3 children; returns how many leaves lie below.
  std::uint64_t upper_node() {
    const std::size_t children = node(32 * 32 * 32);
    std::uint64_t leaves = 0;
    for (std::size_t n = 0; n < children; ++n) {
      const std::size_t below = node(16 * 16 * 16);
      take(below * (512 / 8));  // their value masks
      leaves += below;
    }
    return leaves;
  }

  std::size_t node(std::size_t size) {
    const std::size_t children = bits(take(size / 8));
    values(take(size / 8), size);
    return children;
  }

  static std::size_t bits(std::span<const std::byte> mask) {
    std::size_t count = 0;
    for (const auto byte : mask)
      count += static_cast<std::size_t>(std::popcount(static_cast<unsigned char>(byte)));
    return count;
  }

  /// The values of a node, as openvdb::io::readCompressedValues takes them.
  void values(std::span<const std::byte> mask, std::size_t size) {
    const auto layout = number<std::uint8_t>();
    constexpr std::uint8_t kMask = 3, kOneInactive = 2, kMaskOneInactive = 4, kMaskTwoInactive = 5, kAll = 6;
    if (layout > kAll) damaged();
    if (layout == kOneInactive || layout == kMaskOneInactive || layout == kMaskTwoInactive) take(value_.full);
    if (layout == kMaskTwoInactive) take(value_.full);
    if (layout >= kMask && layout <= kMaskTwoInactive) take(size / 8);
    const std::size_t count = (compression_ & kActiveMask) != 0 && layout != kAll ? bits(mask) : size;
    if (half_ && count == 0) return;
    const std::size_t bytes = count * (half_ ? value_.half : value_.full);
    if ((compression_ & (kBlosc | kZip)) == 0) {
      take(bytes);
      return;
    }
    const auto stated = number<std::int64_t>();  // not positive: that many bytes, uncompressed
    if (stated <= 0) {
      if (stated != -static_cast<std::int64_t>(bytes)) damaged();
      take(bytes);
    } else {
      take(static_cast<std::size_t>(stated));
    }
  }

  std::span<std::byte> file_;
  std::size_t at_ = 0;
  ValueSize value_{};
  bool half_ = false;
  std::uint32_t compression_ = 0;
};

}  // namespace

void check_vdb_structure(std::span<std::byte> file) {
  Walker(file).walk();
}

}  // namespace vol::io
