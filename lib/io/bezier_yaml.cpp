#include <cctype>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "io/file.h"
#include "io/header_text.h"
#include "io/scene.h"

namespace vol::io {
namespace {

std::string text_of(const transfer::BezierCurve& curve) {
  std::string text;
  for (std::size_t i = 0; i < curve.ordinates().size(); ++i) {
    const std::string y = shortest(curve.ordinates()[i]);
    if (i > 0) text += ", ";
    text += curve.parametric() ? "[" + shortest(curve.abscissae()[i]) + ", " + y + "]" : y;
  }
  return "[" + text + "]";
}

}  // namespace

void write_bezier(const std::filesystem::path& path, const transfer::BezierTransfer& bezier,
                  const std::map<std::string, std::string>& attributes) {
  bezier.validate();
  std::string text;
  for (const auto& [key, value] : attributes) text += "# " + key + ": " + value + "\n";
  text += "range: [" + shortest(bezier.lo) + ", " + shortest(bezier.hi) + "]\nbezier:\n";
  for (const auto& band : bezier.bands) {
    text += "  - {";
    // JSON's strings are strings of YAML.
    if (!band.name.empty()) text += "name: " + nlohmann::json(band.name).dump() + ", ";
    if (band.colour != Vec3::Ones()) text += "colour: [" + shortest(band.colour, ", ") + "], ";
    text += "points: " + text_of(band.curve) + "}\n";
  }
  OutputFile out(path);
  out.write(text);
  out.commit();
}

nlohmann::json to_json(const transfer::BezierTransfer& bezier) {
  nlohmann::json curves = nlohmann::json::array();
  for (const auto& band : bezier.bands) {
    nlohmann::json curve{{"points", band.curve.ordinates()},
                         {"colour", {band.colour[0], band.colour[1], band.colour[2]}}};
    if (!band.name.empty()) curve["name"] = band.name;
    if (band.curve.parametric()) curve["abscissae"] = band.curve.abscissae();
    curves.push_back(std::move(curve));
  }
  return {{"range", {bezier.lo, bezier.hi}}, {"curves", curves}};
}

transfer::Profile read_profile(const std::filesystem::path& path) {
  constexpr std::size_t kMostLines = 1 << 20;
  const std::string name = display_name(path);
  InputFile file(path);
  std::vector<transfer::ProfilePoint> points;
  bool headed = false;
  for (std::size_t line = 1; !file.at_end(); ++line) {
    if (line > kMostLines) throw Error(name + ": more than " + std::to_string(kMostLines) + " lines");
    const std::string kept = file.read_line(1000);
    const std::string_view text = trimmed(kept);
    if (text.empty() || text[0] == '#') continue;
    const std::string where = "line " + std::to_string(line);
    const std::size_t comma = text.find(',');
    if (comma == std::string_view::npos || text.find(',', comma + 1) != std::string_view::npos) {
      throw Error(name + ": " + where + ": value, weight is expected, not " + in_quotes(text));
    }
    const auto left = trimmed(text.substr(0, comma)), right = trimmed(text.substr(comma + 1));
    // Headings begin with a letter, but so does nan.
    const bool word = !left.empty() && std::isalpha(static_cast<unsigned char>(left[0])) != 0;
    const std::string lower = lower_case(left);
    if (word && !headed && points.empty() && lower != "nan" && lower != "inf" && lower != "infinity") {
      headed = true;
      continue;
    }
    const Field field{name, where};
    points.push_back({parse_number(field, left), parse_number(field, right)});
  }
  try {
    return transfer::Profile(std::move(points));
  } catch (const Error& error) {
    throw Error(name, error);
  }
}

}  // namespace vol::io
