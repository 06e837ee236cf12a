#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "volume/grid_geometry.h"

// Private to lib/io: the small grammar that text headers share. Every error names the file and the field.
namespace vol::io {

[[nodiscard]] std::string_view trimmed(std::string_view text);
[[nodiscard]] std::string lower_case(std::string_view text);
[[nodiscard]] std::vector<std::string> words_of(std::string_view text);

/// Text from a file as a message shows it: in quotes, at most 40 characters, what does not print replaced.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// Where a value stands: for the messages of the parsers below.
struct Field {
  const std::string& file;
  std::string_view name;
  [[noreturn]] void refuse(std::string_view text, std::string_view expected) const;
};

/// The whole text as one number; NaN and infinity are refused.
[[nodiscard]] double parse_number(const Field& field, std::string_view text);
[[nodiscard]] std::int64_t parse_integer(const Field& field, std::string_view text);
[[nodiscard]] std::vector<double> parse_numbers(const Field& field, std::string_view text, std::size_t n);
[[nodiscard]] std::vector<std::int64_t> parse_integers(const Field& field, std::string_view text,
                                                       std::size_t n);
[[nodiscard]] Vec3 parse_vector(const Field& field, std::string_view text);

/// Shortest text that reads back as the same double.
[[nodiscard]] std::string shortest(double value);
/// "x y z" of shortest().
[[nodiscard]] std::string shortest(const Vec3& v, const char* separator = " ");

/// The files of `pattern`, which holds one %d (or %03d, %i), for first, first + step ... last: exactly
/// `count` of them, or an error.
[[nodiscard]] std::vector<std::string> numbered_files(const Field& field, std::string_view pattern,
                                                      std::int64_t first, std::int64_t last,
                                                      std::int64_t step, std::int64_t count);

/// A data file as a header names it: relative to the header's folder (for standard input, the current one).
[[nodiscard]] std::filesystem::path beside(const std::filesystem::path& header, std::string_view name);

/// Sets spacing and direction from the world steps between samples, the columns of `steps`, of which only the
/// first `known` are given: the others become unit vectors at right angles to them.
void set_axes(volume::GridGeometry& geometry, Mat3 steps, int known = 3);

/// Turns between LPS and RAS world coordinates: x and y change sign.
void flip_x_and_y(volume::GridGeometry& geometry);

}  // namespace vol::io
