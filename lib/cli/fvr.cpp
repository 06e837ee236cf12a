#include "cli/fvr.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/checked.h"
#include "base/error.h"
#include "cli/options.h"
#include "fourier/models.h"
#include "fourier/projection.h"
#include "image/exposure.h"
#include "io/file.h"
#include "io/png.h"
#include "io/scene.h"
#include "io/volume.h"
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

namespace {

/// All views in one volume of grey pictures, uncompressed: for programs, and many a second.
bool is_stack(const FvrOptions& o) {
  return o.format.empty() && o.output.extension() == ".nrrd";
}

}  // namespace

namespace {

/// 0 for auto.
double exposure_of(const FvrOptions& o) {
  double exposure = 0;
  if (o.exposure != "auto" && (!CLI::detail::lexical_cast(o.exposure, exposure) || !(exposure > 0))) {
    throw Error("--exposure " + o.exposure + ": expected a positive number or auto");
  }
  return exposure;
}

}  // namespace

namespace {

transfer::BezierTransfer read_curves(const std::filesystem::path& path) {
  const auto bezier = io::is_standard_stream(path) ? std::nullopt : io::read_bezier(path);
  if (!bezier) throw Error(path.string() + ": is not a file of Bezier curves; make one with tf-fit");
  return *bezier;
}

}  // namespace

std::vector<FvrView> fvr_views(const FvrOptions& o, Record& record) {
  if (!o.format.empty() && o.output.extension() == ".nrrd") {
    throw Error("--format " + o.format + " contradicts " + o.output.string() + ", a stack of all views");
  }
  const bool png = o.format == "png" || (o.format.empty() && o.output.extension() == ".png");
  if (o.exposure != "auto" && !png) {
    throw Error("--exposure is for PNG; other pictures hold the values themselves");
  }
  (void)parse_image_size("--size", o.size);
  (void)exposure_of(o);
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

namespace {

image::Image image_of(const std::vector<Buffer<float>>& planes, int width, int height) {
  image::Image image(width, height, {"R", "G", "B", "A"});
  for (std::size_t p = 0; p < planes[0].size(); ++p) {
    float* pixel = &image.pixels[4 * p];
    for (std::size_t c = 0; c < 3; ++c) pixel[c] = planes[planes.size() == 3 ? c : 0][p];
    pixel[3] = 1;
    if (!std::isfinite(pixel[0] + pixel[1] + pixel[2]))
      throw Error("a pixel overflows float; scale the volume");
  }
  return image;
}

/// Picture number i of a stack: x right, y down, z the view.
void put_into(volume::Grid<float>& stack, std::size_t i, const std::vector<Buffer<float>>& planes) {
  if (planes.size() != 1)
    throw Error("a stack (.nrrd) holds grey pictures; leave out --band-colours, or write .exr");
  for (const float value : planes[0]) {
    if (!std::isfinite(value)) throw Error("a pixel overflows float; scale the volume");
  }
  std::copy(planes[0].begin(), planes[0].end(),
            stack.voxels.begin() + static_cast<std::ptrdiff_t>(i * planes[0].size()));
}

void write_stack(const FvrOptions& o, volume::Grid<float> stack, Record& record) {
  volume::Volume volume;
  volume.grid = std::move(stack);
  volume.attributes = record.provenance();
  (void)io::write_volume(o.output, volume);
}

bool is_png(const FvrView& view, const std::string& format) {
  return format == "png" || (format.empty() && view.output.extension() == ".png");
}

}  // namespace

namespace {

struct Job {
  fourier::SliceView view;
  fourier::ChannelWeights weights;
};

std::vector<Job> jobs_of(const FvrOptions& o, const fourier::SpectrumInfo& info,
                         const std::vector<FvrView>& views) {
  const auto size = parse_image_size("--size", o.size);
  const Vec3 centre = info.geometry.centre();
  const double longest = info.geometry.edge_lengths().maxCoeff();
  std::vector<Job> jobs;
  fourier::ChannelWeights curves;  // the same for all views: their file is read once
  for (const auto& v : views) {
    const camera::Camera camera(v.view, centre, longest, size[0], size[1]);
    auto weights = curves.empty() ? fvr_weights(o, info, camera) : curves;
    if (!o.transfer.empty()) curves = weights;
    jobs.push_back({fourier::slice_view(info, camera, size[0], size[1], o.wrap), std::move(weights)});
  }
  return jobs;
}

/// Spectra of files that do not say so are taken at the curves' word.
void warn_of_unknown_range(const FvrOptions& o, const fourier::SpectrumInfo& info, Record& record) {
  if (o.transfer.empty() || info.attributes.contains(kBezierRange)) return;
  record.warn("the spectra do not say over which values their curves are; taken to be those of " +
              o.transfer.string());
}

// The pictures of a run are kept until they are written, so that drawing is timed by itself; of many, in
// lots.
constexpr std::size_t kLot = 64;

}  // namespace

void fvr_require_memory(const FvrOptions& o, const fourier::SpectrumInfo& info,
                        const std::vector<FvrView>& views, std::int64_t spectra, std::int64_t real,
                        Record& record) {
  const auto jobs = jobs_of(o, info, views);
  std::int64_t largest = 0, all = 0;  // planes; all are kept while they are small
  std::int64_t scratch = 0;           // of the largest
  for (const Job& job : jobs) {
    const std::int64_t plane = checked_product(
        fourier::SlicePlane<float>::bytes(job.view.width, job.view.height, job.weights.size()),
        real / static_cast<std::int64_t>(sizeof(float)));
    largest = std::max(largest, plane);
    all = std::min(all + plane, fourier::kKeptPlanes);
    scratch =
        std::max(scratch, real == sizeof(double)
                              ? fourier::SlicePlane<double>::scratch_bytes(job.view.width, job.view.height)
                              : fourier::SlicePlane<float>::scratch_bytes(job.view.width, job.view.height));
  }
  const auto views_count = static_cast<std::int64_t>(jobs.size());
  const std::int64_t pixels = jobs.front().view.picture_width * jobs.front().view.picture_height,
                     channels = static_cast<std::int64_t>(jobs.front().weights.size()),
                     lot = std::min<std::int64_t>(views_count, kLot);
  // Drawn in `real`, kept in float; an image of four floats is made of one at a time, or all go into a stack.
  const std::int64_t pictures = checked_product(pixels * channels, lot * 4 + real),
                     written = checked_product(pixels, is_stack(o) ? 4 * views_count : 4 * 4);
  const std::int64_t bytes = spectra + std::max(largest, all) + scratch + pictures + written;
  record.count("planned_bytes", bytes);
  const std::int64_t limit = io::ReadOptions::physical_memory();
  if (bytes > limit) {
    throw Error("spectra, slices and pictures would take " + std::to_string(bytes >> 20) + " MiB, of " +
                std::to_string(limit >> 20) + " MiB in this machine");
  }
}

void fvr_pictures(const FvrOptions& o, const fourier::SpectrumInfo& info, const std::vector<FvrView>& views,
                  const FvrDraw& draw, Record& record) {
  const auto size = parse_image_size("--size", o.size);
  double exposure = exposure_of(o);
  const auto jobs = jobs_of(o, info, views);
  warn_of_unknown_range(o, info, record);
  volume::Grid<float> stack;
  if (is_stack(o)) {
    const double pitch = jobs.front().view.pitch;
    stack.geometry.dims = {size[0], size[1], static_cast<std::int64_t>(views.size())};
    stack.geometry.spacing = Vec3(pitch, pitch, 1);
    stack.voxels.resize(static_cast<std::size_t>(checked_count(stack.geometry.dims)));
  }
  std::int64_t frames = 0;
  std::vector<std::vector<Buffer<float>>> pictures(std::min(jobs.size(), kLot));
  for (std::size_t first = 0; first < jobs.size(); first += kLot) {
    const std::size_t last = std::min(jobs.size(), first + kLot);
    (void)record.repeated("render", [&] {
      for (std::size_t i = first; i < last; ++i) draw(jobs[i].view, jobs[i].weights, pictures[i - first]);
      return frames += static_cast<std::int64_t>(last - first);
    });
    for (std::size_t i = first; i < last; ++i) {
      if (is_stack(o)) {
        put_into(stack, i, pictures[i - first]);
        continue;
      }
      image::Image image = image_of(pictures[i - first], size[0], size[1]);
      for (const auto& [key, value] : record.provenance()) image.attributes[key] = value;
      image.attributes["precis.view"] = nlohmann::json{views[i].view.azimuth, views[i].view.elevation}.dump();
      if (exposure == 0) exposure = image::exposure_to_white(image);
      record.timed("write", [&] {
        if (is_png(views[i], o.format)) {
          io::write_png(views[i].output, image, {.scale = exposure});
        } else {
          io::write_image(views[i].output, image, o.format);
        }
      });
      record.output(views[i].output);
    }
  }
  if (is_stack(o)) {
    record.timed("write", [&] { write_stack(o, std::move(stack), record); });
    record.output(o.output);
  }
  record.count("views", static_cast<std::int64_t>(views.size()));
  record.count("frames", frames);
  if (!is_stack(o) && is_png(views.front(), o.format)) record.result("exposure", exposure);
}

}  // namespace vol::cli
