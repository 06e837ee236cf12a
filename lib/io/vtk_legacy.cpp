// Legacy VTK structured points, after "VTK File Formats" (simple legacy formats).
#include <map>
#include <optional>

#include "base/checked.h"
#include "base/error.h"
#include "io/header_text.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"

namespace vol::io {
namespace {

struct VtkType {
  std::int64_t bytes;
  std::optional<volume::VoxelType> voxel;
};

std::optional<VtkType> vtk_type(const std::string& word) {
  using enum volume::VoxelType;
  static const std::map<std::string, VtkType> kTypes = {
      {"char", {1, i8}},          {"signed_char", {1, i8}},     {"unsigned_char", {1, u8}},
      {"short", {2, i16}},        {"unsigned_short", {2, u16}}, {"int", {4, i32}},
      {"unsigned_int", {4, u32}}, {"float", {4, f32}},          {"double", {8, f64}},
      {"long", {8, {}}},          {"unsigned_long", {8, {}}},   {"vtktypeint64", {8, {}}},
      {"vtktypeuint64", {8, {}}}, {"vtkidtype", {4, {}}}};
  const auto found = kTypes.find(lower_case(word));
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

class LegacyReader {
 public:
  LegacyReader(InputFile& file, const ReadOptions& options)
      : source_(file), scanner_(source_), options_(options), name_(source_.name()) {}

  volume::Volume read() {
    (void)scanner_.line();  // "# vtk DataFile Version x.y"
    title_ = scanner_.line();
    const std::string encoding = lower_case(word());
    if (encoding != "ascii" && encoding != "binary") refuse("encoding", encoding, "ASCII or BINARY");
    ascii_ = encoding == "ascii";
    for (;;) {
      const std::string keyword = lower_case(word());
      if (keyword.empty()) break;
      if (auto found = section(keyword)) {
        check_what_follows();
        found->attributes["title"] = title_;
        return std::move(*found);
      }
    }
    if (dims_ == Dims{0, 0, 0})
      throw Error(name_ + ": legacy VTK file has no DATASET STRUCTURED_POINTS with DIMENSIONS");
    throw Error(name_ + ": has no " +
                (options_.array.empty() ? "scalar array" : "array " + in_quotes(options_.array)) +
                (seen_.empty() ? "" : "; there are " + seen_));
  }

 private:
  FileSource source_;
  Scanner scanner_;
  const ReadOptions& options_;
  const std::string& name_;
  std::string title_, seen_;
  bool ascii_ = false, on_cells_ = false;
  Dims dims_{0, 0, 0};
  Vec3 spacing_{1, 1, 1}, origin_{0, 0, 0};
  std::int64_t tuples_ = 0;  ///< of the section, 0 before POINT_DATA or CELL_DATA

  [[noreturn]] void refuse(std::string_view what, std::string_view text, std::string_view expected) const {
    Field{name_, what}.refuse(text, expected);
  }
  std::string word() { return std::string(scanner_.word()); }
  std::int64_t integer(const char* what) {
    const std::int64_t value = parse_integer({name_, what}, word());
    if (value < 0) throw Error(name_ + ": " + what + " is " + std::to_string(value) + ", expected 0 or more");
    return value;
  }
  Vec3 vector(const char* what) {
    Vec3 v;
    for (int a = 0; a < 3; ++a) v[a] = parse_number({name_, what}, word());
    return v;
  }

  /// One keyword and what belongs to it; the volume, when it was the array that is wanted.
  std::optional<volume::Volume> section(const std::string& keyword) {
    if (keyword == "dataset") {
      const std::string kind = word();
      if (lower_case(kind) != "structured_points") refuse("DATASET", kind, "STRUCTURED_POINTS");
    } else if (keyword == "dimensions") {
      for (auto& n : dims_) n = integer("DIMENSIONS");
    } else if (keyword == "spacing" || keyword == "aspect_ratio") {
      spacing_ = vector("SPACING");
    } else if (keyword == "origin") {
      origin_ = vector("ORIGIN");
    } else if (keyword == "point_data" || keyword == "cell_data") {
      on_cells_ = keyword == "cell_data";
      tuples_ = integer(on_cells_ ? "CELL_DATA" : "POINT_DATA");
      const std::int64_t expected = checked_geometry().count();
      if (tuples_ != expected) {
        throw Error(name_ + ": " + (on_cells_ ? "CELL_DATA" : "POINT_DATA") + " says " +
                    std::to_string(tuples_) + " values, DIMENSIONS says " + std::to_string(expected));
      }
    } else if (keyword == "scalars") {
      return scalars();
    } else if (keyword == "field") {
      return field_arrays();
    } else if (keyword == "vectors" || keyword == "normals") {
      skip_named(3);
    } else if (keyword == "tensors") {
      skip_named(9);
    } else if (keyword == "tensors6") {
      skip_named(6);
    } else if (keyword == "texture_coordinates") {
      (void)word();
      const std::int64_t components = integer("TEXTURE_COORDINATES");
      skip_values(type_of(word()), product(components, tuples_));
    } else if (keyword == "color_scalars") {
      (void)word();
      const std::int64_t components = integer("COLOR_SCALARS");
      skip_values({1, {}}, product(components, tuples_));
    } else if (keyword == "lookup_table") {
      (void)word();
      skip_values({1, {}}, product(4, integer("LOOKUP_TABLE")));
    } else if (keyword == "metadata") {
      (void)scanner_.line();
      while (!scanner_.at_end() && !trimmed(scanner_.line()).empty()) {
      }
    } else {
      throw Error(name_ + ": " + in_quotes(keyword) + " where a keyword of a legacy VTK file was expected");
    }
    return std::nullopt;
  }

  [[nodiscard]] volume::GridGeometry checked_geometry() const {
    volume::GridGeometry geometry;
    geometry.spacing = spacing_;
    geometry.origin = origin_;
    geometry.dims = dims_;
    for (int a = 0; a < 3; ++a) {
      auto& n = geometry.dims[static_cast<std::size_t>(a)];
      if (!on_cells_ || n <= 1) continue;
      n -= 1;  // cells lie between points
      geometry.origin[a] += 0.5 * spacing_[a];
    }
    try {
      geometry.validate();
    } catch (const Error& e) {
      throw Error(name_, e);
    }
    return geometry;
  }

  std::int64_t product(std::int64_t a, std::int64_t b) const {
    try {
      return checked_product(a, b);
    } catch (const Error& e) {
      throw Error(name_, e);
    }
  }

  VtkType type_of(const std::string& text) const {
    const auto type = vtk_type(text);
    if (!type) refuse("data type", text, "a numeric one (char, unsigned_char ... double)");
    return *type;
  }

  void skip_values(const VtkType& type, std::int64_t count) {
    if (!ascii_) {
      (void)scanner_.line();
      scanner_.skip(product(count, type.bytes));
      return;
    }
    for (std::int64_t n = 0; n < count; ++n) {
      if (scanner_.word().empty()) {
        throw Error(name_ + ": data end after " + std::to_string(n) + " of " + std::to_string(count) +
                    " numbers");
      }
    }
  }

  /// ASCII: a line each. Binary: a length whose first two bits say how many bytes it has, then the text.
  void skip_strings(std::int64_t count) {
    (void)scanner_.line();
    for (std::int64_t n = 0; n < count; ++n) {
      if (scanner_.at_end()) throw Error(name_ + ": ends within an array of strings");
      if (ascii_) {
        (void)scanner_.line();
        continue;
      }
      unsigned char first = 0;
      scanner_.read_exactly(&first, 1);
      static constexpr int kMoreBytes[] = {7, 3, 1, 0};
      std::uint64_t length = first & 63U;
      for (int b = kMoreBytes[first >> 6]; b > 0; --b) {
        unsigned char next = 0;
        scanner_.read_exactly(&next, 1);
        length = length << 8 | next;
      }
      scanner_.skip(static_cast<std::int64_t>(length));
    }
  }

  void skip_named(std::int64_t components) {
    (void)word();
    const VtkType type = type_of(word());
    skip_values(type, product(components, tuples_));
  }

  bool wanted(const std::string& array, std::int64_t components) {
    seen_ += (seen_.empty() ? "" : ", ") + in_quotes(array) +
             (components == 1 ? "" : " (" + std::to_string(components) + " components)");
    if (!options_.array.empty() && options_.array == array && components != 1) {
      throw Error(name_ + ": array " + in_quotes(array) + " has " + std::to_string(components) +
                  " components, expected a scalar");
    }
    return components == 1 && (options_.array.empty() || options_.array == array);
  }

  volume::Volume voxels(const VtkType& type, const std::string& type_name) {
    if (!type.voxel) refuse("data type", type_name, "char, unsigned_char ... unsigned_int, float or double");
    VoxelLayout layout;
    layout.type = *type.voxel;
    layout.geometry = checked_geometry();
    layout.big_endian = true;
    if (ascii_) return read_ascii(scanner_, layout, options_);
    (void)scanner_.line();
    return read_binary(scanner_, layout, options_);
  }

  std::optional<volume::Volume> scalars() {
    if (tuples_ == 0) throw Error(name_ + ": SCALARS before POINT_DATA or CELL_DATA");
    const std::string rest = scanner_.line();
    const auto words = words_of(rest);
    if (words.size() < 2 || words.size() > 3)
      refuse("SCALARS", rest, "a name, a type and perhaps a number of components");
    const std::int64_t components = words.size() == 3 ? parse_integer({name_, "SCALARS"}, words[2]) : 1;
    if (components < 1 || components > 4) refuse("SCALARS", rest, "1 to 4 components");
    const std::string table = word();
    if (lower_case(table) != "lookup_table") refuse("the line after SCALARS", table, "LOOKUP_TABLE");
    (void)word();
    const VtkType type = type_of(words[1]);
    if (wanted(words[0], components)) return voxels(type, words[1]);
    skip_values(type, product(components, tuples_));
    return std::nullopt;
  }

  std::optional<volume::Volume> field_arrays() {
    (void)word();
    const std::int64_t arrays = integer("number of FIELD arrays");
    for (std::int64_t n = 0; n < arrays; ++n) {
      const std::string array = word();
      if (array.empty()) throw Error(name_ + ": ends within a FIELD");
      if (lower_case(array) == "metadata") {  // belongs to the array before
        (void)section("metadata");
        --n;
        continue;
      }
      const std::int64_t components = integer("components of a FIELD array");
      const std::int64_t tuples = integer("tuples of a FIELD array");
      const std::string type_name = word();
      if (lower_case(type_name) == "string") {
        skip_strings(product(components, tuples));
        continue;
      }
      const VtkType type = type_of(type_name);
      if (tuples_ > 0 && tuples == tuples_ && wanted(array, components)) return voxels(type, type_name);
      skip_values(type, product(components, tuples));
    }
    return std::nullopt;
  }

  /// The next word after the voxels must be a keyword or a FIELD array's name: what else it is shows that the
  /// dimensions or the type are too small for the data.
  void check_what_follows() {
    const std::string_view next = scanner_.word();
    for (const char c : next) {
      if (c < ' ' || c > '~') {
        throw Error(name_ + ": holds more data than its DIMENSIONS and type say");
      }
    }
    if (ascii_ && !next.empty() &&
        (std::isdigit(static_cast<unsigned char>(next[0])) != 0 || next[0] == '-')) {
      throw Error(name_ + ": holds more data than its DIMENSIONS and type say");
    }
  }
};

}  // namespace

bool is_vtk_legacy(std::string_view start) {
  return start.compare(0, 14, "# vtk DataFile") == 0;
}

volume::Volume read_vtk_legacy(InputFile& file, const ReadOptions& options) {
  return LegacyReader(file, options).read();
}

}  // namespace vol::io
