#include "cli/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

#include "base/checked.h"
#include "base/error.h"

namespace vol::cli {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

[[noreturn]] void refuse(const std::string& option, const std::string& text, const std::string& expected) {
  throw Error(option + " " + text + ": expected " + expected);
}

template <class T>
bool parse(const std::string& text, T& value) {
  if (text.starts_with("+-")) return false;  // from_chars takes no plus of its own, but a minus
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* last = text.data() + text.size();
  const auto result = std::from_chars(first, last, value);
  return result.ec == std::errc() && result.ptr == last;
}

}  // namespace

Dims parse_dims(const std::string& option, const std::string& text) {
  const auto parts = split(text, 'x');
  Dims dims{};
  if (parts.size() != 1 && parts.size() != 3)
    refuse(option, text, "NXxNYxNZ, such as 64x48x32, or N for a cube");
  for (std::size_t a = 0; a < 3; ++a) {
    if (!parse(parts[parts.size() == 3 ? a : 0], dims[a]) || dims[a] < 1) {
      refuse(option, text, "NXxNYxNZ, such as 64x48x32, each at least 1");
    }
  }
  (void)checked_count(dims);
  return dims;
}

std::array<int, 2> parse_image_size(const std::string& option, const std::string& text) {
  const auto parts = split(text, 'x');
  std::array<int, 2> size{};
  if (parts.size() > 2) refuse(option, text, "WIDTHxHEIGHT, such as 512x512");
  for (std::size_t a = 0; a < 2; ++a) {
    if (!parse(parts[parts.size() == 2 ? a : 0], size[a]) || size[a] < 1) {
      refuse(option, text, "WIDTHxHEIGHT, such as 512x512, each at least 1");
    }
  }
  return size;
}

Vec3 parse_vec3(const std::string& option, const std::string& text) {
  const auto parts = split(text, ',');
  Vec3 v;
  if (parts.size() != 1 && parts.size() != 3) refuse(option, text, "X,Y,Z or one number for all three");
  for (int a = 0; a < 3; ++a) {
    if (!parse(parts[parts.size() == 3 ? static_cast<std::size_t>(a) : 0], v[a]) || !std::isfinite(v[a])) {
      refuse(option, text, "finite numbers X,Y,Z");
    }
  }
  return v;
}

std::vector<double> parse_numbers(const std::string& option, const std::vector<std::string>& texts) {
  std::vector<double> values;
  for (const std::string& text : texts) {
    for (const std::string& part : split(text, ',')) {
      double value = 0;
      if (!parse(part, value) || !std::isfinite(value))
        refuse(option, text, "finite numbers VALUE,VALUE,...");
      values.push_back(value);
    }
  }
  return values;
}

std::vector<int> parse_labels(const std::string& option, const std::string& text) {
  std::vector<int> labels;
  for (const auto& part : split(text, ',')) {
    int label = 0;
    if (!parse(part, label) || label < 0 || label > 255) {
      refuse(option, text, "labels, whole numbers from 0 to 255: LABEL,LABEL,...");
    }
    if (std::find(labels.begin(), labels.end(), label) != labels.end()) {
      refuse(option, text, "every label once");
    }
    labels.push_back(label);
  }
  return labels;
}

Vec3 parse_colour(const std::string& option, const std::string& text) {
  const Vec3 colour = parse_vec3(option, text);
  if (colour.minCoeff() < 0 || colour.maxCoeff() > 1) refuse(option, text, "numbers from 0 to 1");
  return colour;
}

std::array<double, 2> parse_view(const std::string& option, const std::string& text) {
  const auto parts = split(text, ',');
  std::array<double, 2> view{};
  if (parts.size() != 2 || !parse(parts[0], view[0]) || !parse(parts[1], view[1]) ||
      !std::isfinite(view[0]) || !(std::abs(view[1]) <= 90)) {
    refuse(option, text, "AZIMUTH,ELEVATION in degrees, elevation from -90 to 90");
  }
  return view;
}

Region parse_region(const std::string& option, const std::string& text) {
  const auto corners = split(text, ':');
  Region region{};
  constexpr const char* kExpected = "x0,y0,z0:x1,y1,z1, voxel indices, half open, each x0 < x1";
  if (corners.size() != 2) refuse(option, text, kExpected);
  for (std::size_t c = 0; c < 2; ++c) {
    const auto parts = split(corners[c], ',');
    if (parts.size() != 3) refuse(option, text, kExpected);
    for (std::size_t a = 0; a < 3; ++a) {
      if (!parse(parts[a], c == 0 ? region.lower[a] : region.upper[a])) refuse(option, text, kExpected);
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    if (region.lower[a] >= region.upper[a]) refuse(option, text, kExpected);
  }
  return region;
}

double parse_step(const std::string& option, const std::string& text, double smallest_spacing) {
  const bool in_voxels = text.ends_with('v');
  double step = 0;
  if (!parse(in_voxels ? text.substr(0, text.size() - 1) : text, step) || !(step > 0) ||
      !std::isfinite(step)) {
    refuse(option, text, "a positive world length, or multiples of the smallest spacing such as 0.5v");
  }
  return in_voxels ? step * smallest_spacing : step;
}

std::string check_positive(const std::string& text) {
  double x = 0;
  return parse(text, x) && x > 0 && std::isfinite(x) ? "" : "expected a positive number, got " + text;
}

std::string check_non_negative(const std::string& text) {
  double x = 0;
  return parse(text, x) && x >= 0 ? "" : "expected a number of at least 0, got " + text;
}

std::string check_finite(const std::string& text) {
  double x = 0;
  return parse(text, x) && std::isfinite(x) ? "" : "expected a finite number, got " + text;
}

std::string check_whole_number(const std::string& text) {
  std::int64_t n = 0;
  return parse(text, n) && n >= 0 ? "" : "expected a whole number from 0 to 2^63 - 1, got " + text;
}

}  // namespace vol::cli
