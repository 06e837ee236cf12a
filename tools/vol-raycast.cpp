// vol-raycast: ray casting of a volume, uniform, index-guided, or the reference integral.
//   vol-raycast head.nrrd -o head.exr --scene configs/scenes/ct-head.yaml --size 512x512 --stats head.json
//   vol-raycast head.nrrd -o skull.png --isovalue 500 --surface-opacity 0.4 --isovalue 1150 --mesh probe.ply
//   vol-raycast head.nrrd -o truth.exr --scene configs/scenes/ct-head.yaml --quadrature reference --tolerance
//   1e-8
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/heap.h"
#include "cli/camera_options.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/surface_options.h"
#include "cli/volume_input.h"
#include "image/difference.h"
#include "image/exposure.h"
#include "index/build_index.h"
#include "index/classify.h"
#include "io/index.h"
#include "io/scene.h"
#include "io/write_image.h"
#include "render/max_error.h"
#include "render/names.h"
#include "render/packet.h"
#include "render/raycast.h"
#include "render/weighted_field.h"

namespace {

using namespace vol;

struct Options {
  cli::VolumeInput input;
  std::filesystem::path output, scene, transfer, index, index_output, samples_output;
  double epsilon = 0.016;
  std::optional<int> index_reduction;
  std::string format, model, quadrature, step, reconstruction, algorithm = "packet";
  cli::CameraOptions camera;
  cli::SurfaceOptions surfaces;
  std::optional<double> exposure;
  render::RenderOptions render;
  bool no_skip = false;
};

void declare(CLI::App& app, Options& o) {
  cli::add_volume_input(app, o.input);
  app.add_option("-o,--output", o.output,
                 "Picture (.exr: R, G, B, A, samples, depth, with --max-error also error; .png); - is "
                 "standard output")
      ->required()
      ->group("Files");
  app.add_option("--format", o.format, "exr or png [by extension; exr]")->group("Files");
  app.add_option(
         "--samples-output", o.samples_output,
         "A second picture, in false colours: samples per pixel, black 0, light yellow the most (.png, .exr)")
      ->group("Files");
  app.add_option("--scene", o.scene, "Scene (YAML); without it a grey ramp over the volume's range")
      ->group("Files");
  app.add_option("--transfer", o.transfer,
                 "Transfer function (YAML, ParaView's JSON) in place of the scene's; xray is weighted by "
                 "Bezier curves "
                 "of tf-fit, as in fvr-slice")
      ->group("Files");
  app.add_option(
         "--index", o.index,
         "Index volume of vol-index: where steps may be longer; auto: made for this scene, by --epsilon")
      ->group("Files");
  app.add_option("--index-output", o.index_output, "Where to keep the index that --index auto makes (.nrrd)")
      ->group("Files");

  const char* picture = "Picture (overrules the scene)";
  cli::add_camera(app, o.camera, picture);
  app.add_option("--model", o.model,
                 "composite (emission-absorption), xray (integral), mip (maximum) [composite]")
      ->check(CLI::IsMember({"composite", "xray", "mip"}))
      ->group(picture);

  app.add_option("--exposure", o.exposure,
                 "PNG: what values are multiplied by [composite 1; xray, mip: the largest becomes white]")
      ->check(cli::check_positive)
      ->group(picture);

  cli::add_surfaces(app, o.surfaces);

  const char* accuracy = "Accuracy against cost";
  app.add_option("--quadrature", o.quadrature,
                 "rectangle (order 1), trapezoid, preintegrated (order 2), split (Gauss rules cell by cell), "
                 "reference (adaptive) [trapezoid]")
      ->check(CLI::IsMember({"rectangle", "trapezoid", "preintegrated", "split", "reference"}))
      ->group(accuracy);
  app.add_option("--nodes", o.render.nodes, "Split: Gauss nodes a smooth piece, 1 to 3")
      ->check(CLI::Range(1, 3))
      ->capture_default_str()
      ->group(accuracy);
  app.add_option("--step", o.step,
                 "Between samples: world length, or 0.5v for half the smallest spacing [0.5v]")
      ->group(accuracy);
  app.add_option("--epsilon", o.epsilon,
                 "Index auto: optical depth of a standard step (--step) below which a detail does not count")
      ->check(cli::check_non_negative)
      ->capture_default_str()
      ->group(accuracy);
  app.add_option("--index-reduction", o.index_reduction, "Index auto: one entry for N^3 cells, 1 to 1024 [1]")
      ->check(CLI::Range(1, 1024))
      ->group(accuracy);
  app.add_option("--reconstruction", o.reconstruction,
                 "nearest, trilinear, catmull-rom, b-spline [trilinear]")
      ->check(CLI::IsMember({"nearest", "trilinear", "catmull-rom", "b-spline"}))
      ->group(accuracy);
  app.add_option("--tolerance", o.render.tolerance,
                 "Reference: absolute error of a pixel, on the colour scale")
      ->check(cli::check_positive)
      ->capture_default_str()
      ->group(accuracy);
  app.add_option("--termination", o.render.termination,
                 "End a ray at this transmittance, 0 to 1; 0 for truth")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->group(accuracy);
  auto* max_error =
      app.add_option(
             "--max-error", o.render.max_error,
             "Largest error of the picture, colour scale 0 to 1: sets quadrature and pieces ray by ray; "
             "status 2 if "
             "it is not kept")
          ->check(cli::check_positive)
          ->group(accuracy);
  app.add_option(
         "--image-step", o.render.image_step,
         "Rays at every so many pixels (2, 4 .. 64) and where these do not suffice, the rest interpolated")
      ->check(CLI::IsMember({1, 2, 4, 8, 16, 32, 64}))
      ->capture_default_str()
      ->group(accuracy);
  app.add_option("--image-tolerance", o.render.image_tolerance,
                 "With --image-step: by how much interpolation may miss a ray, on the colour scale")
      ->check(cli::check_non_negative)
      ->capture_default_str()
      ->group(accuracy);
  for (const char* chosen :
       {"--quadrature", "--nodes", "--step", "--tolerance", "--termination", "--image-step",
        "--image-tolerance", "--index", "--epsilon", "--index-reduction", "--isovalue", "--mesh"}) {
    max_error->excludes(app.get_option(chosen));
  }
  app.add_flag("--no-skip", o.no_skip, "Sample also what the transfer function makes invisible")
      ->group(accuracy);
  app.add_option("--algorithm", o.algorithm,
                 "packet (float, SIMD) or plain (double, its oracle; surfaces are drawn by it always)")
      ->excludes(max_error)
      ->check(CLI::IsMember({"packet", "plain"}))
      ->capture_default_str()
      ->group(accuracy);
}

/// Colour and opacity proportional to the value over the volume's range, opacity up to 0.1 a voxel.
transfer::TransferFunction grey_ramp(const volume::Range& range) {
  return {{{range.min, Vec3::Zero()}, {range.max, Vec3::Ones()}}, {{range.min, 0}, {range.max, 0.1}}};
}

/// The scene file with the command line over it; fills o.render but for the step.
io::SceneFile resolve(Options& o) {
  io::SceneFile file = o.scene.empty() ? io::SceneFile{} : io::read_scene(o.scene);
  if (!o.transfer.empty()) {
    if (io::is_standard_stream(o.transfer))
      throw Error("--transfer is a file: its name says what form it has");
    file.bezier = io::read_bezier(o.transfer);
    file.scene.transfer = io::read_transfer_function(o.transfer);
    file.has_transfer = true;
  }
  cli::apply(o.camera, file.scene.view);
  if (!o.model.empty()) file.scene.model = render::model_from_name(o.model);
  const auto size = cli::parse_image_size("--size", o.camera.size);
  o.render.width = size[0];
  o.render.height = size[1];
  if (file.quadrature) o.render.quadrature = *file.quadrature;
  if (!o.quadrature.empty()) o.render.quadrature = render::quadrature_from_name(o.quadrature);
  if (o.render.max_error > 0) o.render.quadrature = render::Quadrature::split;  // whatever the scene says
  if (file.reconstruction) o.render.reconstruction = *file.reconstruction;
  if (!o.reconstruction.empty()) o.render.reconstruction = render::reconstruction_from_name(o.reconstruction);
  o.render.skip_empty = !o.no_skip;
  return file;
}

/// What the packets, where they are asked for, prepare before the first picture.
struct Prepared {
  std::optional<render::PacketVolume> volume;
  std::optional<render::PacketScene> scene;

  Prepared(const volume::Volume& from, const render::Scene& wanted, const Options& o,
           const index::IndexVolume* index) {
    const bool packets = o.algorithm == "packet" || o.render.max_error > 0;
    if (!packets || o.surfaces.any() || o.render.quadrature == render::Quadrature::reference) return;
    volume.emplace(from, wanted.model == render::Model::composite);
    scene.emplace(*volume, wanted, o.render.max_error > 0 ? render::within_error(o.render) : o.render, index);
  }
};

/// One picture.
render::RenderResult cast(const volume::Volume& volume, const Prepared& prepared, const render::Scene& scene,
                          const Options& o, const cli::SurfaceSet& surfaces,
                          const index::IndexVolume* index) {
  if (o.surfaces.any()) {
    return render::raycast_with_surfaces(volume, scene, o.render, surfaces.surfaces(), index);
  }
  if (o.render.quadrature == render::Quadrature::reference) {
    return render::raycast_reference(volume, scene, o.render);
  }
  if (o.render.max_error > 0) return render::cast_within_error(*prepared.scene, scene.view);
  if (prepared.scene) return prepared.scene->cast(scene.view);
  if (o.render.quadrature == render::Quadrature::split) {
    return render::raycast_split_plain(volume, scene, o.render);
  }
  return render::raycast_plain(volume, scene, o.render, index);
}

/// One picture, prepared and cast, each timed.
render::RenderResult drawn(const volume::Volume& volume, const render::Scene& scene, const Options& o,
                           cli::SurfaceSet& surfaces, const index::IndexVolume* index, cli::Record& record) {
  const auto prepared =
      record.timed("prepare", [&] { return std::make_unique<const Prepared>(volume, scene, o, index); });
  if (o.surfaces.any()) surfaces.prepare(volume, o.render.reconstruction, scene, record);
  return record.repeated("render", [&] { return cast(volume, *prepared, scene, o, surfaces, index); });
}

/// Puts one picture's X-ray into a channel of another's; what was done for it and may be wrong is added.
void add_channel(render::RenderResult& result, const render::RenderResult& one, int channel) {
  const auto samples = one.image.channel("samples"), error = one.image.channel("error");
  for (int y = 0; y < one.image.height; ++y) {
    for (int x = 0; x < one.image.width; ++x) {
      result.image.at(x, y, channel) = one.image.at(x, y, channel);
      if (samples) result.image.at(x, y, *samples) += one.image.at(x, y, *samples);
      if (error) {
        float& most = result.image.at(x, y, *error);
        most = std::max(most, one.image.at(x, y, *error));
      }
    }
  }
  result.counts += one.counts;
  result.error_estimate = std::max(result.error_estimate, one.error_estimate);
}

/// The X-ray of the field weighted by Bezier curves, of grey ones one picture, of colours one a channel. A
/// phase is all channels' work, and so are the counts and the picture's samples.
/// \param volume  given up
render::RenderResult cast_weighted(volume::Volume volume, const transfer::BezierTransfer& bezier,
                                   const render::Scene& scene, const Options& o,
                                   const cli::SurfaceSet& surfaces, cli::Record& record) {
  const int channels = bezier.grey() ? 1 : 3;
  std::vector<volume::Volume> weighted;  // none moves once there is something prepared for it
  record.timed("weight", [&] {
    for (int c = 0; c < channels; ++c) weighted.push_back(render::weighted_volume(volume, bezier, c));
  });
  volume = {};
  std::vector<std::unique_ptr<const Prepared>> prepared;
  record.timed("prepare", [&] {
    for (const auto& w : weighted) prepared.push_back(std::make_unique<const Prepared>(w, scene, o, nullptr));
  });
  return record.repeated("render", [&] {
    render::RenderResult result = cast(weighted[0], *prepared[0], scene, o, surfaces, nullptr);
    for (std::size_t c = 1; c < weighted.size(); ++c) {
      add_channel(result, cast(weighted[c], *prepared[c], scene, o, surfaces, nullptr), static_cast<int>(c));
    }
    return result;
  });
}

/// The index of the field as the scene's transfer function shows it (vol-index --scene), for the step asked
/// for.
index::IndexVolume index_of_scene(const volume::Volume& volume, const render::Scene& scene,
                                  const Options& o) {
  if (scene.model != render::Model::composite) throw Error("--index auto: the model must be composite");
  // As many levels as the longest axis has, at most 4: a coefficient of level 4 spans 16 voxels.
  const Dims& dims = volume.geometry().dims;
  const std::int64_t longest = std::max({dims[0], dims[1], dims[2]});
  int levels = 0;
  while (levels < 4 && (longest >> (levels + 1)) > 0) ++levels;
  index::SignificanceOptions significance;
  significance.epsilon = o.epsilon;
  significance.rule = index::Rule::segment;
  significance.energy_share = 0.99;
  index::IndexOptions options;
  options.standard_distance = o.render.step;
  options.reconstruction = o.render.reconstruction;
  options.reduction = o.index_reduction.value_or(1);
  wavelet::DwtOptions dwt;
  dwt.wavelet = "haar";
  dwt.levels = levels;
  return index::build_index(
      index::significant_classified_details(volume, scene.transfer, scene.reference_length,
                                            options.standard_distance, dwt, significance),
      volume.geometry(), options);
}

void report(const render::RenderResult& result, const Options& o, cli::Record& record) {
  record.result("caster", result.caster);
  record.count("rays", result.counts.rays);
  record.count("samples", result.counts.samples);
  record.count("gradients", result.counts.gradients);
  record.count("skipped", result.counts.skipped);
  record.count("terminated", result.counts.terminated);
  if (o.surfaces.any()) {
    record.count("surface_hits", result.counts.surface_hits);
    record.count("surface_undecided", result.counts.surface_undecided);
  }
  if (result.counts.rays > 0) {
    record.result("samples_per_ray", double(result.counts.samples) / double(result.counts.rays));
  }
  if (o.render.max_error > 0) {
    record.error("pixel_maximum_estimate", result.error_estimate);
    return;
  }
  if (o.render.quadrature == render::Quadrature::reference) {
    record.error("pixel_maximum_estimate", result.error_estimate);
    if (result.error_estimate > 10 * o.render.tolerance) {
      record.warn("the reference reached an error of about " + std::to_string(result.error_estimate));
    }
  }
}

/// Where the work went: the channel `samples` in false colours, the largest as the colour scale's end.
void write_samples(const image::Image& picture, const Options& o, cli::Record& record) {
  image::Image samples(picture.width, picture.height, {"samples"});
  const int channel = picture.channel("samples").value();
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) samples.at(x, y, 0) = picture.at(x, y, channel);
  }
  const double most = image::largest_magnitude(samples);
  image::Image shown = image::false_colour(samples, most > 0 ? most : 1, image::DifferenceKind::absolute);
  shown.attributes = picture.attributes;
  shown.attributes["precis.samples_scale"] = nlohmann::json(most).dump();
  record.timed("write", [&] { io::write_image(o.samples_output, shown); });
  record.result("samples_largest", most);
  record.output(o.samples_output);
}

/// What a PNG's values are multiplied by: those of an X-ray and of a maximum are no colours.
double exposure_of(const image::Image& picture, const render::Scene& scene, const Options& o) {
  if (o.exposure) return *o.exposure;
  if (scene.model == render::Model::composite) return 1;
  return image::exposure_to_white(picture);
}

int work(Options& o, cli::Record& record) {
  io::require_image_format(o.output, o.format);
  if (!o.samples_output.empty()) io::require_image_format(o.samples_output);
  io::SceneFile file = resolve(o);  // wrong words are answered before a large file is read
  cli::SurfaceSet surfaces(o.surfaces);
  if (o.surfaces.any() && file.scene.model != render::Model::composite) {
    throw Error("--isovalue and --mesh: the model must be composite");
  }
  const bool weighted = file.bezier && file.scene.model == render::Model::xray;
  if (!o.transfer.empty() && file.scene.model != render::Model::composite && !weighted) {
    throw Error("--transfer: " + std::string(file.scene.model == render::Model::xray
                                                 ? "xray is weighted by Bezier curves alone (tf-fit)"
                                                 : "mip takes no transfer function"));
  }
  if (weighted && !o.index.empty()) {
    throw Error("--index: its bound is for the field itself, not for an X-ray weighted by Bezier curves");
  }
  surfaces.load(record);
  if (!o.scene.empty()) record.input(o.scene);
  if (!o.transfer.empty()) record.input(o.transfer);
  volume::Volume volume = cli::load(o.input, record);
  const double spacing = volume.geometry().spacing.minCoeff();
  render::Scene& scene = file.scene;
  if (!file.has_transfer) scene.transfer = grey_ramp(volume::value_range(volume));
  if (scene.reference_length == 0) scene.reference_length = spacing;

  std::optional<index::IndexVolume> index;
  const bool automatic = o.index == "auto";
  if (!o.index.empty() && o.render.quadrature >= render::Quadrature::split) {
    throw Error("--index: quadratures split and reference take no steps");
  }
  if (!o.index_output.empty() && !automatic) throw Error("--index-output keeps the index of --index auto");
  if (o.index_reduction && !automatic) throw Error("--index-reduction is for --index auto");
  if (!o.index.empty() && !automatic) {
    record.input(o.index);
    auto read = record.timed("read", [&] { return io::read_index(o.index); });
    index = std::move(read.index);
    record.resolved("index", read.attributes);
    o.render.step = index->standard_distance();
  }
  const std::string step = !o.step.empty() ? o.step : file.step.value_or("0.5v");
  if (!index || !o.step.empty()) o.render.step = cli::parse_step("--step", step, spacing);
  if (index && std::abs(o.render.step / index->standard_distance() - 1) > 1e-6) {
    record.warn("--step differs from the index's standard distance, " +
                std::to_string(index->standard_distance()) + ": its bound does not hold");
  }
  if (automatic) {
    index = record.timed("index", [&] { return index_of_scene(volume, scene, o); });
    return_freed_memory();
    record.count("index_bytes", static_cast<std::int64_t>(index->nibbles().size()));
  }
  record.resolved("scene", io::to_json(scene));
  record.resolved("quadrature", render::name(o.render.quadrature));
  record.resolved("reconstruction", render::name(o.render.reconstruction));
  if (o.render.max_error == 0) record.resolved("step_world", o.render.step);

  if (weighted) record.resolved("transfer", io::to_json(*file.bezier));
  const index::IndexVolume* const guide = index ? &*index : nullptr;
  auto result = weighted ? cast_weighted(std::move(volume), *file.bezier, scene, o, surfaces, record)
                         : drawn(volume, scene, o, surfaces, guide, record);
  report(result, o, record);
  if (o.render.max_error > 0 && !(result.error_estimate <= o.render.max_error)) {
    throw Error("--max-error: an error of about " + nlohmann::json(result.error_estimate).dump() +
                " is the least that this scene can be drawn with");
  }
  for (const auto& [key, value] : record.provenance()) result.image.attributes[key] = value;
  const Vec3& b = scene.background;
  result.image.attributes["precis.background"] = nlohmann::json{b[0], b[1], b[2]}.dump();
  const double exposure = exposure_of(result.image, scene, o);
  record.timed("write", [&] {
    io::write_image(o.output, result.image, o.format, {b[0], b[1], b[2]}, exposure);
  });
  if (!o.samples_output.empty()) write_samples(result.image, o, record);
  if (!o.index_output.empty()) {
    record.timed("write",
                 [&] { io::write_index(o.index_output, *index, volume.geometry(), record.provenance()); });
    record.output(o.index_output);
  }
  record.output(o.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Ray casting of a volume to a picture: emission-absorption, X-ray or maximum projection.\n"
      "Steps may be uniform or guided by an index; --quadrature reference is the truth, to a stated "
      "tolerance.\n"
      "--isovalue and --mesh put surfaces into it, opaque or translucent, at their exact depth."};
  Options options;
  declare(app, options);
  return cli::run(
      app,
      {.name = "vol-raycast",
       .example = "vol-phantom marschner-lobb -o - | vol-raycast - -o ml.exr --view 30,20 --size 256x256",
       .references = "Max 1995; He 1998",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
