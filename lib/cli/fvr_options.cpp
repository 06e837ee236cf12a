#include "cli/fvr.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/fvr_words.h"
#include "cli/options.h"
#include "io/file.h"
#include "io/scene.h"
#include "io/write_image.h"

namespace vol::cli {

void add_fvr_options(CLI::App& app, FvrOptions& o) {
  app.add_option("input", o.input, "Spectrum of vol-fft (.nrrd); - is standard input")
      ->required()
      ->group("Files");
  app.add_option(
         "-o,--output", o.output,
         "Picture (.exr: R, G, B, A; .png); of several views numbered, -000 and so on; or all in one .nrrd; "
         "- is standard output")
      ->required()
      ->group("Files");
  app.add_option("--format", o.format, "exr or png [by extension; exr]")->group("Files");
  app.add_option("--scene", o.scene, "Scene (YAML) whose orthographic camera is taken")->group("Files");

  const char* picture = "Picture (overrules the scene)";
  app.add_option("--size", o.size, "WIDTHxHEIGHT in pixels")->capture_default_str()->group(picture);
  app.add_option("--view", o.views,
                 "AZIMUTH,ELEVATION in degrees; may be given several times [0,0: along -z]")
      ->take_all()
      ->group(picture);
  app.add_option("--turntable", o.turntable, "N views around the vertical axis, from the first --view on")
      ->check(CLI::Range(1, 100000))
      ->group(picture);
  app.add_option("--width", o.width, "World width of the picture [1.6 longest edge]")
      ->check(check_positive)
      ->group(picture);
  app.add_option("--exposure", o.exposure,
                 "PNG: what values are multiplied by; auto: the first picture's largest becomes 1")
      ->capture_default_str()
      ->group(picture);

  const char* accuracy = "Accuracy against cost";
  app.add_option("--filter", o.filter,
                 fourier::filter_names() + " [what the spectrum was compensated for, else catmull-rom]")
      ->group(accuracy);
  app.add_flag("--wrap", o.wrap,
               "Slice at the picture's own frequencies: less work where the volume reaches beyond the "
               "picture, but it "
               "comes in again from the other side")
      ->group(accuracy);

  const char* model = "Model (what the spectra were made for)";
  app.add_option("--control-points", o.control_points, "Bezier: one weight a spectrum [all 1]")
      ->delimiter(',')
      ->group(model);
  app.add_option("--transfer", o.transfer,
                 "Bezier: control points, and of several curves the colours, of a transfer function of "
                 "tf-fit (.yaml)")
      ->excludes("--control-points")
      ->group(model);
  app.add_option("--band-weights", o.band_weights, "Bands: one weight a spectrum [all 1]")
      ->delimiter(',')
      ->group(model);
  app.add_option("--band-colours", o.band_colours, "Bands: R,G,B:R,G,B ..., linear, one a spectrum [white]")
      ->delimiter(':')
      ->group(model);
  app.add_option("--light", o.light, "Directional: x,y,z toward the light, in world axes [toward the viewer]")
      ->group(model);
  app.add_option("--depth-cue", o.depth_cue, "Depth cue: strength t of t/2 (1 + V.D) [1]")
      ->check(check_non_negative)
      ->group(model);
}

bool is_stack(const FvrOptions& o) {
  return o.format.empty() && o.output.extension() == ".nrrd";
}

double given_exposure(const FvrOptions& o) {
  double exposure = 0;
  if (o.exposure != "auto" && (!CLI::detail::lexical_cast(o.exposure, exposure) || !(exposure > 0))) {
    throw Error("--exposure " + o.exposure + ": expected a positive number or auto");
  }
  return exposure;
}

bool is_png(const std::filesystem::path& output, const std::string& format) {
  return format == "png" || (format.empty() && output.extension() == ".png");
}

transfer::BezierTransfer read_curves(const std::filesystem::path& path) {
  const auto bezier = io::is_standard_stream(path) ? std::nullopt : io::read_bezier(path);
  if (!bezier) throw Error(path.string() + ": is not a file of Bezier curves; make one with tf-fit");
  return *bezier;
}

std::vector<FvrView> fvr_views(const FvrOptions& o, Record& record) {
  if (!o.format.empty() && o.output.extension() == ".nrrd") {
    throw Error("--format " + o.format + " contradicts " + o.output.string() + ", a stack of all views");
  }
  if (o.exposure != "auto" && !is_png(o.output, o.format)) {
    throw Error("--exposure is for PNG; other pictures hold the values themselves");
  }
  (void)parse_image_size("--size", o.size);
  (void)given_exposure(o);
  if (!o.transfer.empty()) {
    record.input(o.transfer);
    record.resolved("transfer", io::to_json(read_curves(o.transfer)));
  }
  camera::View base;
  if (!o.scene.empty()) {
    record.input(o.scene);
    base = io::read_scene(o.scene).scene.view;
    if (base.projection == camera::Projection::perspective && !o.width) {
      throw Error(o.scene.string() +
                  ": has a perspective camera, Fourier volume rendering none; give --width");
    }
  }
  if (o.width) base.width = o.width;
  base.projection = camera::Projection::orthographic;
  std::vector<camera::View> all;
  for (const auto& text : o.views) {
    const auto angles = parse_view("--view", text);
    all.push_back(base);
    all.back().azimuth = angles[0];
    all.back().elevation = angles[1];
  }
  if (all.empty()) all.push_back(base);
  if (o.turntable > 0) {
    if (all.size() > 1) throw Error("--turntable goes on from one --view, not from several");
    for (int i = 1; i < o.turntable; ++i) {
      all.push_back(all.front());
      all.back().azimuth += 360.0 * i / o.turntable;
    }
  }
  if (all.size() > 1 && io::is_standard_stream(o.output)) {
    throw Error("several pictures do not go to standard output; give --output a name");
  }
  std::vector<FvrView> views;
  if (is_stack(o)) io::require_writable(o.output);
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::filesystem::path path = o.output;
    if (is_stack(o)) {
      views.push_back({all[i], path});
      continue;
    }
    if (all.size() > 1) {
      char number[24];
      std::snprintf(number, sizeof number, "-%03zu", i);
      path.replace_filename(path.stem().string() + number + path.extension().string());
    }
    io::require_image_format(path, o.format);
    views.push_back({all[i], path});
  }
  return views;
}

fourier::Filter fvr_filter(const FvrOptions& o, const fourier::SpectrumInfo& info, Record& record) {
  const bool compensated = info.compensation != "none";
  fourier::Filter filter(!o.filter.empty() ? o.filter
                         : compensated     ? info.compensation
                                           : "catmull-rom",
                         info.padding);
  record.resolved("filter", filter.name());
  if (info.padding < 1.25) {
    record.warn(
        "a spectrum without padding: views along no axis have ghosts of 20 % and more, whatever the filter, "
        "where "
        "the object fills its box; vol-fft --pad 2 cures it");
  }
  if (filter.name() == info.compensation) return filter;
  if (!filter.interpolates()) {
    throw Error("--filter " + filter.name() + " needs a spectrum made with vol-fft --compensate " +
                filter.name() + "; this one is compensated for " + info.compensation);
  }
  if (compensated) {
    record.warn("the spectrum is compensated for " + info.compensation + ", not for " + filter.name() +
                ": the picture is too bright or too dark toward the volume's rim");
  }
  return filter;
}

}  // namespace vol::cli
