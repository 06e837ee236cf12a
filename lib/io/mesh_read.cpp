#include "io/mesh_read.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "io/mesh.h"

namespace vol::io {
namespace {

using mesh::TriangleMesh;

[[noreturn]] void fail(const InputFile& file, const std::string& what) {
  throw Error(display_name(file.path()) + ": " + what);
}

/// \param word  of ASCII letters
bool is_keyword(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

std::array<double, 3> take_numbers(const InputFile& file, std::string_view& rest) {
  std::array<double, 3> v{};
  for (double& x : v) {
    if (!parse_word(take_word(rest), x)) fail(file, "three numbers were expected");
  }
  return v;
}

std::array<double, 3> take_position(const InputFile& file, std::string_view& rest) {
  const std::array<double, 3> v = take_numbers(file, rest);
  for (const double x : v) {
    if (!std::isfinite(x)) fail(file, "a vertex has a coordinate that is not finite");
  }
  return v;
}

/// A line of OBJ with those that continue it, up to the comment.
std::string read_obj_line(InputFile& file) {
  std::string line;
  while (true) {
    const std::string part = file.read_line();
    const std::size_t comment = part.find('#');
    line.append(part, 0, comment);
    if (comment != std::string::npos) return line;
    if (line.ends_with('\r')) line.pop_back();
    if (!line.ends_with('\\')) return line;
    line.back() = ' ';
    if (file.at_end()) return line;
  }
}

/// A corner's part "v", "v/t", "v/t/n" or "v//n" of OBJ: a number from 1, or back from the last, -1.
std::int64_t obj_number(const InputFile& file, std::string_view word, std::size_t have) {
  std::int64_t n = 0;
  if (!parse_word(word, n)) fail(file, "a face has a corner that is no number");
  const std::int64_t index = n > 0 ? n - 1 : n + static_cast<std::int64_t>(have);
  if (n == 0 || index < 0 || index >= static_cast<std::int64_t>(have)) {
    fail(file, "a face has vertex or normal " + std::to_string(n) + " of " + std::to_string(have));
  }
  return index;
}

TriangleMesh read_obj(InputFile& file) {
  TriangleMesh mesh;
  bool same_numbers = true;             // of vertices and normals, at every corner
  bool only_comments = !file.at_end();  // as write_mesh makes it of an empty mesh
  while (!file.at_end()) {
    const std::string line = read_obj_line(file);
    std::string_view rest = line;
    const std::string_view word = take_word(rest);
    only_comments = only_comments && word.empty();
    if (word == "v") {
      mesh.positions.push_back(take_position(file, rest));
      if (mesh.positions.size() >= std::numeric_limits<std::uint32_t>::max())
        fail(file, "over 2^32 - 2 vertices");
    } else if (word == "vn") {
      mesh.normals.push_back(unit_normal(take_numbers(file, rest)));
    } else if (word == "f") {
      std::uint32_t first = 0, before = 0;
      int corners = 0;
      for (std::string_view corner = take_word(rest); !corner.empty(); corner = take_word(rest)) {
        const std::size_t slash = corner.find('/');
        const std::int64_t v = obj_number(file, corner.substr(0, slash), mesh.positions.size());
        const std::size_t second = slash == std::string_view::npos ? slash : corner.find('/', slash + 1);
        same_numbers = same_numbers && second != std::string_view::npos &&
                       obj_number(file, corner.substr(second + 1), mesh.normals.size()) == v;
        const auto index = static_cast<std::uint32_t>(v);
        if (corners == 0) first = index;
        if (corners >= 2) mesh.triangles.push_back({first, before, index});
        before = index;
        ++corners;
      }
      if (corners < 3) fail(file, "a face has fewer than 3 corners");
    }
  }
  if (mesh.positions.empty() && !only_comments) fail(file, "has no vertices: is it an OBJ file?");
  require_faces(file, mesh);
  if (!same_numbers || mesh.normals.size() != mesh.positions.size()) mesh.normals.clear();
  return mesh;
}

void add_corner(const InputFile& file, TriangleMesh& mesh, const std::array<double, 3>& p) {
  if (mesh.positions.size() >= std::numeric_limits<std::uint32_t>::max()) fail(file, "over 2^32 - 1 corners");
  mesh.positions.push_back(p);
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  if (n % 3 == 0) mesh.triangles.push_back({n - 3, n - 2, n - 1});
}

/// By the lines "vertex x y z"; the others say nothing more.
TriangleMesh read_text_stl(InputFile& file) {
  TriangleMesh mesh;
  while (!file.at_end()) {
    const std::string line = file.read_line();
    std::string_view rest = line;
    if (is_keyword(take_word(rest), "vertex")) add_corner(file, mesh, take_position(file, rest));
  }
  if (mesh.positions.empty() || mesh.positions.size() % 3 != 0) fail(file, "STL without whole triangles");
  return mesh;
}

TriangleMesh read_stl(InputFile& file) {
  std::uint32_t count = 0;
  const std::string_view head = file.peek(84);
  if (head.size() == 84) std::memcpy(&count, head.data() + 80, 4);
  const std::int64_t size = 84 + 50 * std::int64_t{count};
  const bool pipe = file.size() < 0;
  // Binary files may begin with "solid" too: then they have the size that they say, or a zero in their head.
  const bool solid = is_keyword(head.substr(0, 5), "solid");
  if (solid && (pipe ? head.find('\0') == head.npos : file.size() != size)) return read_text_stl(file);
  if (head.size() < 84)
    fail(file, "neither the text of an STL file nor the 84 bytes that a binary one begins with");
  const std::string triangles = std::to_string(count) + " triangles has " + std::to_string(size);
  if (!pipe && file.size() != size) {
    fail(file, std::to_string(file.size()) + " bytes, where a binary STL of " + triangles);
  }
  file.skip(84);
  TriangleMesh mesh;
  for (std::uint32_t t = 0; t < count; ++t) {
    char record[50];
    file.read_exactly(record, sizeof(record));
    float x[12];
    std::memcpy(x, record, sizeof(x));
    for (int c = 1; c <= 3; ++c) {
      const std::array<double, 3> p{double{x[3 * c]}, double{x[3 * c + 1]}, double{x[3 * c + 2]}};
      for (const double each : p) {
        if (!std::isfinite(each)) fail(file, "a triangle has a coordinate that is not finite");
      }
      add_corner(file, mesh, p);
    }
  }
  if (!file.at_end()) fail(file, "more bytes come, where a binary STL of " + triangles);
  return mesh;
}

}  // namespace

std::array<float, 3> unit_normal(const std::array<double, 3>& n) {
  if (!std::isfinite(n[0]) || !std::isfinite(n[1]) || !std::isfinite(n[2])) return {};
  const double largest = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
  if (largest == 0) return {};
  // By the largest first: squares of the others neither overflow nor all vanish.
  const double length = std::hypot(n[0] / largest, n[1] / largest, n[2] / largest);
  // Three components rounded to floats change the length by up to 6e-8 of it.
  const bool unit = std::abs(largest * length - 1) < 1e-6;
  std::array<float, 3> result{};
  for (std::size_t a = 0; a < 3; ++a) {
    result[a] = static_cast<float>(unit ? n[a] : n[a] / largest / length);
  }
  return result;
}

void require_faces(const InputFile& file, const TriangleMesh& mesh) {
  if (mesh.triangles.empty() && !mesh.positions.empty()) {
    fail(file, "has no faces among its " + std::to_string(mesh.positions.size()) + " vertices");
  }
}

TriangleMesh read_mesh(const std::filesystem::path& path) {
  InputFile file(path);
  const std::string_view head = file.peek(4);
  if (head == "ply\n" || head == "ply\r") return read_ply(file);
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".obj") return read_obj(file);
  if (extension == ".stl") return read_stl(file);
  fail(file, "not a mesh: PLY, or a file named .obj or .stl, was expected");
}

}  // namespace vol::io
