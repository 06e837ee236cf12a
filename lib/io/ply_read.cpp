#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "io/mesh_read.h"

namespace vol::io {
namespace {

static_assert(std::endian::native == std::endian::little);

enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };
constexpr int kSize[] = {1, 1, 2, 2, 4, 4, 4, 8};
constexpr double kMost[] = {127, 255, 32767, 65535, 2147483647, 4294967295};  // of the whole numbers

struct Property {
  std::string name;
  Type type = Type::f32;
  std::optional<Type> count = {};  ///< of a list
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

std::optional<Type> type_named(std::string_view word) {
  constexpr std::pair<std::string_view, Type> kNames[] = {
      {"char", Type::i8},   {"int8", Type::i8},     {"uchar", Type::u8},   {"uint8", Type::u8},
      {"short", Type::i16}, {"int16", Type::i16},   {"ushort", Type::u16}, {"uint16", Type::u16},
      {"int", Type::i32},   {"int32", Type::i32},   {"uint", Type::u32},   {"uint32", Type::u32},
      {"float", Type::f32}, {"float32", Type::f32}, {"double", Type::f64}, {"float64", Type::f64}};
  for (const auto& [name, type] : kNames) {
    if (name == word) return type;
  }
  return std::nullopt;
}

class PlyReader {
 public:
  explicit PlyReader(InputFile& file) : file_(file), name_(display_name(file.path())) {}

  mesh::TriangleMesh read() {
    read_header();
    for (const Element& element : elements_) {
      require(element);
      const bool vertices = element.name == "vertex";
      const bool faces = element.name == "face";
      if (vertices) choose_coordinates(element);
      for (std::int64_t n = 0; n < element.count; ++n) {
        start_record();
        if (vertices) {
          read_vertex(element);
        } else {
          read_record(element, faces);
        }
      }
    }
    for (const auto& t : mesh_.triangles) {
      for (const std::uint32_t v : t) {
        if (v >= mesh_.positions.size()) {
          fail("a face has vertex " + std::to_string(v) + " of " + std::to_string(mesh_.positions.size()));
        }
      }
    }
    require_faces(file_, mesh_);
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw Error(name_ + ": " + what); }

  void read_header() {
    std::string line = file_.read_line();
    std::string_view rest = line;
    if (take_word(rest) != "ply") fail("not a PLY file");
    bool has_format = false;
    while (true) {
      line = file_.read_line();
      rest = line;
      const std::string_view word = take_word(rest);
      if (word == "end_header") break;
      if (word.empty() || word == "comment" || word == "obj_info") continue;
      if (word == "format") {
        const std::string_view format = take_word(rest);
        ascii_ = format == "ascii";
        swap_ = format == "binary_big_endian";
        has_format = ascii_ || swap_ || format == "binary_little_endian";
      } else if (word == "element") {
        Element element;
        element.name = take_word(rest);
        if (!parse_word(take_word(rest), element.count) || element.count < 0) {
          fail("an element of the PLY header has no count");
        }
        for (const Element& other : elements_) {
          if (other.name == element.name) fail("the PLY header has an element twice");
        }
        elements_.push_back(std::move(element));
      } else if (word == "property") {
        if (elements_.empty()) fail("a property of the PLY header comes before its element");
        add_property(elements_.back(), rest);
      } else {
        fail("the PLY header has a line that is none");
      }
      constexpr std::size_t kMany = 100;  // elements, and properties of one
      if (elements_.size() > kMany || (!elements_.empty() && elements_.back().properties.size() > kMany)) {
        fail("the PLY header has over 100 elements or properties");
      }
    }
    if (!has_format) fail("the PLY header has no format: ascii, binary_little_endian or binary_big_endian");
  }

  void add_property(Element& element, std::string_view rest) const {
    Property property;
    std::string_view word = take_word(rest);
    if (word == "list") {
      property.count = type_named(take_word(rest));
      if (!property.count || *property.count >= Type::f32) fail("a list of the PLY header has no count");
      word = take_word(rest);
    }
    const auto type = type_named(word);
    if (!type) fail("a property of the PLY header has no type");
    property.type = *type;
    property.name = take_word(rest);
    element.properties.push_back(std::move(property));
  }

  /// Before anything is read: the file must be as long as the counts say.
  void require(const Element& element) const {
    std::int64_t least = 0;
    for (const Property& p : element.properties) {
      least += ascii_ ? 2 : kSize[static_cast<int>(p.count.value_or(p.type))];
    }
    if (least == 0 && element.count > 0) fail("an element of the PLY header has no properties");
    if (element.count > std::numeric_limits<std::int64_t>::max() / std::max<std::int64_t>(least, 1)) {
      fail("data end before the counts that the PLY header promises");
    }
    // The last number of a text needs no blank behind it.
    if (element.count > 0) file_.require(element.count * least - (ascii_ ? 1 : 0));
    if (element.name == "vertex" && element.count > std::numeric_limits<std::uint32_t>::max()) {
      fail("over 2^32 - 1 vertices");
    }
  }

  void choose_coordinates(const Element& element) {
    constexpr std::string_view kNames[6] = {"x", "y", "z", "nx", "ny", "nz"};
    int found = 0;
    use_.assign(element.properties.size(), -1);
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      for (int n = 0; n < 6; ++n) {
        if (element.properties[p].name != kNames[n] || element.properties[p].count || (found >> n & 1) != 0) {
          continue;
        }
        use_[p] = n;
        found |= 1 << n;
      }
    }
    if ((found & 7) != 7) fail("the PLY header has vertices without x, y and z");
    has_normals_ = (found >> 3) == 7;
  }

  void read_vertex(const Element& element) {
    double value[6] = {};
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if (property.count) {
        skip_list(property);
        continue;
      }
      const double x = number(property.type);
      if (use_[p] >= 0) value[use_[p]] = x;
    }
    for (int a = 0; a < 3; ++a) {
      if (!std::isfinite(value[a])) fail("a vertex has a coordinate that is not finite");
    }
    mesh_.positions.push_back({value[0], value[1], value[2]});
    if (has_normals_) mesh_.normals.push_back(unit_normal({value[3], value[4], value[5]}));
  }

  void read_record(const Element& element, bool face) {
    for (const Property& property : element.properties) {
      if (!property.count) {
        (void)number(property.type);
      } else if (face && (property.name == "vertex_indices" || property.name == "vertex_index")) {
        read_corners(property);
      } else {
        skip_list(property);
      }
    }
  }

  void read_corners(const Property& property) {
    if (property.type >= Type::f32) fail("the faces' vertices are no whole numbers");
    const std::int64_t n = length(property);
    if (n < 3) fail("a face has fewer than 3 corners");
    std::uint32_t first = 0, before = 0;
    for (std::int64_t c = 0; c < n; ++c) {
      const double index = number(property.type);
      if (!(index >= 0 && index < std::numeric_limits<std::uint32_t>::max())) {
        fail("a face has a vertex that does not exist");
      }
      const auto v = static_cast<std::uint32_t>(index);
      if (c == 0) first = v;
      if (c >= 2) mesh_.triangles.push_back({first, before, v});
      before = v;
    }
  }

  [[nodiscard]] std::int64_t length(const Property& list) {
    const double n = number(*list.count);
    if (!(n >= 0 && n <= kMost[static_cast<int>(*list.count)])) {
      fail("a list has a number of entries that its type does not hold");
    }
    return static_cast<std::int64_t>(n);
  }
  void skip_list(const Property& list) {
    for (std::int64_t n = length(list); n > 0; --n) (void)number(list.type);
  }

  /// Text: a record is a line.
  void start_record() {
    if (!ascii_) return;
    do {
      line_ = file_.read_line();
      rest_ = line_;
    } while (rest_.find_first_not_of(" \t\r") == std::string_view::npos);
  }

  /// The next number of the record.
  [[nodiscard]] double number(Type type) {
    if (ascii_) {
      double value = 0;
      if (!parse_word(take_word(rest_), value)) fail("a line has too few numbers, or a word that is none");
      if (type < Type::f32 && value != std::floor(value)) fail("a whole number was expected");
      return value;
    }
    switch (type) {
      case Type::i8:
        return binary<std::int8_t>();
      case Type::u8:
        return binary<std::uint8_t>();
      case Type::i16:
        return binary<std::int16_t>();
      case Type::u16:
        return binary<std::uint16_t>();
      case Type::i32:
        return binary<std::int32_t>();
      case Type::u32:
        return binary<std::uint32_t>();
      case Type::f32:
        return double{binary<float>()};
      default:
        return binary<double>();
    }
  }
  template <class T>
  T binary() {
    char bytes[sizeof(T)];
    file_.read_exactly(bytes, sizeof(T));
    if (swap_) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

  InputFile& file_;
  std::string name_;
  bool ascii_ = false;
  bool swap_ = false;
  bool has_normals_ = false;
  std::vector<Element> elements_;
  std::vector<int> use_;  ///< of a vertex's properties: 0 to 5 for x, y, z, nx, ny, nz, or -1
  std::string line_;
  std::string_view rest_;
  mesh::TriangleMesh mesh_;
};

}  // namespace

mesh::TriangleMesh read_ply(InputFile& file) {
  return PlyReader(file).read();
}

}  // namespace vol::io
