#include "io/transfer_yaml.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/header_text.h"
#include "io/scene.h"
#include "io/yaml_map.h"
#include "volume/volume.h"

namespace vol::io {
namespace {

std::string read_text(const std::filesystem::path& path, std::int64_t most = kLargestYaml) {
  InputFile file(path);
  const auto bytes = file.read_rest(most);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// VTK's curve between two opacity points (vtkPiecewiseFunction): the midpoint m in (0, 1) is where half the
/// rise is done, sharpness 0 is linear on both sides of it, 1 a step there.
void append_vtk_curve(std::vector<transfer::OpacityPoint>& points, double x0, double y0, double x1, double y1,
                      double m, double sharpness) {
  const double rise = y1 - y0;
  if (sharpness > 0.99) {
    points.push_back({x0 + m * (x1 - x0), y0});
    points.push_back({x0 + m * (x1 - x0), y1});
  } else if (sharpness < 0.01) {
    if (m != 0.5) points.push_back({x0 + m * (x1 - x0), 0.5 * (y0 + y1)});
  } else {
    constexpr int kPieces = 32;
    for (int i = 1; i < kPieces; ++i) {
      const double x = double(i) / kPieces;
      double s = x < m ? 0.5 * x / m : 0.5 + 0.5 * (x - m) / (1 - m);
      s = s < 0.5 ? 0.5 * std::pow(2 * s, 1 + 10 * sharpness)
                  : 1 - 0.5 * std::pow(2 * (1 - s), 1 + 10 * sharpness);
      const double slope = (1 - sharpness) * rise;
      const double y = y0 + rise * s * s * (3 - 2 * s) + slope * s * (1 - s) * (1 - 2 * s);  // Hermite
      points.push_back({x0 + x * (x1 - x0), std::clamp(y, std::min(y0, y1), std::max(y0, y1))});
    }
  }
}

transfer::TransferFunction parse_paraview(const std::string& text) {
  nlohmann::json json = nlohmann::json::parse(text);
  if (json.is_array()) {
    if (json.empty()) throw Error("no colour map in this list of presets");
    json = json.front();
  }
  if (!json.is_object() || !json.contains("RGBPoints")) {
    throw Error("not a ParaView preset: no RGBPoints");
  }
  const auto rgb = json["RGBPoints"].get<std::vector<double>>();
  if (rgb.size() % 4 != 0 || rgb.empty()) throw Error("RGBPoints: groups of 4 numbers are expected");
  std::vector<transfer::ColourPoint> colours;
  for (std::size_t i = 0; i < rgb.size(); i += 4) {
    Vec3 colour;
    for (int c = 0; c < 3; ++c) colour[c] = linear_light(rgb[i + 1 + static_cast<std::size_t>(c)]);
    colours.push_back({rgb[i], colour});
  }
  std::vector<transfer::OpacityPoint> opacities;
  const auto points = json.value("Points", std::vector<double>());
  if (points.size() % 4 != 0) throw Error("Points: groups of 4 numbers are expected");
  for (std::size_t i = 0; i < points.size(); i += 4) {
    opacities.push_back({points[i], points[i + 1]});
    if (i + 4 < points.size()) {
      const double m = std::clamp(points[i + 2], 1e-5, 1 - 1e-5);  // as VTK does
      append_vtk_curve(opacities, points[i], points[i + 1], points[i + 4], points[i + 5], m, points[i + 3]);
    }
  }
  if (opacities.empty()) opacities = {{colours.front().value, 0}, {colours.back().value, 1}};
  return {std::move(colours), std::move(opacities)};
}

bool is_srgb(const YamlMap& map) {
  const auto space = map.get("space", std::string("linear"));
  if (space != "linear" && space != "srgb") {
    YamlMap::fail(map["space"], "space: linear or srgb is expected, not " + in_quotes(space));
  }
  return space == "srgb";
}

volume::Range range_of(const YamlMap& map) {
  if (!map.has("range")) return {0, 1};
  const auto range = YamlMap::numbers(map["range"], 2, "range");
  if (!(range[1] > range[0]) || !std::isfinite(range[1] - range[0])) {
    YamlMap::fail(map["range"], "range: [low, high] with low < high is expected");
  }
  return {range[0], range[1]};
}

transfer::BezierCurve parse_curve(const YAML::Node& node) {
  if (!node.IsSequence()) YamlMap::fail(node, "a list of control points is expected");
  std::vector<double> ordinates, abscissae;
  for (const auto& point : node) {
    if (point.IsSequence()) {
      const auto xy = YamlMap::numbers(point, 2, "control point");
      abscissae.push_back(xy[0]);
      ordinates.push_back(xy[1]);
    } else {
      ordinates.push_back(YamlMap::as<double>(point, "control point"));
    }
  }
  try {
    return transfer::BezierCurve(std::move(ordinates), std::move(abscissae));
  } catch (const Error& error) {
    YamlMap::fail(node, error.what());
  }
}

}  // namespace

double linear_light(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

YAML::Node load_yaml(const std::filesystem::path& path, std::int64_t most) {
  const std::string text = read_text(path, most);
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw Error(display_name(path), error);
  }
}

std::optional<transfer::BezierTransfer> parse_bezier(const YAML::Node& node) {
  if (!node.IsMap() || !node["bezier"].IsDefined()) return std::nullopt;
  const YamlMap map(node, "transfer function of Bezier curves", {"space", "range", "bezier"});
  const bool srgb = is_srgb(map);
  const auto [lo, hi] = range_of(map);
  transfer::BezierTransfer bezier{lo, hi, {}};
  const YAML::Node list = map["bezier"];
  if (!list.IsSequence() || list.size() == 0) {
    YamlMap::fail(list, "bezier: a list of control points, or of curves, is expected");
  }
  if (!list[0].IsMap()) {
    bezier.bands.push_back({"", Vec3::Ones(), parse_curve(list)});
    return bezier;
  }
  if (list.size() > transfer::kMostCurves) {  // before they are read
    YamlMap::fail(list, "bezier: at most " + std::to_string(transfer::kMostCurves) + " curves are possible");
  }
  for (const auto& entry : list) {
    const YamlMap curve(entry, "curve", {"name", "colour", "points"});
    if (!curve.has("points")) YamlMap::fail(entry, "curve without points");
    Vec3 colour = Vec3::Ones();
    if (curve.has("colour")) {
      const auto rgb = YamlMap::numbers(curve["colour"], 3, "colour");
      colour = Vec3(rgb[0], rgb[1], rgb[2]);
      if (srgb) colour = colour.unaryExpr(&linear_light);
    }
    bezier.bands.push_back({curve.get("name", std::string()), colour, parse_curve(curve["points"])});
  }
  try {
    bezier.validate();
  } catch (const Error& error) {
    YamlMap::fail(list, error.what());
  }
  return bezier;
}

transfer::TransferFunction parse_transfer_function(const YAML::Node& node) {
  if (const auto bezier = parse_bezier(node)) return transfer::as_transfer_function(*bezier);
  const YamlMap map(node, "transfer function", {"space", "range", "colours", "opacity", "bezier"});
  const bool srgb = is_srgb(map);
  const auto [lo, hi] = range_of(map);
  const auto rows = [&, from = lo, to = hi](const char* key, std::size_t width, const auto& add) {
    if (!map.has(key)) YamlMap::fail(node, std::string("transfer function without ") + key);
    const YAML::Node list = map[key];
    if (!list.IsSequence() || list.size() == 0)
      YamlMap::fail(list, std::string(key) + ": a list of points is expected");
    for (const auto& row : list) {
      auto values = YamlMap::numbers(row, width, key);
      values[0] = from + values[0] * (to - from);
      add(values);
    }
  };
  std::vector<transfer::ColourPoint> colours;
  std::vector<transfer::OpacityPoint> opacities;
  rows("colours", 4, [&](const std::vector<double>& v) {
    Vec3 rgb(v[1], v[2], v[3]);
    if (srgb) rgb = rgb.unaryExpr(&linear_light);
    colours.push_back({v[0], rgb});
  });
  rows("opacity", 2, [&](const std::vector<double>& v) { opacities.push_back({v[0], v[1]}); });
  try {
    return {std::move(colours), std::move(opacities)};
  } catch (const Error& error) {
    YamlMap::fail(node, error.what());
  }
}

namespace {

/// Runs f on what stands in the file; errors name the file.
template <class F>
auto parsed_yaml(const std::filesystem::path& path, const F& f) {
  const YAML::Node root = load_yaml(path);
  try {
    return f(root);
  } catch (const Error& error) {
    throw Error(display_name(path), error);
  } catch (const YAML::Exception& error) {
    throw Error(display_name(path), error);
  }
}

}  // namespace

transfer::TransferFunction read_transfer_function(const std::filesystem::path& path) {
  try {
    if (path.extension() == ".json") return parse_paraview(read_text(path));
  } catch (const nlohmann::json::exception& error) {
    throw Error(display_name(path), error);
  } catch (const Error& error) {
    throw Error(display_name(path), error);
  }
  return parsed_yaml(path, parse_transfer_function);
}

std::optional<transfer::BezierTransfer> read_bezier(const std::filesystem::path& path) {
  if (path.extension() == ".json") return std::nullopt;
  return parsed_yaml(path, parse_bezier);
}

}  // namespace vol::io
