// vol-segment: from wavelet coefficients the features of every voxel, and from these its label.
//   vol-segment head.vdb -o labels.nrrd --classes 5 --codebook-output head.yaml
//   vol-segment other.vdb -o labels.nrrd --codebook head.yaml
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "cli/naming.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/volume_input.h"
#include "features/clusters.h"
#include "features/codebook.h"
#include "io/any_volume.h"
#include "io/codebook.h"
#include "io/vdb.h"
#include "volume/labels.h"
#include "wavelet/initialisation.h"

namespace {

using namespace vol;

struct Options {
  std::filesystem::path input, output, codebook, codebook_output, features_output, truth;
  std::string format, method = "map", map = "6x4", map_grid = "rectangular", normalise = "none";
  bool compress = false, no_approximation = false;
  features::FeatureOptions features;
  features::TrainingOptions training;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("input", o.input, "Wavelet coefficients (.vdb) from vol-dwt; - is standard input")
      ->required()
      ->group("Files");
  app.add_option(
         "-o,--output", o.output,
         "Labels, u8, 0 the most frequent of what was learnt; format by extension; - is standard output")
      ->required()
      ->group("Files");
  app.add_option("--format", o.format, "Format where the extension does not say: nrrd, mha, vti, vdb, raw")
      ->group("Files");
  app.add_flag("--compress", o.compress, "zlib, where the format has it")->group("Files");
  auto* codebook =
      app.add_option("--codebook", o.codebook,
                     "Label by this codebook (.yaml), of coefficients of the same kind; nothing is learnt")
          ->group("Files");
  app.add_option("--codebook-output", o.codebook_output, "Where to keep what was learnt (.yaml)")
      ->group("Files")
      ->excludes(codebook);
  app.add_option("--features-output", o.features_output,
                 "The feature vector of every voxel: 4-D, the features first, f32 (.nrrd)")
      ->group("Files");
  app.add_option("--truth", o.truth, "Labels to compare with: the stats have the adjusted Rand index")
      ->group("Files");

  const char* features = "Features";
  const auto learnt = [&](CLI::Option* option, const char* group) {
    option->group(group)->excludes(codebook);
  };
  learnt(app.add_option("--window", o.features.window,
                        "Standard deviation of the Gaussian over which amplitudes are taken, voxels; 0: none")
             ->check(cli::check_non_negative)
             ->capture_default_str(),
         features);
  learnt(app.add_flag("--no-approximation", o.no_approximation, "Leave out the local mean: texture alone"),
         features);
  learnt(app.add_option("--components", o.training.pca.components,
                        "Principal components; 0: as many as hold --share")
             ->check(CLI::Range(0, 1024))
             ->capture_default_str(),
         features);
  learnt(app.add_option("--share", o.training.pca.share, "Share of the variance the components hold, 0 to 1")
             ->check(CLI::Range(0.0, 1.0))
             ->capture_default_str(),
         features);
  learnt(app.add_option("--normalise", o.normalise,
                        "What is scaled to variance 1: none, features (before), or components (after)")
             ->check(CLI::IsMember({"none", "features", "components"}))
             ->capture_default_str(),
         features);

  const char* classes = "Classes";
  learnt(app.add_option("--classes,--labels", o.training.labels, "How many labels, 1 to 256")
             ->check(CLI::Range(1, features::kMostLabels))
             ->capture_default_str(),
         classes);
  learnt(app.add_option("--method", o.method, "map (self-organising, its units merged) or k-means")
             ->check(CLI::IsMember({"map", "k-means"}))
             ->capture_default_str(),
         classes);
  learnt(
      app.add_option("--map", o.map, "Units of the map, at most 4096: COLUMNSxROWS")->capture_default_str(),
      classes);
  learnt(app.add_option("--map-grid", o.map_grid, "rectangular or hexagonal")
             ->check(CLI::IsMember({"rectangular", "hexagonal"}))
             ->capture_default_str(),
         classes);
  learnt(app.add_option("--epochs", o.training.map.epochs, "Rounds of batch training")
             ->check(CLI::Range(1, 10000))
             ->capture_default_str(),
         classes);
  learnt(app.add_option("--samples", o.training.samples, "Voxels to learn from, at most")
             ->check(CLI::Range(8, 1 << 26))
             ->capture_default_str(),
         classes);
  learnt(app.add_option("--seed", o.training.seed, "Of the draw of voxels, and of k-means")
             ->check(cli::check_whole_number)
             ->capture_default_str(),
         classes);
}

/// Options that CLI11 does not check as a whole.
void resolve(Options& o) {
  o.features.approximation = !o.no_approximation;
  o.training.method = o.method == "map" ? features::Method::self_organising_map : features::Method::k_means;
  o.training.pca.standardise = o.normalise == "features";
  o.training.pca.whiten = o.normalise == "components";
  if (!(o.training.pca.share > 0)) throw Error("--share: a number above 0, up to 1, is expected");
  const auto units = cli::parse_image_size("--map", o.map);
  o.training.map.columns = units[0];
  o.training.map.rows = units[1];
  o.training.map.grid =
      o.map_grid == "hexagonal" ? features::MapGrid::hexagonal : features::MapGrid::rectangular;
  if (units[0] > features::kMostUnits / units[1]) {
    throw Error("--map " + o.map + ": at most " + std::to_string(features::kMostUnits) +
                " units are possible");
  }
  if (o.codebook.empty() && o.method == "map" && o.training.labels > units[0] * units[1]) {
    throw Error("--classes " + std::to_string(o.training.labels) + ": a map of " + o.map + " has only " +
                std::to_string(units[0] * units[1]) + " units");
  }
  io::require_volume_output(o.output, o.format);
  for (const auto* path : {&o.codebook_output, &o.features_output}) {
    if (path->empty()) continue;
    if (io::is_standard_stream(*path)) throw Error("standard output is for the labels");
    io::require_writable(*path);
  }
  if (!o.features_output.empty() && o.features_output.extension() != ".nrrd") {
    throw Error(o.features_output.string() + ": features go to a .nrrd file");
  }
}

void report(const features::Training& t, const Options& o, cli::Record& record) {
  record.seed(o.training.seed);
  record.count("samples", t.samples);
  record.count("components", t.codebook.projection.rows());
  record.result("component_shares", std::vector<double>(t.shares.begin(), t.shares.end()));
  record.result("variance_share", t.variance_share);
  record.result("labels_found", t.labels_found);
  record.result("quantisation_error", t.quantisation_error);
  record.result("unit_hits", t.hits);
  record.result("unit_labels", t.codebook.labels);
  if (o.training.method == features::Method::self_organising_map)
    record.result("topographic_error", t.topographic_error);
  if (t.labels_found < o.training.labels) {
    record.warn("found " + std::to_string(t.labels_found) + " of " + std::to_string(o.training.labels) +
                " labels: the volume has no more that differ");
  }
}

/// What another labelling of the same voxels says of this one.
void compare(const volume::Volume& labels, const Options& o, cli::Record& record) {
  cli::VolumeInput input;
  input.path = o.truth;
  const volume::Volume volume = cli::load(input, record);
  if (volume.geometry().dims != labels.geometry().dims) {
    throw Error(io::display_name(o.truth) +
                ": labels of the same dims as the coefficients' volume are expected");
  }
  const auto truth = cli::naming(o.truth, [&] { return volume::label_grid(volume); });
  const auto& ours = std::get<volume::Grid<std::uint8_t>>(labels.grid).voxels;
  const auto& theirs = truth.voxels;
  std::vector<std::vector<std::int64_t>> counts(256, std::vector<std::int64_t>(256, 0));
  for (std::size_t v = 0; v < ours.size(); ++v) ++counts[ours[v]][theirs[v]];
  record.result("adjusted_rand_index", features::adjusted_rand_index(counts));
}

template <class T>
features::FeatureField features_of(wavelet::Decomposition<T>&& d, Options& o, features::Codebook& book,
                                   cli::Record& record) {
  cli::naming(o.input, [&] { wavelet::require_samples(d); });
  record.resolved("wavelet", d.wavelet);
  record.resolved("levels", d.levels);
  if (!o.codebook.empty()) {
    record.input(o.codebook);
    book = record.timed("read", [&] { return io::read_codebook(o.codebook); });
    if (book.wavelet != d.wavelet || book.levels != d.levels) {
      throw Error(o.codebook.string() + ": is for " + std::to_string(book.levels) + " levels of " +
                  book.wavelet + "; the coefficients are " + std::to_string(d.levels) + " of " + d.wavelet);
    }
    o.features = book.features;
  }
  book.wavelet = d.wavelet;
  book.levels = d.levels;
  book.features = o.features;
  return record.timed("features", [&] { return features::FeatureField(std::move(d), o.features); });
}

int work(Options& o, cli::Record& record) {
  resolve(o);
  record.input(o.input);
  auto coefficients = record.timed("read", [&] { return io::read_coefficients(o.input); });
  features::Codebook book;
  const features::FeatureField field = std::visit(
      [&](auto& d) { return features_of(std::move(d), o, book, record); }, coefficients.decomposition);
  record.count("voxels", field.geometry().count());
  record.count("features", field.size());
  if (o.codebook.empty()) {
    features::Training training = record.timed("train", [&] { return features::train(field, o.training); });
    report(training, o, record);
    training.codebook.wavelet = book.wavelet;
    training.codebook.levels = book.levels;
    training.codebook.features = book.features;
    book = std::move(training.codebook);
  }
  volume::Volume labels = record.repeated("label", [&] { return features::label_volume(field, book); });
  if (!o.truth.empty()) compare(labels, o, record);
  cli::save(o.output, labels, record, o.format, o.compress);
  if (!o.codebook_output.empty()) {
    record.timed("write", [&] { io::write_codebook(o.codebook_output, book, record.provenance()); });
    record.output(o.codebook_output);
  }
  if (!o.features_output.empty()) {
    record.timed("write", [&] { io::write_features(o.features_output, field, record.provenance()); });
    record.output(o.features_output);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Segmentation in wavelet space: from coefficients the local amplitudes at every voxel by level and\n"
      "orientation, decorrelated, and by a self-organising map or k-means a label. Rejected coefficients are "
      "zeros."};
  Options options;
  declare(app, options);
  return cli::run(
      app,
      {.name = "vol-segment",
       .example =
           "vol-phantom texture -o - | vol-dwt - -o - --wavelet daubechies-4 | vol-segment - -o labels.nrrd",
       .references = "Gross et al. 1995, section 5; Kohonen 1995",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
