// vol-index: from wavelet coefficients and an error bound, the index volume of sampling distances.
//   vol-index head.vdb -o index.nrrd --epsilon 3 --epsilon-scale byte
//   vol-index head.vdb -o index.nrrd --scene scene.yaml --epsilon 0.01 --distance 1v
#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/naming.h"
#include "cli/options.h"
#include "cli/run.h"
#include "index/build_index.h"
#include "index/classify.h"
#include "index/significant_details.h"
#include "io/index.h"
#include "io/scene.h"
#include "io/vdb.h"
#include "wavelet/initialisation.h"

namespace {

using namespace vol;

struct Options {
  std::filesystem::path input, output, scene, transfer;
  double epsilon = 0;
  std::string epsilon_scale = "value", normalisation = "amplitude", rule = "auto", relevance = "full";
  std::string stepping = "look-ahead", distance = "0.5v", reconstruction = "trilinear";
  int reduction = 1;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("input", o.input, "Wavelet coefficients (.vdb) from vol-dwt; - is standard input")
      ->required()
      ->group("Files");
  app.add_option("-o,--output", o.output, "Index volume (.nrrd); - is standard output")->required()->group("Files");
  app.add_option("--scene", o.scene, "Scene (.yaml) whose transfer function the index is made for")->group("Files");
  app.add_option("--transfer", o.transfer, "Transfer function (.yaml, .json) the index is made for")
      ->group("Files")
      ->excludes("--scene");

  const char* error = "Error bound";
  app.add_option("--epsilon", o.epsilon,
                 "Details at most this large do not count. On the volume's scale; with a transfer function, optical "
                 "depth (and light) of a standard step")
      ->check(cli::check_non_negative)
      ->capture_default_str()
      ->group(error);
  app.add_option("--epsilon-scale", o.epsilon_scale, "value, or byte: epsilon / 255 of the value range (of 1, with a transfer function)")
      ->check(CLI::IsMember({"value", "byte"}))
      ->capture_default_str()
      ->group(error);
  app.add_option("--rule", o.rule,
                 "magnitude: |d| <= epsilon (He); segment: 2^level |d| <= epsilon, so that every step carries the same "
                 "error; auto: segment with a transfer function, else magnitude")
      ->check(CLI::IsMember({"auto", "magnitude", "segment"}))
      ->capture_default_str()
      ->group(error);
  app.add_option("--normalisation", o.normalisation, "amplitude: coefficients times 2^(-3 level / 2); orthonormal: as they are")
      ->check(CLI::IsMember({"amplitude", "orthonormal"}))
      ->capture_default_str()
      ->group(error);
  app.add_option("--relevance", o.relevance,
                 "Voxels a coefficient bears on: full support, or energy:SHARE, such as energy:0.99")
      ->capture_default_str()
      ->group(error);

  const char* steps = "Steps";
  app.add_option("--distance", o.distance, "Standard distance d: world length, or multiples of the smallest spacing (0.5v)")
      ->capture_default_str()
      ->group(steps);
  app.add_option("--stepping", o.stepping, "look-ahead: no step leaves the region that allows it; blind: He's")
      ->check(CLI::IsMember({"look-ahead", "blind"}))
      ->capture_default_str()
      ->group(steps);
  app.add_option("--reduction", o.reduction, "One entry for N^3 cells")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str()
      ->group(steps);
  app.add_option("--reconstruction", o.reconstruction, "Kernel whose footprint counts: nearest, trilinear, catmull-rom")
      ->check(CLI::IsMember({"nearest", "trilinear", "catmull-rom"}))
      ->capture_default_str()
      ->group(steps);
}

double energy_share(const std::string& relevance) {
  if (relevance == "full") return 1;
  double share = 0;
  if (!relevance.starts_with("energy:") || !CLI::detail::lexical_cast(relevance.substr(7), share) || !(share > 0 && share <= 1)) {
    throw Error("--relevance " + relevance + ": expected full, or energy:SHARE with a share in (0, 1]");
  }
  return share;
}

struct SceneTransfer {
  transfer::TransferFunction function;
  double reference_length = 0;
};

std::optional<SceneTransfer> scene_transfer(const Options& o, const volume::GridGeometry& geometry, cli::Record& record) {
  if (o.scene.empty() && o.transfer.empty()) return std::nullopt;
  SceneTransfer result;
  if (!o.scene.empty()) {
    const auto file = io::read_scene(o.scene);
    if (!file.has_transfer) throw Error(o.scene.string() + ": the scene has no transfer function to make an index for");
    result = {file.scene.transfer, file.scene.reference_length};
    record.resolved("scene", io::to_json(file.scene));
  } else {
    result.function = io::read_transfer_function(o.transfer);
    render::Scene scene;
    scene.transfer = result.function;
    record.resolved("scene", io::to_json(scene));
  }
  if (!(result.reference_length > 0)) result.reference_length = geometry.spacing.minCoeff();
  return result;
}

template <class T>
index::IndexVolume build(const wavelet::Decomposition<T>& d, const Options& o, cli::Record& record) {
  const auto transfer = scene_transfer(o, d.geometry, record);
  index::SignificanceOptions s;
  s.epsilon = o.epsilon;
  if (o.epsilon_scale == "byte") s.epsilon *= (transfer ? 1.0 : d.range.max - d.range.min) / 255;
  s.rule = o.rule == "segment" || (o.rule == "auto" && transfer) ? index::Rule::segment : index::Rule::magnitude;
  s.normalisation = o.normalisation == "amplitude" ? index::Normalisation::amplitude : index::Normalisation::orthonormal;
  s.energy_share = energy_share(o.relevance);
  index::IndexOptions options;
  options.standard_distance = cli::parse_step("--distance", o.distance, d.geometry.spacing.minCoeff());
  options.look_ahead = o.stepping == "look-ahead";
  options.reduction = o.reduction;
  options.reconstruction = o.reconstruction == "nearest"     ? volume::Reconstruction::nearest
                           : o.reconstruction == "trilinear" ? volume::Reconstruction::trilinear
                                                             : volume::Reconstruction::catmull_rom;
  return record.repeated("index", [&] {
    const auto details = transfer ? index::significant_classified_details(d, transfer->function, transfer->reference_length,
                                                                          options.standard_distance, s)
                                  : index::significant_details(d, s);
    return index::build_index(details, d.geometry, options);
  });
}

void report(const index::IndexVolume& index, cli::Record& record) {
  std::vector<std::int64_t> histogram(16, 0);
  const Dims& n = index.dims();
  for (std::int64_t k = 0; k < n[2]; ++k) {
    for (std::int64_t j = 0; j < n[1]; ++j) {
      for (std::int64_t i = 0; i < n[0]; ++i) ++histogram[static_cast<std::size_t>(index.entry(i, j, k))];
    }
  }
  record.count("entries", n[0] * n[1] * n[2]);
  record.count("index_bytes", static_cast<std::int64_t>(index.nibbles().size()));
  while (histogram.size() > 1 && histogram.back() == 0) histogram.pop_back();
  record.result("entries_by_level", histogram);
  record.result("standard_distance", index.standard_distance());
}

int work(const Options& o, cli::Record& record) {
  (void)energy_share(o.relevance);
  if (!io::is_standard_stream(o.output) && o.output.extension() != ".nrrd") {
    throw Error(o.output.string() + ": an index volume goes to a .nrrd file, or to - (standard output)");
  }
  io::require_writable(o.output);
  record.input(o.input);
  const auto coefficients = record.timed("read", [&] { return io::read_coefficients(o.input); });
  std::visit(
      [&](const auto& d) {
        cli::naming(o.input, [&] { wavelet::require_samples(d); });
        const auto index = build(d, o, record);
        report(index, record);
        record.result("wavelet", d.wavelet);
        auto attributes = record.provenance();
        attributes["precis.index.wavelet"] = d.wavelet;
        attributes["precis.index.levels"] = std::to_string(d.levels);
        record.timed("write", [&] { io::write_index(o.output, index, d.geometry, attributes); });
      },
      coefficients.decomposition);
  record.output(o.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "From wavelet coefficients and an error bound: the index volume of sampling distances, 4 bits a voxel.\n"
      "Where no detail of the levels 1..L exceeds epsilon, vol-raycast --index steps 2^L standard distances."};
  Options options;
  declare(app, options);
  return cli::run(app,
                  {.name = "vol-index",
                   .example = "vol-phantom protein -o - | vol-dwt - -o - | vol-index - -o index.nrrd --epsilon 3 "
                              "--epsilon-scale byte",
                   .references = "He 1998",
                   .repeats = true},
                  argc, argv, [&](cli::Record& record) { return work(options, record); });
}
