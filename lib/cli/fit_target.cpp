#include "cli/fit_target.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/utf8.h"
#include "cli/options.h"
#include "io/file.h"
#include "io/scene.h"
#include "transfer/bezier.h"

namespace vol::cli {

void add_fit_target(CLI::App& app, FitTargetOptions& o) {
  app.add_option(
         "target", o.file,
         "Opacity over data value: transfer function (.yaml, ParaView's .json), or lines of value, weight "
         "(.csv)")
      ->group("Files");
  app.add_option("--band", o.bands,
                 "[NAME=]LO:HI=WEIGHT: this weight for values from LO to HI, else 0; may be given several "
                 "times, a curve "
                 "each")
      ->take_all()
      ->group(kFitTargetGroup);
  app.add_option("--band-colours", o.colours, "R,G,B:R,G,B ..., linear, one a band [white]")
      ->delimiter(':')
      ->group(kFitTargetGroup);
}

namespace {

struct Band {
  std::string name;
  double lo = 0, hi = 0, weight = 0;
};

Band parse_band(const std::string& word) {
  Band band;
  const std::size_t last = word.rfind('='), colon = word.rfind(':');
  const auto number = [](const std::string& text, double& value) {
    return !text.empty() && CLI::detail::lexical_cast(text, value) && std::abs(value) <= 1e30;
  };
  bool good = last != std::string::npos && colon != std::string::npos && colon < last;
  if (good) {
    const std::size_t first = word.rfind('=', last - 1);
    const bool named = last > 0 && first != std::string::npos;
    const std::size_t begin = named ? first + 1 : 0;
    if (named) band.name = word.substr(0, first);
    good = begin < colon && number(word.substr(begin, colon - begin), band.lo) &&
           number(word.substr(colon + 1, last - colon - 1), band.hi) &&
           number(word.substr(last + 1), band.weight) && band.lo <= band.hi;
  }
  if (!is_utf8(band.name)) throw Error("--band: a name is not UTF-8");
  if (!good) throw Error("--band " + word + ": expected [NAME=]LO:HI=WEIGHT with LO at most HI");
  return band;
}

FitTargets wanted_of_bands(const FitTargetOptions& o) {
  FitTargets wanted;
  if (o.bands.size() > transfer::kMostCurves) {
    throw Error("--band: at most " + std::to_string(transfer::kMostCurves) + " curves are possible, not " +
                std::to_string(o.bands.size()));
  }
  if (!o.colours.empty() && o.colours.size() != o.bands.size()) {
    throw Error("--band-colours: " + std::to_string(o.colours.size()) + " colours for " +
                std::to_string(o.bands.size()) + " bands");
  }
  for (std::size_t b = 0; b < o.bands.size(); ++b) {
    const Band band = parse_band(o.bands[b]);
    FitTarget target{band.name, Vec3::Ones(), [band](double value) {
                       return value >= band.lo && value <= band.hi ? band.weight : 0.0;
                     }};
    if (!o.colours.empty()) {
      target.colour = parse_vec3("--band-colours", o.colours[b]);
      if (!target.colour.allFinite() || target.colour.minCoeff() < 0 || target.colour.maxCoeff() > 1e30) {
        throw Error("--band-colours " + o.colours[b] + ": expected numbers from 0 to 1e30");
      }
    }
    wanted.curves.push_back(std::move(target));
  }
  return wanted;
}

FitTargets wanted_of_profile(transfer::Profile profile) {
  FitTargets wanted;
  wanted.range = {profile.points().front().value, profile.points().back().value};
  wanted.curves.push_back(
      {"", Vec3::Ones(), [p = std::move(profile)](double value) { return p.value(value); }});
  return wanted;
}

FitTargets wanted_of_file(const std::filesystem::path& path, Record& record) {
  if (io::is_standard_stream(path)) throw Error("the target is a file: its name says what form it has");
  record.input(path);
  if (path.extension() == ".csv") return wanted_of_profile(io::read_profile(path));
  if (const auto bezier = io::read_bezier(path)) {
    FitTargets wanted;
    wanted.range = {bezier->lo, bezier->hi};
    for (const auto& band : bezier->bands) {
      wanted.curves.push_back({band.name, band.colour, [band, b = *bezier](double value) {
                                 return band.curve.value(b.scaled(value));
                               }});
    }
    return wanted;
  }
  std::vector<transfer::ProfilePoint> points;
  const transfer::TransferFunction transfer = io::read_transfer_function(path);
  for (const auto& p : transfer.opacities()) points.push_back({p.value, p.opacity});
  return wanted_of_profile(transfer::Profile(std::move(points)));
}

}  // namespace

FitTargets fit_targets(const FitTargetOptions& o, Record& record) {
  if (o.file.empty() == o.bands.empty()) throw Error("either a target or --band is expected");
  if (o.bands.empty() && !o.colours.empty()) throw Error("--band-colours are for --band");
  return o.file.empty() ? wanted_of_bands(o) : wanted_of_file(o.file, record);
}

void require_samples(const FitTargetOptions& o, const fit::Samples& samples) {
  for (const std::string& word : o.bands) {
    const Band band = parse_band(word);
    const auto within = [&](double value) { return value >= band.lo && value <= band.hi; };
    if (std::any_of(samples.value.begin(), samples.value.end(), within)) continue;
    char text[120];
    std::snprintf(text, sizeof text, ": none of the %zu values that count, %.6g to %.6g, lies in it",
                  samples.value.size(), samples.value.front(), samples.value.back());
    throw Error("--band " + word + text + "; see --range and --samples");
  }
}

}  // namespace vol::cli
