#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <string>
#include <string_view>

#include "io/file.h"
#include "mesh/triangle_mesh.h"

// Private to lib/io: what the readers of meshes share.
namespace vol::io {

[[nodiscard]] mesh::TriangleMesh read_ply(InputFile& file);

/// A normal as TriangleMesh holds it: of length 1, or 0 where it has no direction or a component that is not
/// finite. One whose length is 1 but for a float's rounding stays as it is.
[[nodiscard]] std::array<float, 3> unit_normal(const std::array<double, 3>& n);

/// Throws where a file has vertices and no face: a cloud of points, or faces by other names. What has neither
/// is a mesh too, of an isosurface that is nowhere.
void require_faces(const InputFile& file, const mesh::TriangleMesh& mesh);

/// The next word of a line, which is taken off it; empty at its end.
[[nodiscard]] inline std::string_view take_word(std::string_view& line) {
  constexpr std::string_view kBlanks = " \t\r\v\f";
  const std::size_t begin = std::min(line.find_first_not_of(kBlanks), line.size());
  const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// Whether all of a word is one number.
template <class T>
[[nodiscard]] bool parse_word(std::string_view word, T& value) {
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
  return result.ec == std::errc() && result.ptr == word.data() + word.size();
}

}  // namespace vol::io
