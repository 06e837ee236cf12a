#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "io/nrrd_header.h"

namespace vol::io::nrrd {
namespace {

/// A step between samples for each axis, where `space directions` gives one.
std::vector<std::optional<Vec3>> parse_directions(const Header& header, const std::string& text,
                                                  std::size_t axes) {
  const Field field = header.field("space directions");
  std::vector<std::optional<Vec3>> directions;
  std::string_view rest = trimmed(text);
  while (!rest.empty()) {
    if (lower_case(rest.substr(0, 4)) == "none") {
      directions.emplace_back();
      rest = trimmed(rest.substr(4));
      continue;
    }
    const std::size_t close = rest.find(')');
    if (rest[0] != '(' || close == std::string_view::npos)
      field.refuse(text, "(x,y,z) or none for each axis");
    std::string inside(rest.substr(1, close - 1));
    std::replace(inside.begin(), inside.end(), ',', ' ');
    directions.emplace_back(parse_vector(field, inside));
    rest = trimmed(rest.substr(close + 1));
  }
  if (directions.size() != axes)
    field.refuse(text, "one vector or none for each of " + std::to_string(axes) + " axes");
  return directions;
}

/// The axes that become x, y, z: all of up to three; of more, those left when axes of one sample are dropped,
/// such without a direction first, then the outermost.
std::vector<std::size_t> spatial_axes(const Header& header, const std::vector<std::int64_t>& sizes,
                                      const std::vector<std::optional<Vec3>>& directions) {
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    const bool none = !directions.empty() && !directions[a];
    if (none && sizes[a] != 1) {
      throw Error(header.name + ": axis " + std::to_string(a) + " holds " + std::to_string(sizes[a]) +
                  " values a voxel (its space direction is none), expected a scalar volume");
    }
    if (!none) axes.push_back(a);
  }
  while (axes.size() > 3) {
    if (sizes[axes.front()] == 1) {
      axes.erase(axes.begin());
    } else if (sizes[axes.back()] == 1) {
      axes.pop_back();
    } else {
      const auto one = std::find_if(axes.begin(), axes.end(), [&](std::size_t a) { return sizes[a] == 1; });
      if (one == axes.end()) {
        header.field("dimension")
            .refuse(std::to_string(sizes.size()), "a scalar volume of 3 axes longer than 1");
      }
      axes.erase(one);
    }
  }
  return axes;
}

void refuse_vector_kinds(const Header& header, const std::vector<std::int64_t>& sizes) {
  const std::string* text = header.find("kinds");
  if (text == nullptr) return;
  const auto kinds = words_of(*text);
  if (kinds.size() != sizes.size()) header.field("kinds").refuse(*text, "one word for each axis");
  for (std::size_t a = 0; a < kinds.size(); ++a) {
    const std::string kind = lower_case(kinds[a]);
    if (sizes[a] == 1 || kind == "domain" || kind == "space" || kind == "time" || kind == "none" ||
        kind == "???" || kind == "list") {
      continue;
    }
    throw Error(header.name + ": axis " + std::to_string(a) + " is of kind " + in_quotes(kinds[a]) +
                ", expected a scalar volume");
  }
}

/// `spacings`, or what `axis mins` and `axis maxs` say; `nan` stands for not known.
std::vector<double> parse_per_axis(const Header& header, std::string_view field, std::size_t axes) {
  const std::string* text = header.find(field);
  if (text == nullptr) return {};
  const auto words = words_of(*text);
  if (words.size() != axes)
    header.field(field).refuse(*text, "one number for each of " + std::to_string(axes) + " axes");
  std::vector<double> values;
  for (const auto& word : words) {
    values.push_back(lower_case(word) == "nan" ? std::nan("") : parse_number(header.field(field), word));
  }
  return values;
}

/// World axes of the file: LPS, RAS, or LAS, which becomes RAS by the sign of x.
struct WorldAxes {
  volume::Space space = volume::Space::none;
  bool flip_x = false;
};

WorldAxes parse_space(const Header& header) {
  if (const std::string* dimension = header.find("spacedimension");
      dimension != nullptr && *dimension != "3") {
    header.field("space dimension").refuse(*dimension, "3");
  }
  const std::string* text = header.find("space");
  if (text == nullptr) return {};
  const std::string space = lower_case(*text);
  if (space == "left-posterior-superior" || space == "lps") return {volume::Space::lps, false};
  if (space == "right-anterior-superior" || space == "ras") return {volume::Space::ras, false};
  if (space == "left-anterior-superior" || space == "las") return {volume::Space::ras, true};
  if (space == "scanner-xyz" || space == "3d-right-handed" || space == "3d-left-handed") return {};
  header.field("space").refuse(*text, "a space of 3 dimensions");
}

}  // namespace

volume::GridGeometry parse_geometry(const Header& header, const std::vector<std::int64_t>& sizes) {
  const std::size_t n = sizes.size();
  const WorldAxes world = parse_space(header);
  std::vector<std::optional<Vec3>> directions;
  if (const auto* text = header.find("spacedirections")) directions = parse_directions(header, *text, n);
  refuse_vector_kinds(header, sizes);
  const auto spacings = parse_per_axis(header, "spacings", n);
  const auto mins = parse_per_axis(header, "axismins", n);
  const auto maxs = parse_per_axis(header, "axismaxs", n);
  std::vector<std::string> centerings(n);
  if (const auto* text = header.find("centerings")) {
    centerings = words_of(*text);
    if (centerings.size() != n) header.field("centerings").refuse(*text, "one word for each axis");
  }

  volume::GridGeometry geometry;
  geometry.space = world.space;
  const auto axes = spatial_axes(header, sizes, directions);
  Mat3 steps = Mat3::Identity();
  std::vector<std::size_t> known, unknown;  // spacings of axes of more than one sample
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::size_t a = axes[i];
    const auto column = static_cast<Eigen::Index>(i);
    geometry.dims[i] = sizes[a];
    if (!directions.empty()) {
      steps.col(column) = directions[a].value_or(Vec3::Zero());
      continue;
    }
    // Axis minimum and maximum are the outer faces of cells, but the outermost samples where centering is
    // node.
    const bool node = lower_case(centerings[a]) == "node";
    const bool has_min = !mins.empty() && !std::isnan(mins[a]);
    double spacing = spacings.empty() ? std::nan("") : spacings[a];
    if (std::isnan(spacing) && has_min && !maxs.empty() && !std::isnan(maxs[a]) && (!node || sizes[a] > 1)) {
      spacing = (maxs[a] - mins[a]) / static_cast<double>(node ? sizes[a] - 1 : sizes[a]);
    }
    if (std::isnan(spacing)) {
      if (sizes[a] > 1) unknown.push_back(i);
      spacing = 1;
    } else if (sizes[a] > 1) {
      known.push_back(i);
    }
    if (!(spacing > 0)) {
      throw Error(header.name + ": spacing " + shortest(spacing) + " along " + "xyz"[i] +
                  " is not positive; an axis that runs backwards needs 'space directions'");
    }
    steps(column, column) = spacing;
    if (has_min) geometry.origin[column] = mins[a] + (node ? 0.0 : 0.5 * spacing);
  }
  if (!known.empty() && !unknown.empty()) {
    throw Error(header.name + ": the spacing along " + "xyz"[unknown.front()] +
                " is not known (nan) while that along " + "xyz"[known.front()] +
                " is; give 'spacings' for both or for neither");
  }
  if (const auto* text = header.find("spaceorigin")) {
    std::string inside = *text;
    std::replace_if(
        inside.begin(), inside.end(), [](char c) { return c == '(' || c == ',' || c == ')'; }, ' ');
    geometry.origin = parse_vector(header.field("space origin"), inside);
  }
  if (world.flip_x) {
    steps.row(0) *= -1;
    geometry.origin.x() *= -1;
  }
  set_axes(geometry, steps, directions.empty() ? 3 : static_cast<int>(axes.size()));
  return geometry;
}

}  // namespace vol::io::nrrd
