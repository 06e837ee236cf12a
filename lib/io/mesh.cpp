#include "io/mesh.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/buffer.h"
#include "base/error.h"
#include "base/parallel.h"
#include "io/file.h"

namespace vol::io {
namespace {

static_assert(std::endian::native == std::endian::little, "mesh files are written as they stand in memory");

using mesh::TriangleMesh;

std::string format_of(const std::filesystem::path& path, const MeshWriteOptions& options) {
  std::string format = options.format;
  if (format.empty()) {
    format = is_standard_stream(path) ? "ply" : path.extension().string();
    if (!format.empty() && format[0] == '.') format.erase(0, 1);
    for (char& c : format) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  if (format != "ply" && format != "obj" && format != "stl") {
    throw Error(output_name(path) + ": a mesh is written as .ply, .obj or .stl");
  }
  if (format == "stl" && options.double_precision) throw Error(output_name(path) + ": STL holds f32 only");
  return format;
}

/// Comments of one line: an attribute's line ends become blanks.
std::string comments(const MeshWriteOptions& options, const char* mark) {
  std::string text;
  for (const auto& [key, value] : options.attributes) {
    std::string line = key + " " + value;
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    text += std::string(mark) + line + "\n";
  }
  return text;
}

/// Records of a fixed size, made in parallel and written in order, a part of the mesh at a time.
template <class Fill>
void write_records(OutputFile& out, std::size_t count, std::size_t size, const Fill& fill) {
  constexpr std::size_t kAtOnce = 1 << 18;
  Buffer<char> bytes(std::min(count, kAtOnce) * size);
  for (std::size_t first = 0; first < count; first += kAtOnce) {
    const std::size_t n = std::min(kAtOnce, count - first);
    parallel_for(0, static_cast<std::int64_t>(n), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        fill(first + static_cast<std::size_t>(i), bytes.data() + static_cast<std::size_t>(i) * size);
      }
    });
    out.write(bytes.data(), n * size);
  }
}

template <class T>
char* put(char* to, T value) {
  std::memcpy(to, &value, sizeof(T));
  return to + sizeof(T);
}

void write_ply(OutputFile& out, const TriangleMesh& mesh, const MeshWriteOptions& options) {
  const bool normals = !mesh.normals.empty();
  const bool several = options.parts.size() > 1;
  const std::string real = options.double_precision ? "double" : "float";
  // Readers know int better than uint; it reaches as far as they do.
  const char* index = mesh.positions.size() <= std::size_t{1} << 31 ? "int" : "uint";
  std::string header = "ply\nformat binary_little_endian 1.0\n" + comments(options, "comment ");
  header += "element vertex " + std::to_string(mesh.positions.size()) + "\n";
  for (const char* axis : {"x", "y", "z"}) header += "property " + real + " " + axis + "\n";
  if (normals) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (several) header += "property double " + options.part_name + "\n";
  header += "element face " + std::to_string(mesh.triangles.size()) + "\nproperty list uchar " + index +
            " vertex_indices\nend_header\n";
  out.write(header);
  std::vector<std::size_t> ends;
  std::size_t end = 0;
  for (const auto& part : options.parts) ends.push_back(end += part.vertices);
  const std::size_t size = 3 * (options.double_precision ? 8 : 4) + (normals ? 12 : 0) + (several ? 8 : 0);
  write_records(out, mesh.positions.size(), size, [&](std::size_t v, char* to) {
    for (const double x : mesh.positions[v])
      to = options.double_precision ? put(to, x) : put(to, static_cast<float>(x));
    if (normals) to = put(to, mesh.normals[v]);
    if (several) {
      const auto part = std::upper_bound(ends.begin(), ends.end(), v) - ends.begin();
      put(to, options.parts[static_cast<std::size_t>(part)].value);
    }
  });
  write_records(out, mesh.triangles.size(), 13,
                [&](std::size_t t, char* to) { put(put(to, std::uint8_t{3}), mesh.triangles[t]); });
}

void append_number(std::string& text, auto value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof(digits), value).ptr);
}

void write_obj(OutputFile& out, const TriangleMesh& mesh, const MeshWriteOptions& options) {
  std::string text = comments(options, "# ");
  const auto flush = [&](bool all) {
    if (!all && text.size() < (1 << 20)) return;
    out.write(text);
    text.clear();
  };
  for (const auto& p : mesh.positions) {
    text += 'v';
    for (const double x : p) {
      text += ' ';
      if (options.double_precision) {
        append_number(text, x);
      } else {
        append_number(text, static_cast<float>(x));
      }
    }
    text += '\n';
    flush(false);
  }
  for (const auto& n : mesh.normals) {
    text += "vn";
    for (const float x : n) {
      text += ' ';
      append_number(text, x);
    }
    text += '\n';
    flush(false);
  }
  std::size_t part = 0;
  std::size_t part_end = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    while (options.parts.size() > 1 && part < options.parts.size() && t == part_end) {
      text += "g " + options.part_name + "_";
      append_number(text, options.parts[part].value);
      text += '\n';
      part_end += options.parts[part++].triangles;
    }
    text += 'f';
    for (const std::uint32_t v : mesh.triangles[t]) {
      const std::uint64_t number = std::uint64_t{v} + 1;
      text += ' ';
      append_number(text, number);
      if (mesh.normals.empty()) continue;
      text += "//";
      append_number(text, number);
    }
    text += '\n';
    flush(false);
  }
  flush(true);
}

void write_stl(OutputFile& out, const TriangleMesh& mesh) {
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max())
    throw Error("too many triangles for STL: write .ply");
  char header[84] = "binary STL";
  put(header + 80, static_cast<std::uint32_t>(mesh.triangles.size()));
  out.write(header, sizeof(header));
  write_records(out, mesh.triangles.size(), 50, [&](std::size_t t, char* to) {
    const auto& c = mesh.triangles[t];
    double e[2][3];
    for (std::size_t n = 0; n < 2; ++n) {
      for (std::size_t a = 0; a < 3; ++a) e[n][a] = mesh.positions[c[n + 1]][a] - mesh.positions[c[0]][a];
    }
    const double normal[3] = {e[0][1] * e[1][2] - e[0][2] * e[1][1], e[0][2] * e[1][0] - e[0][0] * e[1][2],
                              e[0][0] * e[1][1] - e[0][1] * e[1][0]};
    const double length = std::hypot(normal[0], normal[1], normal[2]);
    for (const double x : normal) to = put(to, static_cast<float>(length > 0 ? x / length : 0));
    for (const std::uint32_t v : c) {
      for (const double x : mesh.positions[v]) to = put(to, static_cast<float>(x));
    }
    put(to, std::uint16_t{0});
  });
}

}  // namespace

std::string require_mesh_format(const std::filesystem::path& path, const MeshWriteOptions& options) {
  std::string format = format_of(path, options);
  if (!is_standard_stream(path)) require_writable(path);
  return format;
}

std::vector<std::string> write_mesh(const std::filesystem::path& path, const TriangleMesh& mesh,
                                    const MeshWriteOptions& options) {
  const std::string format = format_of(path, options);
  OutputFile out(path);
  std::vector<std::string> lost;
  if (format == "ply") {
    write_ply(out, mesh, options);
  } else if (format == "obj") {
    write_obj(out, mesh, options);
  } else {
    write_stl(out, mesh);
    if (!mesh.normals.empty()) lost.push_back(output_name(path) + ": STL has no normals at vertices");
    if (options.parts.size() > 1)
      lost.push_back(output_name(path) + ": STL does not tell one " + options.part_name + " from another");
  }
  out.commit();
  return lost;
}

}  // namespace vol::io
