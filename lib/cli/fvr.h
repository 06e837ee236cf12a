#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera.h"
#include "cli/record.h"
#include "fourier/slice.h"
#include "image/image.h"

// What fvr-slice and fvr-slice-gpu share: their options, the views of a run, the weights of a model, the
// pictures. Target vol_cli_fvr.
namespace vol::cli {

/// Attribute of spectra for Bezier curves: the values of v = 0 and v = 1, as JSON.
inline constexpr const char* kBezierRange = "precis.bezier_range";

struct FvrOptions {
  std::filesystem::path input, output, scene, transfer;
  std::string format, size = "512x512", filter, exposure = "auto";
  std::vector<std::string> views;
  int turntable = 0;
  std::optional<double> width, depth_cue;
  std::vector<double> control_points, band_weights;
  std::vector<std::string> band_colours;
  std::string light;
  bool wrap = false;
};

void add_fvr_options(CLI::App& app, FvrOptions& o);

/// One picture of the run: where it looks from and where it goes.
struct FvrView {
  camera::View view;
  std::filesystem::path output;
};
/// --scene, --view and --turntable put together. Of several views the pictures are numbered before their
/// extension, picture-000.exr, picture-001.exr ... \throws vol::Error naming the option at fault
[[nodiscard]] std::vector<FvrView> fvr_views(const FvrOptions& o, Record& record);

/// --filter, or the one the spectrum was compensated for, or catmull-rom. Warns where the two do not fit.
/// \throws vol::Error for a filter that is right only compensated
[[nodiscard]] fourier::Filter fvr_filter(const FvrOptions& o, const fourier::SpectrumInfo& info,
                                         Record& record);

/// What a view's channels are made of, one or three. \throws vol::Error where options and model do not fit
[[nodiscard]] fourier::ChannelWeights fvr_weights(const FvrOptions& o, const fourier::SpectrumInfo& info,
                                                  const camera::Camera& camera);

/// States in the record what the run will take: `spectra` bytes, planes of the slices in numbers of `real`
/// bytes, and pictures as many as are held at once. \throws vol::Error where the machine has less
void fvr_require_memory(const FvrOptions& o, const fourier::SpectrumInfo& info,
                        const std::vector<FvrView>& views, std::int64_t spectra, std::int64_t real,
                        Record& record);

/// Draws one view: the planes of its channels, row by row from the top.
/// The last argument is where the picture goes: empty, or an earlier one whose memory may be used again.
using FvrDraw = std::function<void(const fourier::SliceView&, const fourier::ChannelWeights&,
                                   std::vector<Buffer<float>>&)>;

/// All pictures of the run, drawn by `draw` and written. Frames per second go into the record over all
/// repetitions.
void fvr_pictures(const FvrOptions& o, const fourier::SpectrumInfo& info, const std::vector<FvrView>& views,
                  const FvrDraw& draw, Record& record);

}  // namespace vol::cli
