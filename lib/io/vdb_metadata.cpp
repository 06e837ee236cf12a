#include "io/vdb_metadata.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string_view>

#include "base/checked.h"
#include "base/error.h"

namespace vol::io {
namespace {

constexpr std::array kOwnKeys = {
    "precis.boundary",  "precis.content",        "precis.dims",     "precis.direction",  "precis.extended",
    "precis.extension", "precis.initialisation", "precis.levels",   "precis.origin",     "precis.range",
    "precis.space",     "precis.spacing",        "precis.subbands", "precis.voxel_type", "precis.wavelet"};
constexpr int kMaxLevels = 62;

std::string text(double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

template <class Range>
std::string joined(const Range& values) {
  std::string line;
  for (const auto& value : values) {
    if (!line.empty()) line += ' ';
    if constexpr (std::is_floating_point_v<std::decay_t<decltype(value)>>) {
      line += text(value);
    } else {
      line += std::to_string(value);
    }
  }
  return line;
}

const std::string& entry(const Metadata& metadata, const std::string& key) {
  const auto found = metadata.find(key);
  if (found == metadata.end()) throw Error("metadata lack " + key);
  return found->second;
}

template <class Number, std::size_t n>
std::array<Number, n> parsed(const std::string& line, const std::string& what) {
  std::array<Number, n> values{};
  const char* at = line.data();
  const char* const end = at + line.size();
  for (auto& value : values) {
    while (at != end && *at == ' ') ++at;
    const auto result = std::from_chars(at, end, value);
    if (result.ec != std::errc{}) {
      throw Error("metadata " + what + ": expected " + std::to_string(n) + " numbers");
    }
    at = result.ptr;
  }
  if (at != end) throw Error("metadata " + what + ": expected " + std::to_string(n) + " numbers");
  return values;
}

template <class Number, std::size_t n>
std::array<Number, n> numbers(const Metadata& metadata, const std::string& key) {
  return parsed<Number, n>(entry(metadata, key), key);
}

template <std::size_t n>
std::size_t choice(const Metadata& metadata, const std::string& key,
                   const std::array<const char*, n>& names) {
  const auto found = std::find(names.begin(), names.end(), entry(metadata, key));
  if (found == names.end()) throw Error("metadata " + key + ": unknown value");
  return static_cast<std::size_t>(found - names.begin());
}

constexpr std::array kBoundaries = {"periodic", "symmetric"};
constexpr std::array kExtensions = {"replicate", "mirror", "zero"};
constexpr std::array kInitialisations = {"samples", "interpolate"};
constexpr std::array kSpaces = {"none", "LPS", "RAS"};

}  // namespace

std::string subband_name(int level, int orientation) {
  return "level" + std::to_string(level) + "." + wavelet::orientation_name(orientation);
}

bool is_own_key(const std::string& key) {
  return std::find(kOwnKeys.begin(), kOwnKeys.end(), key) != kOwnKeys.end();
}

void put_volume(Metadata& metadata, const volume::GridGeometry& geometry, volume::VoxelType type,
                volume::Range range) {
  metadata["precis.dims"] = joined(geometry.dims);
  metadata["precis.spacing"] = joined(geometry.spacing);
  metadata["precis.origin"] = joined(geometry.origin);
  metadata["precis.direction"] =
      joined(geometry.direction.reshaped());  // the i, j, k axes one after the other
  metadata["precis.space"] = name(geometry.space);
  metadata["precis.voxel_type"] = name(type);
  metadata["precis.range"] = joined(std::array{range.min, range.max});
}

volume::GridGeometry geometry_from(const Metadata& metadata) {
  volume::GridGeometry geometry;
  geometry.dims = numbers<std::int64_t, 3>(metadata, "precis.dims");
  geometry.spacing = Vec3(numbers<double, 3>(metadata, "precis.spacing").data());
  geometry.origin = Vec3(numbers<double, 3>(metadata, "precis.origin").data());
  geometry.direction = Mat3(numbers<double, 9>(metadata, "precis.direction").data());
  geometry.space = static_cast<volume::Space>(choice(metadata, "precis.space", kSpaces));
  geometry.validate();
  return geometry;
}

volume::VoxelType voxel_type_from(const Metadata& metadata) {
  return volume::voxel_type_from_name(entry(metadata, "precis.voxel_type"));
}

template <class T>
void put_decomposition(Metadata& metadata, const wavelet::Decomposition<T>& d) {
  metadata[kContentKey] = "coefficients";
  put_volume(metadata, d.geometry, d.voxel_type, d.range);
  metadata["precis.wavelet"] = d.wavelet;
  metadata["precis.levels"] = std::to_string(d.levels);
  metadata["precis.boundary"] = kBoundaries[static_cast<std::size_t>(d.boundary)];
  metadata["precis.extension"] = kExtensions[static_cast<std::size_t>(d.extension)];
  metadata["precis.initialisation"] = kInitialisations[static_cast<std::size_t>(d.initialisation)];
  metadata["precis.extended"] = joined(d.extended_dims);
  std::string subbands;  // "level orientation lower dims;" each
  for (const auto& s : d.subbands) {
    subbands +=
        joined(std::array{s.level, s.orientation}) + ' ' + joined(s.lower) + ' ' + joined(s.dims) + ';';
  }
  metadata["precis.subbands"] = subbands;
}

template <class T>
wavelet::Decomposition<T> decomposition_from(const Metadata& metadata) {
  wavelet::Decomposition<T> d;
  d.geometry = geometry_from(metadata);
  d.voxel_type = voxel_type_from(metadata);
  const auto range = numbers<double, 2>(metadata, "precis.range");
  d.range = {range[0], range[1]};
  d.wavelet = entry(metadata, "precis.wavelet");
  d.levels = numbers<int, 1>(metadata, "precis.levels")[0];
  if (d.levels < 0 || d.levels > kMaxLevels) throw Error("metadata precis.levels: out of range");
  d.boundary = static_cast<wavelet::Boundary>(choice(metadata, "precis.boundary", kBoundaries));
  d.extension = static_cast<wavelet::Extension>(choice(metadata, "precis.extension", kExtensions));
  if (metadata.contains("precis.initialisation")) {  // older files have the samples
    d.initialisation =
        static_cast<wavelet::Initialisation>(choice(metadata, "precis.initialisation", kInitialisations));
  }
  d.extended_dims = numbers<std::int64_t, 3>(metadata, "precis.extended");
  (void)checked_count(d.extended_dims);
  for (int a = 0; a < 3; ++a) {
    if (d.extended_dims[a] < d.geometry.dims[a])
      throw Error("metadata precis.extended: less than the volume's dims");
  }
  std::istringstream lines(entry(metadata, "precis.subbands"));
  for (std::string line; std::getline(lines, line, ';');) {
    const auto n = parsed<std::int64_t, 8>(line, "precis.subbands");
    wavelet::Subband<T> s;
    const bool detail = n[1] != 0;
    if (n[1] < 0 || n[1] > 7 || n[0] < (detail ? 1 : 0) || n[0] > d.levels || (!detail && n[0] != d.levels)) {
      throw Error("metadata precis.subbands: level or orientation out of range");
    }
    s.level = static_cast<int>(n[0]);
    s.orientation = static_cast<int>(n[1]);
    s.lower = {n[2], n[3], n[4]};
    s.dims = {n[5], n[6], n[7]};
    (void)checked_count(s.dims);
    for (const auto& other : d.subbands) {
      if (other.level == s.level && other.orientation == s.orientation) {
        throw Error("metadata precis.subbands: " + subband_name(s.level, s.orientation) + " occurs twice");
      }
    }
    d.subbands.push_back(std::move(s));
  }
  if (d.subbands.empty() || d.subbands.front().orientation != 0) {
    throw Error("metadata precis.subbands: expected the approximation first");
  }
  return d;
}

template void put_decomposition(Metadata&, const wavelet::Decomposition<float>&);
template void put_decomposition(Metadata&, const wavelet::Decomposition<double>&);
template wavelet::Decomposition<float> decomposition_from(const Metadata&);
template wavelet::Decomposition<double> decomposition_from(const Metadata&);

}  // namespace vol::io
