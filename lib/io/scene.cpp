#include "io/scene.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/header_text.h"
#include "io/transfer_yaml.h"
#include "io/yaml_map.h"
#include "render/names.h"

namespace vol::io {
namespace {

Vec3 vec3(const YAML::Node& node, const std::string& what) {
  const auto v = YamlMap::numbers(node, 3, what);
  return {v[0], v[1], v[2]};
}

/// Calls f with the node's word and gives an error of f the node's line.
template <class F>
auto named(const YAML::Node& node, const char* key, const F& f) {
  const auto word = YamlMap::word(node, key);
  try {
    return f(word);
  } catch (const Error& error) {
    YamlMap::fail(node, error.what());
  }
}

/// A number that has to hold something: where it does not, an error with the line of its key.
template <class Holds>
double checked(const YamlMap& map, const char* key, double fallback, const Holds& holds,
               const char* expected) {
  const double value = map.get(key, fallback);
  if (map.has(key) && !holds(value))
    YamlMap::fail(map[key], std::string(key) + ": " + expected + " is expected");
  return value;
}

bool is_positive(double value) {
  return value > 0 && std::isfinite(value);
}
bool is_not_negative(double value) {
  return value >= 0 && std::isfinite(value);
}

/// \param norm  by which it must not be 0
template <class Norm>
Vec3 direction(const YAML::Node& node, const std::string& what, const Norm& norm) {
  const Vec3 v = vec3(node, what);
  if (!(norm(v) > 0)) YamlMap::fail(node, what + ": a direction is expected, which is not 0");
  return v;
}

camera::View read_camera(const YAML::Node& node) {
  const YamlMap map(node, "camera", {"azimuth", "elevation", "width", "fov", "distance", "target", "up"});
  camera::View view;
  view.azimuth = checked(
      map, "azimuth", view.azimuth, [](double a) { return std::isfinite(a); }, "an angle in degrees");
  view.elevation = checked(
      map, "elevation", view.elevation, [](double e) { return std::abs(e) <= 90; },
      "an angle from -90 to 90 degrees");
  if (map.has("width") && map.has("fov")) {
    YamlMap::fail(map["fov"], "camera: either width (orthographic) or fov (perspective)");
  }
  if (map.has("width")) view.width = checked(map, "width", 0.0, is_positive, "a positive world length");
  if (map.has("fov") || map.has("distance")) view.projection = camera::Projection::perspective;
  view.fov = checked(
      map, "fov", view.fov, [](double fov) { return fov > 0 && fov < 180; },
      "an angle between 0 and 180 degrees");
  if (map.has("distance"))
    view.distance = checked(map, "distance", 0.0, is_positive, "a positive world length");
  if (map.has("target")) view.target = vec3(map["target"], "target");
  if (map.has("up")) view.up = direction(map["up"], "up", [](const Vec3& v) { return v.norm(); });
  return view;
}

std::optional<render::Shading> read_shading(const YAML::Node& node) {
  if (node.IsScalar()) {
    const auto word = node.Scalar();
    if (word == "true") return render::Shading{};
    if (word == "false" || word == "none") return std::nullopt;
    YamlMap::fail(node, "shading: true, false or a map is expected, not " + in_quotes(word));
  }
  const YamlMap map(node, "shading", {"ambient", "diffuse", "specular", "exponent", "light"});
  render::Shading shading;
  shading.ambient = checked(map, "ambient", shading.ambient, is_not_negative, "a number of at least 0");
  shading.diffuse = checked(map, "diffuse", shading.diffuse, is_not_negative, "a number of at least 0");
  shading.specular = checked(map, "specular", shading.specular, is_not_negative, "a number of at least 0");
  shading.exponent = checked(map, "exponent", shading.exponent, is_not_negative, "a number of at least 0");
  if (map.has("light"))
    shading.light = direction(map["light"], "light", [](const Vec3& v) { return v.stableNorm(); });
  return shading;
}

SceneFile parse(const YAML::Node& root, const std::filesystem::path& folder) {
  const YamlMap map(root, "scene",
                    {"camera", "transfer", "reference_length", "shading", "background", "model", "quadrature",
                     "step", "reconstruction"});
  SceneFile file;
  if (map.has("camera")) file.scene.view = read_camera(map["camera"]);
  if (map.has("transfer")) {
    const YAML::Node node = map["transfer"];
    if (node.IsScalar()) {
      const auto path = folder / YamlMap::word(node, "transfer");
      file.bezier = read_bezier(path);
      file.scene.transfer = read_transfer_function(path);
    } else {
      file.bezier = parse_bezier(node);
      file.scene.transfer = parse_transfer_function(node);
    }
    file.has_transfer = true;
  }
  file.scene.reference_length = checked(map, "reference_length", 0.0, is_positive, "a positive world length");
  if (map.has("shading")) file.scene.shading = read_shading(map["shading"]);
  if (map.has("background")) {
    file.scene.background = vec3(map["background"], "background");
    if (file.scene.background.minCoeff() < 0)
      YamlMap::fail(map["background"], "background: negative component");
  }
  if (map.has("model")) file.scene.model = named(map["model"], "model", render::model_from_name);
  if (map.has("quadrature"))
    file.quadrature = named(map["quadrature"], "quadrature", render::quadrature_from_name);
  if (map.has("step")) file.step = map.get("step", std::string());
  if (map.has("reconstruction")) {
    file.reconstruction = named(map["reconstruction"], "reconstruction", render::reconstruction_from_name);
  }
  return file;
}

}  // namespace

SceneFile read_scene(const std::filesystem::path& path) {
  const YAML::Node root = load_yaml(path);
  try {
    return parse(root, path.parent_path());
  } catch (const Error& error) {
    throw Error(display_name(path), error);
  } catch (const YAML::Exception& error) {
    throw Error(display_name(path), error);
  }
}

nlohmann::json to_json(const render::Scene& scene) {
  const auto list = [](const Vec3& v) { return nlohmann::json{v[0], v[1], v[2]}; };
  nlohmann::json camera{
      {"azimuth", scene.view.azimuth}, {"elevation", scene.view.elevation}, {"up", list(scene.view.up)}};
  if (scene.view.projection == camera::Projection::perspective) camera["fov"] = scene.view.fov;
  if (scene.view.width) camera["width"] = *scene.view.width;
  if (scene.view.distance) camera["distance"] = *scene.view.distance;
  if (scene.view.target) camera["target"] = list(*scene.view.target);
  nlohmann::json json{
      {"camera", camera}, {"model", render::name(scene.model)}, {"background", list(scene.background)}};
  if (scene.model == render::Model::composite) {
    nlohmann::json colours = nlohmann::json::array(), opacity = nlohmann::json::array();
    for (const auto& p : scene.transfer.colours()) colours.push_back({p.value, p.rgb[0], p.rgb[1], p.rgb[2]});
    for (const auto& p : scene.transfer.opacities()) opacity.push_back({p.value, p.opacity});
    json["transfer"] = {{"colours", colours}, {"opacity", opacity}};
    json["reference_length"] = scene.reference_length;
    if (scene.shading) {
      json["shading"] = {{"ambient", scene.shading->ambient},
                         {"diffuse", scene.shading->diffuse},
                         {"specular", scene.shading->specular},
                         {"exponent", scene.shading->exponent}};
      if (scene.shading->light) json["shading"]["light"] = list(*scene.shading->light);
    }
  }
  return json;
}

}  // namespace vol::io
