#include "cli/spectrum_model.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/fvr.h"
#include "io/file.h"
#include "io/scene.h"

namespace vol::cli {

void add_spectrum_model(CLI::App& app, SpectrumModelOptions& o) {
  const char* model = "Model (one of these; several spectra in one file)";
  auto* shading = app.add_option("--shading", o.shading,
                                 "depth-cue or directional: for --depth-cue or --light of fvr-slice")
                      ->check(CLI::IsMember({"depth-cue", "directional"}))
                      ->group(model);
  auto* bezier =
      app.add_option("--bezier", o.bezier,
                     "N (1 to 21) spectra weighted by Bernstein polynomials, for --control-points; or a "
                     "transfer function of tf-fit (.yaml), whose points and range are taken, for --transfer")
          ->type_name("N|FILE")
          ->excludes(shading)
          ->group(model);
  app.add_option("--range", o.range,
                 "Bezier N: values that become 0 and 1, others are clamped [the volume's]")
      ->delimiter(',')
      ->expected(2)
      ->type_name("LO,HI")
      ->needs(bezier)
      ->group(model);
  app.add_option("--bands", o.bands,
                 "Values of each band, LO:HI,LO:HI ...; one spectrum a band: for --band-weights")
      ->delimiter(',')
      ->type_name("LO:HI,...")
      ->excludes(shading)
      ->excludes(bezier)
      ->group(model);
  app.add_flag("--edges", o.edges, "One more band: 1 at the edges that Canny's detector finds, else 0")
      ->excludes(shading)
      ->excludes(bezier)
      ->group(model);
}

namespace {

std::vector<fourier::Band> parse_bands(const std::vector<std::string>& words) {
  std::vector<fourier::Band> bands;
  for (const auto& word : words) {
    const std::size_t colon = word.find(':');
    fourier::Band band{};
    if (colon == std::string::npos || !CLI::detail::lexical_cast(word.substr(0, colon), band.lo) ||
        !CLI::detail::lexical_cast(word.substr(colon + 1), band.hi) || !(band.lo <= band.hi)) {
      throw Error("--bands " + word + ": expected LO:HI with LO at most HI");
    }
    bands.push_back(band);
  }
  return bands;
}

/// Points of --bezier where that is a number.
std::optional<int> number_of_points(const std::string& word) {
  int points = 0;
  if (!CLI::detail::lexical_cast(word, points)) return std::nullopt;
  if (points >= 1 && points <= transfer::kMostControlPoints) return points;
  throw Error("--bezier " + word + ": 1 to " + std::to_string(transfer::kMostControlPoints) +
              " control points are possible");
}

/// The curves of a file.
transfer::BezierTransfer curves_in(const std::string& file) {
  const auto bezier = io::is_standard_stream(file) ? std::nullopt : io::read_bezier(file);
  if (!bezier) throw Error("--bezier " + file + ": expected a number, or a file of Bezier curves (tf-fit)");
  return *bezier;
}

}  // namespace

SpectrumModel::SpectrumModel(const SpectrumModelOptions& o, Record& record)
    : options_(o), bands_(parse_bands(o.bands)) {
  if (o.bezier.empty()) return;
  if (!o.range.empty()) range_ = {o.range[0], o.range[1]};
  if (const auto number = number_of_points(o.bezier)) {
    points_ = *number;
    return;
  }
  const transfer::BezierTransfer bezier = curves_in(o.bezier);
  record.input(o.bezier);
  if (range_) throw Error("--range: the range of " + o.bezier + " is taken");
  range_ = {bezier.lo, bezier.hi};
  for (const auto& band : bezier.bands) {
    if (band.curve.parametric()) {
      throw Error(o.bezier +
                  ": a curve with abscissae of its own is no sum of spectra; fit it with --curve even");
    }
    points_ = std::max(points_, static_cast<int>(band.curve.ordinates().size()));
  }
}

std::int64_t SpectrumModel::spectra() const {
  if (!options_.shading.empty()) return 4;
  if (points_ > 0) return points_;
  if (!bands_.empty() || options_.edges) return std::ssize(bands_) + (options_.edges ? 1 : 0);
  return 1;
}

fourier::Model SpectrumModel::of(const volume::Volume& volume, fourier::SpectrumInfo& info,
                                 Record& record) const {
  if (options_.shading == "depth-cue") return fourier::depth_cue_model(volume);
  if (options_.shading == "directional") return fourier::directional_model(volume);
  if (points_ > 0) {
    const auto range = range_ ? *range_ : volume::value_range(volume);
    record.resolved("bezier", points_);
    record.resolved("range", {range.min, range.max});
    info.attributes[kBezierRange] = nlohmann::json{range.min, range.max}.dump();
    return fourier::bezier_model(volume, points_, range);
  }
  if (!bands_.empty() || options_.edges) return fourier::bands_model(volume, bands_, options_.edges);
  return fourier::plain_model(volume);
}

}  // namespace vol::cli
