#include "io/header_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "base/error.h"
#include "io/file.h"

namespace vol::io {
namespace {

bool is_space(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

template <class T>
bool parse_all(std::string_view text, T& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc{} && result.ptr == end;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at < text.size();) {
    while (at < text.size() && is_space(text[at])) ++at;
    std::size_t stop = at;
    while (stop < text.size() && !is_space(text[stop])) ++stop;
    if (stop > at) words.emplace_back(text.substr(at, stop - at));
    at = stop;
  }
  return words;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown + (text.size() > kLongest ? "...'" : "'");
}

void Field::refuse(std::string_view text, std::string_view expected) const {
  throw Error(file + ": " + std::string(name) + " is " + in_quotes(text) + ", expected " +
              std::string(expected));
}

double parse_number(const Field& field, std::string_view text) {
  double value = 0;
  if (!parse_all(trimmed(text), value) || !std::isfinite(value)) field.refuse(text, "a number");
  return value;
}

std::int64_t parse_integer(const Field& field, std::string_view text) {
  std::int64_t value = 0;
  if (!parse_all(trimmed(text), value)) field.refuse(text, "an integer");
  return value;
}

std::vector<double> parse_numbers(const Field& field, std::string_view text, std::size_t n) {
  const auto words = words_of(text);
  if (words.size() != n) field.refuse(text, std::to_string(n) + " numbers");
  std::vector<double> values;
  for (const auto& word : words) values.push_back(parse_number(field, word));
  return values;
}

std::vector<std::int64_t> parse_integers(const Field& field, std::string_view text, std::size_t n) {
  const auto words = words_of(text);
  if (words.size() != n) field.refuse(text, std::to_string(n) + " integers");
  std::vector<std::int64_t> values;
  for (const auto& word : words) values.push_back(parse_integer(field, word));
  return values;
}

Vec3 parse_vector(const Field& field, std::string_view text) {
  const auto values = parse_numbers(field, text, 3);
  return {values[0], values[1], values[2]};
}

std::string shortest(double value) {
  std::array<char, 32> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value == 0 ? 0.0 : value);
  return {text.data(), result.ptr};
}

std::string shortest(const Vec3& v, const char* separator) {
  return shortest(v.x()) + separator + shortest(v.y()) + separator + shortest(v.z());
}

std::vector<std::string> numbered_files(const Field& field, std::string_view pattern, std::int64_t first,
                                        std::int64_t last, std::int64_t step, std::int64_t count) {
  const std::size_t percent = pattern.find('%');
  std::size_t at = percent == std::string_view::npos ? pattern.size() : percent + 1;
  const bool zeros = at < pattern.size() && pattern[at] == '0';
  std::size_t width = 0;
  while (at < pattern.size() && std::isdigit(static_cast<unsigned char>(pattern[at])) != 0 && width < 100) {
    width = width * 10 + static_cast<std::size_t>(pattern[at++] - '0');
  }
  const bool valid = at < pattern.size() && (pattern[at] == 'd' || pattern[at] == 'i') && width < 32 &&
                     pattern.find('%', at) == std::string_view::npos;
  if (!valid) field.refuse(pattern, "a file name with one %d");
  constexpr std::int64_t kLargest = 1'000'000'000;
  if (step == 0 || std::abs(first) > kLargest || std::abs(last) > kLargest || std::abs(step) > kLargest ||
      (last - first) / step + 1 != count || (last - first) / step < 0) {
    throw Error(field.file + ": " + std::string(field.name) + " numbers its files from " +
                std::to_string(first) + " to " + std::to_string(last) + " by " + std::to_string(step) +
                ", expected " + std::to_string(count) + " of them");
  }
  std::vector<std::string> names;
  for (std::int64_t n = 0; n < count; ++n) {
    std::string digits = std::to_string(std::abs(first + n * step));
    const std::string sign = first + n * step < 0 ? "-" : "";
    while (digits.size() + sign.size() < width) digits.insert(digits.begin(), zeros ? '0' : ' ');
    names.push_back(std::string(pattern.substr(0, percent)) + sign + digits +
                    std::string(pattern.substr(at + 1)));
  }
  return names;
}

std::filesystem::path beside(const std::filesystem::path& header, std::string_view name) {
  const std::filesystem::path folder =
      is_standard_stream(header) ? std::filesystem::path() : header.parent_path();
  const std::filesystem::path path = folder / std::filesystem::path(std::string(name));
  return is_standard_stream(path) ? "." / path : path;
}

void set_axes(volume::GridGeometry& geometry, Mat3 steps, int known) {
  if (known <= 0) steps.col(0) = Vec3::UnitX();
  if (known <= 1) {
    Eigen::Index smallest = 0;
    steps.col(0).cwiseAbs().minCoeff(&smallest);
    steps.col(1) = Vec3::Unit(smallest).cross(steps.col(0)).stableNormalized();
  }
  if (known <= 2)
    steps.col(2) = steps.col(0).stableNormalized().cross(steps.col(1).stableNormalized()).stableNormalized();
  for (int a = 0; a < 3; ++a) {
    geometry.spacing[a] = steps.col(a).stableNorm();
    if (geometry.spacing[a] > 0) geometry.direction.col(a) = steps.col(a) / geometry.spacing[a];
  }
}

void flip_x_and_y(volume::GridGeometry& geometry) {
  for (int row = 0; row < 2; ++row) {
    geometry.direction.row(row) *= -1;
    geometry.origin[row] *= -1;
  }
}

}  // namespace vol::io
