#include "cli/fvr.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/fvr_words.h"
#include "cli/options.h"
#include "fourier/models.h"

namespace vol::cli {

namespace {

std::vector<double> one_each(const std::vector<double>& given, std::size_t count, const char* option) {
  if (given.empty()) return std::vector<double>(count, 1.0);
  if (given.size() != count) {
    throw Error(std::string(option) + ": " + std::to_string(given.size()) + " weights for " +
                std::to_string(count) + " spectra");
  }
  for (const double weight : given) {
    if (!std::isfinite(weight)) throw Error(std::string(option) + ": a weight is not finite");
  }
  return given;
}

/// Refuses what belongs to another model than the file's.
void require_model(bool given, const char* option, const std::string& needed, const std::string& model) {
  if (given && model != needed) {
    throw Error(std::string(option) + " is for spectra of the model " + needed + ", this file has " + model);
  }
}

/// One channel, or three where a curve has a colour: each spectrum's sum of colour times control point.
fourier::ChannelWeights curve_weights(const std::filesystem::path& path, const fourier::SpectrumInfo& info) {
  const transfer::BezierTransfer bezier = read_curves(path);
  const std::size_t count = info.names.size();
  const auto range = info.attributes.find(kBezierRange);
  const std::string own = nlohmann::json{bezier.lo, bezier.hi}.dump();
  if (range != info.attributes.end() && range->second != own) {
    throw Error(path.string() + ": curves over the values " + own +
                ", spectra over others; make these with vol-fft --bezier " + path.string());
  }
  fourier::ChannelWeights channels(bezier.grey() ? 1 : 3, std::vector<double>(count, 0.0));
  for (const auto& band : bezier.bands) {
    if (band.curve.parametric()) {
      throw Error(path.string() +
                  ": a curve with abscissae of its own is no sum of spectra; fit it with --curve even");
    }
    if (band.curve.ordinates().size() > count) {
      throw Error(path.string() + ": " + std::to_string(band.curve.ordinates().size()) +
                  " control points for " + std::to_string(count) + " spectra");
    }
    const auto points = transfer::elevated(band.curve.ordinates(), count);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      for (std::size_t i = 0; i < count; ++i) channels[c][i] += band.colour[static_cast<int>(c)] * points[i];
    }
  }
  return channels;
}

}  // namespace

fourier::ChannelWeights fvr_weights(const FvrOptions& o, const fourier::SpectrumInfo& info,
                                    const camera::Camera& camera) {
  require_model(!o.control_points.empty(), "--control-points", "bezier", info.model);
  require_model(!o.transfer.empty(), "--transfer", "bezier", info.model);
  require_model(!o.band_weights.empty(), "--band-weights", "bands", info.model);
  require_model(!o.band_colours.empty(), "--band-colours", "bands", info.model);
  require_model(!o.light.empty(), "--light", "directional", info.model);
  require_model(o.depth_cue.has_value(), "--depth-cue", "depth-cue", info.model);
  const std::size_t count = info.names.size();
  if (info.model == "depth-cue" || info.model == "directional") {
    if (count != 4)
      throw Error("a " + info.model + " file has four spectra, this one " + std::to_string(count));
    if (info.model == "depth-cue") return {fourier::depth_cue_weights(camera, o.depth_cue.value_or(1))};
    return {fourier::directional_weights(o.light.empty() ? Vec3(-camera.direction())
                                                         : parse_vec3("--light", o.light))};
  }
  if (info.model == "bezier" && !o.transfer.empty()) return curve_weights(o.transfer, info);
  if (info.model == "bezier") return {one_each(o.control_points, count, "--control-points")};
  const auto weights = one_each(o.band_weights, count, "--band-weights");
  if (o.band_colours.empty()) return {weights};
  if (o.band_colours.size() != count) {
    throw Error("--band-colours: " + std::to_string(o.band_colours.size()) + " colours for " +
                std::to_string(count) + " spectra");
  }
  fourier::ChannelWeights channels(3, weights);
  for (std::size_t f = 0; f < count; ++f) {
    const Vec3 colour = parse_vec3("--band-colours", o.band_colours[f]);
    for (int c = 0; c < 3; ++c) channels[static_cast<std::size_t>(c)][f] *= colour[c];
  }
  return channels;
}

}  // namespace vol::cli
