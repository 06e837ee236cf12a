#include "cli/raycast_options.h"

#include "base/error.h"
#include "cli/options.h"
#include "io/file.h"
#include "render/names.h"
#include "render/packet.h"

namespace vol::cli {

void add_raycast(CLI::App& app, RaycastOptions& o) {
  add_volume_input(app, o.input);
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
  add_camera(app, o.camera, picture);
  app.add_option("--model", o.model,
                 "composite (emission-absorption), xray (integral), mip (maximum) [composite]")
      ->check(CLI::IsMember({"composite", "xray", "mip"}))
      ->group(picture);

  app.add_option("--exposure", o.exposure,
                 "PNG: what values are multiplied by [composite 1; xray, mip: the largest becomes white]")
      ->check(check_positive)
      ->group(picture);

  add_surfaces(app, o.surfaces);
  add_labels(app, o.labels);

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
  app.add_option(
         "--step-tolerance", o.render.step_tolerance,
         "Trapezoid: --step is the longest, and halved, down to a 16th of it, where two steps differ from "
         "one over both by more than this in the pixel, on the colour scale; with shading also where a step "
         "adds much to the pixel for its length in voxels; 0: steps all the same. No bound on the pixel's "
         "error.")
      ->check(check_finite)
      ->check(check_non_negative)
      ->capture_default_str()
      ->group(accuracy);
  app.add_option("--epsilon", o.epsilon,
                 "Index auto: optical depth of a standard step (--step) below which a detail does not count")
      ->check(check_non_negative)
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
      ->check(check_positive)
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
          ->check(check_positive)
          ->group(accuracy);
  app.add_option(
         "--image-step", o.render.image_step,
         "Rays at every so many pixels (2, 4 .. 64) and where these do not suffice, the rest interpolated")
      ->check(CLI::IsMember({1, 2, 4, 8, 16, 32, 64}))
      ->capture_default_str()
      ->group(accuracy);
  app.add_option("--image-tolerance", o.render.image_tolerance,
                 "With --image-step: by how much interpolation may miss a ray, on the colour scale")
      ->check(check_non_negative)
      ->capture_default_str()
      ->group(accuracy);
  for (const char* chosen : {"--quadrature", "--nodes", "--step", "--step-tolerance", "--tolerance",
                             "--termination", "--image-step", "--image-tolerance", "--index", "--epsilon",
                             "--index-reduction", "--isovalue", "--mesh", "--labels"}) {
    max_error->excludes(app.get_option(chosen));
  }
  app.get_option("--step-tolerance")->excludes(app.get_option("--index"));
  app.add_flag("--no-skip", o.no_skip, "Sample also what the transfer function makes invisible")
      ->group(accuracy);
  app.add_option(
         "--algorithm", o.algorithm,
         "packet (float, SIMD) or plain (double, its oracle; surfaces and labels are drawn by it always)")
      ->excludes(max_error)
      ->check(CLI::IsMember({"packet", "plain"}))
      ->capture_default_str()
      ->group(accuracy);
  app.add_option(
         "--layout", o.layout,
         "Of the voxels in memory: rows as they are read, or blocks, in which neighbours along every "
         "axis share pages: the same picture; frames of volumes larger than the caches take less time, "
         "preparing them takes more. For what packets draw, without --max-error")
      ->check(CLI::IsMember({"rows", "blocks"}))
      ->capture_default_str()
      ->group(accuracy);
}

namespace {

/// The scene file with the command line over it; fills o.render but for the step.
io::SceneFile resolve(RaycastOptions& o) {
  io::SceneFile file = o.scene.empty() ? io::SceneFile{} : io::read_scene(o.scene);
  if (!o.transfer.empty()) {
    if (io::is_standard_stream(o.transfer))
      throw Error("--transfer is a file: its name says what form it has");
    file.bezier = io::read_bezier(o.transfer);
    file.scene.transfer = io::read_transfer_function(o.transfer);
    file.has_transfer = true;
  }
  apply(o.camera, file.scene.view);
  if (!o.model.empty()) file.scene.model = render::model_from_name(o.model);
  const auto size = parse_image_size("--size", o.camera.size);
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

/// Packets alone read blocks, and a bound on the error may need the voxels in rows.
void refuse_blocks(const RaycastOptions& o, const render::Scene& scene) {
  const char* const other = o.algorithm == "plain"   ? "--algorithm plain"
                            : o.surfaces.any()       ? "--isovalue and --mesh"
                            : o.labels.any()         ? "--labels"
                            : o.render.max_error > 0 ? "--max-error"
                                                     : render::not_for_packets(scene, o.render);
  if (other != nullptr)
    throw Error("--layout blocks is for what packets draw, not for " + std::string(other));
}

/// What cannot be drawn together, answered before a large file is read.
void refuse(const RaycastOptions& o, const io::SceneFile& file) {
  const render::Model model = file.scene.model;
  const bool composite = model == render::Model::composite;
  if (o.surfaces.any() && !composite) throw Error("--isovalue and --mesh: the model must be composite");
  if (o.labels.any() && !composite) throw Error("--labels: the model must be composite");
  const bool weighted = is_weighted(file);
  if (!o.transfer.empty() && !composite && !weighted) {
    throw Error("--transfer: " + std::string(model == render::Model::xray
                                                 ? "xray is weighted by Bezier curves alone (tf-fit)"
                                                 : "mip takes no transfer function"));
  }
  if (weighted && !o.index.empty()) {
    throw Error("--index: its bound is for the field itself, not for an X-ray weighted by Bezier curves");
  }
  if (o.labels.any() && o.render.quadrature != render::Quadrature::rectangle &&
      o.render.quadrature != render::Quadrature::trapezoid) {
    throw Error("--labels: quadrature " + std::string(render::name(o.render.quadrature)) +
                " follows the value between samples; rectangle and trapezoid draw labels");
  }
  if (!o.index.empty() && o.render.quadrature >= render::Quadrature::split) {
    throw Error("--index: quadratures split and reference take no steps");
  }
  if (o.layout == "blocks") refuse_blocks(o, file.scene);
  if (!o.index_output.empty() && o.index != "auto") {
    throw Error("--index-output keeps the index of --index auto");
  }
  if (o.index_reduction && o.index != "auto") throw Error("--index-reduction is for --index auto");
  if (o.index == "auto" && !composite) throw Error("--index auto: the model must be composite");
}

}  // namespace

bool is_weighted(const io::SceneFile& file) {
  return file.bezier && file.scene.model == render::Model::xray;
}

io::SceneFile resolve_scene(RaycastOptions& o) {
  io::SceneFile file = resolve(o);
  refuse(o, file);
  return file;
}

}  // namespace vol::cli
