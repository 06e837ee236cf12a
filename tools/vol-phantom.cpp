// vol-phantom: a synthetic volume whose continuous field is known in closed form.
//   vol-phantom protein --dims 64x64x64 --type u8 -o protein.nrrd
//   vol-phantom noise --seed 7 --spacing 1,1,2.5 -o - | vol-info -
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/error.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/volume_input.h"
#include "curvilinear/phantom.h"
#include "io/any_volume.h"
#include "io/grid.h"
#include "volume/analytic_field.h"
#include "volume/analytic_texture.h"

namespace {

using namespace vol;

struct Options {
  std::string name;
  std::filesystem::path output, labels_output;
  std::string format;
  std::string dims;   // empty: 64x64x64, or what the grid phantom says
  std::string field;  // empty: gaussian
  std::string spacing = "1";
  std::string origin = "0";
  std::string type = "f32";
  std::vector<double> scale_range;
  std::uint64_t seed = volume::AnalyticOptions{}.seed;
  bool compress = false;
};

std::string described_names() {
  std::string text = "Fields:";
  for (const auto& [name, description] : volume::analytic_field_names()) {
    text += "\n  " + std::string(name) + std::string(16 - std::min<std::size_t>(15, name.size()), ' ') +
            std::string(description);
  }
  text += "\nCurvilinear grids (.vts):";
  for (const auto& [name, description, dims] : curvilinear::phantom_names()) {
    text += "\n  " + std::string(name) + std::string(17 - name.size(), ' ') +
            std::string(description.substr(description.find(':') + 2)) + " [" + std::to_string(dims[0]) +
            "x" + std::to_string(dims[1]) + "x" + std::to_string(dims[2]) + "]";
  }
  return text;
}

void declare(CLI::App& app, Options& o) {
  std::vector<std::string> names;
  for (const auto& entry : volume::analytic_field_names()) names.emplace_back(entry.name);
  const std::vector<std::string> fields = names;
  for (const auto& entry : curvilinear::phantom_names()) names.emplace_back(entry.name);
  app.add_option("name", o.name, "Which field; the list stands below")
      ->required()
      ->check(CLI::IsMember(names))
      ->type_name("NAME");
  app.add_option("-o,--output", o.output, "Volume or grid (.vts); format by extension; - is standard output")
      ->required()
      ->group("Files");
  app.add_option("--format", o.format, "Format where the extension does not say: nrrd, mha, vti, vdb, raw")
      ->group("Files");
  app.add_option("--labels-output", o.labels_output,
                 "Of texture: a second volume, u8, the region of every voxel")
      ->group("Files");
  app.add_flag("--compress", o.compress, "zlib, where the format has it")->group("Files");
  app.add_option("--dims", o.dims, "Samples along x, y, z, or one number for a cube [64; a grid has its own]")
      ->group("Grid");
  app.add_option("--spacing", o.spacing, "World distance between samples: x,y,z or one number")
      ->capture_default_str()
      ->group("Grid");
  app.add_option("--origin", o.origin, "World position of the first sample: x,y,z")
      ->capture_default_str()
      ->group("Grid");
  app.add_option("--type", o.type, "Voxel type; integers are scaled, see --scale-range")
      ->check(CLI::IsMember({"i8", "u8", "i16", "u16", "i32", "u32", "f16", "f32", "f64"}))
      ->capture_default_str()
      ->group("Values");
  app.add_option(
         "--scale-range", o.scale_range,
         "Field values that go to 0 and the largest (unsigned) or to -+ the largest voxel (signed types), "
         "others are clamped [the field's range; of protein the positive part alone for unsigned types]")
      ->delimiter(',')
      ->expected(2)
      ->type_name("LO,HI")
      ->group("Values");
  app.add_option("--field", o.field,
                 "Field at the points of a curvilinear grid, of the list below [gaussian]")
      ->check(CLI::IsMember(fields))
      ->type_name("NAME")
      ->group("Values");
  app.add_option("--seed", o.seed, "Seed of gaussians, protein, noise and texture")
      ->check(cli::check_whole_number)
      ->capture_default_str()
      ->group("Values");
}

bool is_grid(const std::string& name) {
  const auto& all = curvilinear::phantom_names();
  return std::any_of(all.begin(), all.end(), [&](const auto& phantom) { return phantom.name == name; });
}

int make_grid(const Options& o, cli::Record& record) {
  io::require_grid_output(o.output);
  const Dims dims = o.dims.empty() ? Dims{0, 0, 0} : cli::parse_dims("--dims", o.dims);
  const std::string field = o.field.empty() ? "gaussian" : o.field;
  auto grid =
      record.repeated("sample", [&] { return curvilinear::make_phantom(o.name, dims, field, o.seed); });
  record.seed(o.seed);
  record.count("cells", grid.cell_count());
  for (const auto& [key, value] : record.provenance()) grid.attributes[key] = value;
  for (const auto& lost : record.timed("write", [&] { return io::write_grid(o.output, grid); }))
    record.warn(lost);
  record.output(o.output);
  return 0;
}

int make_phantom(const Options& o, cli::Record& record) {
  if (is_grid(o.name)) return make_grid(o, record);
  if (!o.field.empty()) throw Error("--field goes with curvilinear grids; " + o.name + " is a field itself");
  io::require_volume_output(o.output, o.format);
  if (!o.labels_output.empty()) {
    if (o.name != "texture") throw Error("--labels-output: " + o.name + " has no regions; texture has");
    io::require_volume_output(o.labels_output, "");
  }
  volume::AnalyticOptions options;
  options.seed = o.seed;
  options.geometry.dims = cli::parse_dims("--dims", o.dims.empty() ? "64" : o.dims);
  options.geometry.spacing = cli::parse_vec3("--spacing", o.spacing);
  options.geometry.origin = cli::parse_vec3("--origin", o.origin);
  const volume::VoxelType type = volume::voxel_type_from_name(o.type);
  const auto field = volume::make_analytic_field(o.name, options);
  volume::Range scale = volume::default_scale(field, type);
  if (!o.scale_range.empty()) {
    scale = {o.scale_range[0], o.scale_range[1]};
    if (!(scale.min < scale.max && std::isfinite(scale.max - scale.min))) {
      throw Error("--scale-range: expected finite LO < HI");
    }
  }
  auto phantom = record.repeated("sample", [&] { return volume::sampled_volume(field, type, scale); });
  record.seed(o.seed);
  record.count("voxels", options.geometry.count());
  if (!volume::is_floating_point(type)) record.result("scale_range", {scale.min, scale.max});
  cli::save(o.output, phantom, record, o.format, o.compress);
  if (!o.labels_output.empty()) {
    auto labels = record.timed("labels", [&] { return volume::texture_labels(options.geometry); });
    cli::save(o.labels_output, labels, record, "", o.compress);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Writes a volume, on the box spanned by the outermost samples, or a curvilinear grid, of a field that "
      "is known "
      "in closed form.\nFloating-point types hold the field itself; integer types are scaled to their "
      "range."};
  Options o;
  declare(app, o);
  app.footer(described_names());
  return cli::run(app,
                  {.name = "vol-phantom",
                   .example = "vol-phantom marschner-lobb --dims 41x41x41 -o ml.nrrd",
                   .references = "Marschner & Lobb 1994 (marschner-lobb)",
                   .repeats = true},
                  argc, argv, [&](cli::Record& record) { return make_phantom(o, record); });
}
