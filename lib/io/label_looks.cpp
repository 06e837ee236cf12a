#include "io/label_looks.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "io/file.h"
#include "io/header_text.h"
#include "io/transfer_yaml.h"
#include "io/yaml_map.h"

namespace vol::io {
namespace {

std::vector<render::LabelLook> parse(const YAML::Node& node) {
  const YamlMap map(node, "looks of labels", {"space", "labels"});
  const auto space = map.get("space", std::string("linear"));
  if (space != "linear" && space != "srgb") {
    YamlMap::fail(map["space"], "space: linear or srgb is expected, not " + in_quotes(space));
  }
  if (!map.has("labels") || !map["labels"].IsSequence()) {
    YamlMap::fail(node, "labels: a list of [label, red, green, blue, opacity] is expected");
  }
  std::vector<render::LabelLook> looks;
  std::set<std::size_t> seen;
  for (const auto& row : map["labels"]) {
    const auto v = YamlMap::numbers(row, 5, "labels");
    if (!(v[0] >= 0 && v[0] <= 255 && v[0] == std::floor(v[0]))) {
      YamlMap::fail(row, "labels: a label is a whole number from 0 to 255");
    }
    if (!(v[1] >= 0 && v[2] >= 0 && v[3] >= 0)) YamlMap::fail(row, "labels: colours are at least 0");
    if (!(v[4] >= 0 && v[4] <= 1)) YamlMap::fail(row, "labels: opacity is from 0 to 1");
    const auto label = static_cast<std::size_t>(v[0]);
    if (!seen.insert(label).second) {
      YamlMap::fail(row, "labels: label " + std::to_string(label) + " comes twice");
    }
    if (looks.size() <= label) looks.resize(label + 1);
    Vec3 rgb(v[1], v[2], v[3]);
    if (space == "srgb") rgb = rgb.unaryExpr(&linear_light);
    looks[label] = {rgb, v[4]};
  }
  return looks;
}

}  // namespace

std::vector<render::LabelLook> read_label_looks(const std::filesystem::path& path) {
  const YAML::Node node = load_yaml(path);
  try {
    return parse(node);
  } catch (const Error& error) {
    throw Error(display_name(path), error);
  } catch (const YAML::Exception& error) {
    throw Error(display_name(path), error);
  }
}

std::vector<render::LabelLook> default_label_looks() {
  // Those of configs/transfer/labels.yaml, sRGB.
  const std::array<Vec3, 7> colours{Vec3(0.90, 0.35, 0.20), Vec3(0.25, 0.55, 0.85), Vec3(0.95, 0.80, 0.25),
                                    Vec3(0.35, 0.75, 0.40), Vec3(0.70, 0.45, 0.80), Vec3(0.35, 0.80, 0.80),
                                    Vec3(0.95, 0.60, 0.70)};
  std::vector<render::LabelLook> looks(256);
  for (std::size_t label = 1; label < looks.size(); ++label) {
    looks[label] = {colours[(label - 1) % colours.size()].unaryExpr(&linear_light), 0.05};
  }
  return looks;
}

nlohmann::json to_json(const std::vector<render::LabelLook>& looks) {
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t label = 0; label < looks.size(); ++label) {
    const auto& [c, opacity] = looks[label];
    if (opacity > 0) rows.push_back({label, c[0], c[1], c[2], opacity});
  }
  return rows;
}

}  // namespace vol::io
