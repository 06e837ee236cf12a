#include "io/codebook.h"

#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"
#include "io/file.h"
#include "io/header_text.h"
#include "io/transfer_yaml.h"
#include "io/yaml_map.h"

namespace vol::io {
namespace {

constexpr std::size_t kMostFeatures = 1024;
constexpr std::int64_t kLargestCodebook = 16 << 20;  // 4096 units of 100 components have some 9 MB

template <class Numbers>
std::string list(const Numbers& numbers) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < numbers.size(); ++i)
    text += (i > 0 ? ", " : "") + shortest(static_cast<double>(numbers[i]));
  return text + "]";
}

template <class Matrix>
std::string rows(const char* key, const Matrix& matrix) {
  if (matrix.rows() == 0 || matrix.cols() == 0) return std::string(key) + ": []\n";
  std::string text = std::string(key) + ":\n";
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) text += "  - " + list(matrix.row(r)) + "\n";
  return text;
}

Eigen::VectorXd vector_of(const YAML::Node& node, std::size_t count, const char* what) {
  const auto numbers = YamlMap::numbers(node, count, what);
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(count));
}

Eigen::MatrixXd matrix_of(const YAML::Node& node, std::size_t columns, std::size_t most, const char* what) {
  if (!node.IsSequence() || node.size() > most) {
    YamlMap::fail(node,
                  std::string(what) + ": a list of at most " + std::to_string(most) + " rows is expected");
  }
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(node.size()), static_cast<Eigen::Index>(columns));
  for (std::size_t r = 0; r < node.size(); ++r) {
    matrix.row(static_cast<Eigen::Index>(r)) = vector_of(node[r], columns, what).transpose();
  }
  return matrix;
}

YAML::Node need(const YamlMap& map, const char* key, const YAML::Node& node) {
  if (!map.has(key)) YamlMap::fail(node, std::string("codebook: key '") + key + "' is missing");
  return map[key];
}

features::Codebook parse(const YAML::Node& node) {
  const YamlMap map(node, "codebook",
                    {"made_by", "wavelet", "levels", "window", "approximation", "features", "mean",
                     "projection", "units", "labels"});
  features::Codebook book;
  book.wavelet = YamlMap::word(need(map, "wavelet", node), "wavelet");
  book.levels = YamlMap::as<int>(need(map, "levels", node), "levels");
  book.features.window = YamlMap::as<double>(need(map, "window", node), "window");
  book.features.approximation = YamlMap::as<bool>(need(map, "approximation", node), "approximation");
  const YAML::Node names = need(map, "features", node);
  if (!names.IsSequence() || names.size() == 0 || names.size() > kMostFeatures) {
    YamlMap::fail(names, "features: a list of 1 to " + std::to_string(kMostFeatures) + " names is expected");
  }
  for (const auto& name : names) book.names.push_back(YamlMap::word(name, "features"));
  const std::size_t count = book.names.size();
  book.mean = vector_of(need(map, "mean", node), count, "mean");
  book.projection = matrix_of(need(map, "projection", node), count, count, "projection");
  const YAML::Node units = need(map, "units", node);
  const auto components = static_cast<std::size_t>(book.projection.rows());
  if (components == 0) {
    book.units = features::Samples(1, 0);  // all vectors were the same
  } else {
    book.units = matrix_of(units, components, features::kMostUnits, "units");
  }
  const YAML::Node labels = need(map, "labels", node);
  if (!labels.IsSequence() || static_cast<Eigen::Index>(labels.size()) != book.units.rows()) {
    YamlMap::fail(labels, "labels: a list of " + std::to_string(book.units.rows()) +
                              " numbers, one a unit, is expected");
  }
  for (const auto& label : labels) book.labels.push_back(YamlMap::as<int>(label, "labels"));
  book.validate();
  return book;
}

}  // namespace

void write_codebook(const std::filesystem::path& path, const features::Codebook& book,
                    const std::map<std::string, std::string>& attributes) {
  const auto found = attributes.find("precis.version");
  std::string text = "# Labels of a volume by its wavelet features: vol-segment --codebook.\n";
  text += "made_by: vol-segment" + (found == attributes.end() ? "" : " " + found->second) + "\n";
  text += "wavelet: " + book.wavelet + "\nlevels: " + std::to_string(book.levels) +
          "\nwindow: " + shortest(book.features.window) +
          "\napproximation: " + (book.features.approximation ? "true" : "false") + "\nfeatures: [";
  for (std::size_t f = 0; f < book.names.size(); ++f) text += (f > 0 ? ", " : "") + book.names[f];
  text += "]\nmean: " + list(book.mean) + "\n" + rows("projection", book.projection);
  text += rows("units", book.projection.rows() > 0 ? book.units : features::Samples());
  text += "labels: [";
  // Without components all units are one.
  const std::size_t units = book.projection.rows() > 0 ? book.labels.size() : 1;
  for (std::size_t u = 0; u < units; ++u) text += (u > 0 ? ", " : "") + std::to_string(book.labels[u]);
  OutputFile out(path);
  out.write(text + "]\n");
  out.commit();
}

features::Codebook read_codebook(const std::filesystem::path& path) {
  const YAML::Node node = load_yaml(path, kLargestCodebook);
  try {
    return parse(node);
  } catch (const Error& error) {
    throw Error(display_name(path), error);
  } catch (const YAML::Exception& error) {
    throw Error(display_name(path), error);
  }
}

void write_features(const std::filesystem::path& path, const features::FeatureField& field,
                    const std::map<std::string, std::string>& attributes) {
  const volume::GridGeometry& g = field.geometry();
  const auto [nx, ny, nz] = g.dims;
  const Mat3 steps = g.direction * g.spacing.asDiagonal();
  std::string header = "NRRD0005\ntype: float\ndimension: 4\n";
  header += g.space == volume::Space::none  ? "space dimension: 3\n"
            : g.space == volume::Space::lps ? "space: left-posterior-superior\n"
                                            : "space: right-anterior-superior\n";
  header += "sizes: " + std::to_string(field.size()) + " " + std::to_string(nx) + " " + std::to_string(ny) +
            " " + std::to_string(nz) + "\nkinds: vector domain domain domain\nspace directions: none";
  for (int a = 0; a < 3; ++a) header += " (" + shortest(Vec3(steps.col(a)), ",") + ")";
  header += "\nspace origin: (" + shortest(g.origin, ",") + ")\nendian: little\nencoding: raw\n";
  std::string names;
  for (const auto& name : field.names()) names += (names.empty() ? "" : " ") + name;
  header += "precis.features.names:=" + names + "\n";
  for (const auto& [key, value] : attributes) {
    header += key + ":=";
    for (const char c : value) {
      if (c == '\\' || c == '\n') header += '\\';
      header += c == '\n' ? 'n' : c;
    }
    header += "\n";
  }
  OutputFile out(path);
  out.write(header + "\n");
  const auto features = static_cast<std::size_t>(field.size()), n = static_cast<std::size_t>(nx);
  std::vector<float> planar(features * n), vectors(features * n);
  for (std::int64_t row = 0; row < ny * nz; ++row) {
    field.row(row % ny, row / ny, planar);
    for (std::size_t f = 0; f < features; ++f) {
      const double offset = field.offset(static_cast<int>(f));
      for (std::size_t i = 0; i < n; ++i) {
        const double value = static_cast<double>(planar[f * n + i]) * field.unit() + offset;
        if (!(std::abs(value) <= std::numeric_limits<float>::max()))
          throw Error("features of this volume do not fit f32: " + shortest(value));
        vectors[i * features + f] = static_cast<float>(value);
      }
    }
    out.write(vectors.data(), vectors.size() * sizeof(float));
  }
  out.commit();
}

}  // namespace vol::io
