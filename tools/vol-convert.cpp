// vol-convert: format, voxel type, range, box, size and orientation of a volume; the difference of two.
//   vol-convert head.nii.gz -o head.nrrd --type u8 --rescale 0,255
//   vol-convert ironProt.vtk --crop 2,2,2:66,66,66 --subtract neghip.nrrd -o signed.nrrd
#include <nlohmann/json.hpp>
#include <vector>

#include "base/error.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/volume_input.h"
#include "io/any_volume.h"
#include "io/index.h"
#include "volume/arithmetic.h"
#include "volume/rearrange.h"
#include "volume/resample.h"

namespace {

using namespace vol;
using volume::Volume;
using volume::VoxelType;

struct Options {
  cli::VolumeInput input;
  std::filesystem::path output, subtract;
  std::string format, type, crop, resample, kernel = "trilinear", transpose, flip;
  std::vector<double> rescale, scale;
  std::int64_t pad = 0;
  double pad_value = 0;
  bool keep_geometry = false, compress = false;
};

void declare(CLI::App& app, Options& o) {
  o.input.index_volumes = true;
  cli::add_volume_input(app, o.input);
  app.add_option("-o,--output", o.output, "Volume; format by extension; - is standard output")
      ->required()
      ->group("Files");
  app.add_option("--format", o.format,
                 "Format where the extension does not say: nrrd, mha, vti, vdb, raw [nrrd]")
      ->group("Files");
  app.add_flag("--compress", o.compress, "zlib, where the format has it")->group("Files");

  const char* box = "Box and size (in this order)";
  app.add_option("--crop", o.crop, "Keep the voxels of a half-open box of indices: x0,y0,z0:x1,y1,z1")
      ->group(box);
  app.add_option(
         "--subtract", o.subtract,
         "Take away another volume of the same dims, after --crop; signed. The result is i16 for 8-bit "
         "integers, f32 up to 16 bits, else f64; geometry of the input")
      ->group(box);
  auto* pad = app.add_option("--pad", o.pad, "Add voxels on all six sides")
                  ->check(cli::check_whole_number)
                  ->capture_default_str()
                  ->group(box);
  app.add_option("--pad-value", o.pad_value, "Value of the added voxels")
      ->check(cli::check_finite)
      ->capture_default_str()
      ->needs(pad)
      ->group(box);
  auto* resample =
      app.add_option("--resample", o.resample,
                     "Sample the field anew: NXxNYxNZ samples over the same box (the outermost centres stay)")
          ->group(box);
  app.add_option("--kernel", o.kernel, "How --resample reconstructs the field")
      ->check(CLI::IsMember({"nearest", "trilinear", "catmull-rom", "b-spline"}))
      ->capture_default_str()
      ->needs(resample)
      ->group(box);
  app.add_option("--transpose", o.transpose,
                 "New order of the axes: zyx swaps x and z; the field stays in its place")
      ->group(box);
  app.add_option(
         "--flip", o.flip,
         "Reverse the order of the voxels along x, y, z or several (xz); the field stays in its place")
      ->group(box);
  app.add_flag(
         "--keep-geometry", o.keep_geometry,
         "Leave origin and directions as they are under --transpose and --flip: the content moves instead")
      ->group(box);

  const char* values = "Values (last; integers are rounded and clamped once, at the end)";
  auto* rescale = app.add_option("--rescale", o.rescale, "Map the volume's range linearly onto [LO, HI]")
                      ->delimiter(',')
                      ->expected(2)
                      ->type_name("LO,HI")
                      ->group(values);
  app.add_option("--scale", o.scale, "Map each value v to A v + B")
      ->delimiter(',')
      ->expected(2)
      ->type_name("A,B")
      ->excludes(rescale)
      ->group(values);
  app.add_option("--type", o.type, "Voxel type of the result [that of the input]")
      ->check(CLI::IsMember({"i8", "u8", "i16", "u16", "i32", "u32", "f16", "f32", "f64"}))
      ->group(values);
}

/// The floating-point type that arithmetic between two voxel types is done in.
VoxelType working_type(VoxelType from, VoxelType to) {
  const auto wide = [](VoxelType type) {
    return type == VoxelType::i32 || type == VoxelType::u32 || type == VoxelType::f64;
  };
  return wide(from) || wide(to) ? VoxelType::f64 : VoxelType::f32;
}

void rearrange(Volume& v, const Options& o) {
  const auto before = v.geometry();
  if (!o.transpose.empty()) v = volume::transposed(v, volume::axis_order(o.transpose));
  for (const char axis : o.flip) {
    if (axis < 'x' || axis > 'z') throw Error("--flip " + o.flip + ": expected axes such as x or xz");
    v = volume::flipped(v, axis - 'x');
  }
  if (o.keep_geometry) {
    v.geometry().origin = before.origin;
    v.geometry().direction = before.direction;
  }
}

/// Of an index volume the entries.
Volume loaded(const std::filesystem::path& path, const Options& o, cli::Record& record) {
  Volume v = cli::load(path, o.input, record);
  return io::is_index(v) ? io::unpack_index(v) : std::move(v);
}

Volume converted(Volume v, const Options& o, cli::Record& record) {
  if (!o.crop.empty()) {
    const auto region = cli::parse_region("--crop", o.crop);
    v = volume::cropped(v, region.lower, region.upper);
  }
  if (!o.subtract.empty()) v = volume::difference(v, loaded(o.subtract, o, record));
  const VoxelType type = o.type.empty() ? v.voxel_type() : volume::voxel_type_from_name(o.type);
  const bool scaled = !o.scale.empty() || !o.rescale.empty();
  if (!o.resample.empty() && (scaled || type != v.voxel_type())) {
    const VoxelType working = working_type(v.voxel_type(), type);  // so that nothing is rounded twice
    v = volume::as_type(std::move(v), working);
  }
  if (o.pad > 0) v = volume::padded(v, o.pad, o.pad_value);
  if (!o.resample.empty()) {
    v = volume::resampled(v, cli::parse_dims("--resample", o.resample),
                          volume::reconstruction_from_name(o.kernel));
  }
  rearrange(v, o);
  if (!o.rescale.empty()) return volume::rescaled(v, o.rescale[0], o.rescale[1], type);
  if (!o.scale.empty()) return volume::scaled(v, o.scale[0], o.scale[1], type);
  return volume::as_type(std::move(v), type);
}

int convert(const Options& o, cli::Record& record) {
  io::require_volume_output(o.output, o.format);
  if (o.input.path == "-" && o.subtract == "-") throw Error("only one volume can come from standard input");
  Volume input = loaded(o.input.path, o, record);
  Volume result = record.timed("convert", [&] { return converted(std::move(input), o, record); });
  const auto& dims = result.geometry().dims;
  record.result("dims", {dims[0], dims[1], dims[2]});
  record.result("type", std::string(volume::name(result.voxel_type())));
  cli::save(o.output, result, record, o.format, o.compress);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Changes a volume's format, voxel type, range, box, size and orientation; subtracts another volume.\n"
      "With no option but the output it changes the format alone. Index volumes are unpacked to one u8 an "
      "entry."};
  Options o;
  declare(app, o);
  return cli::run(
      app,
      {.name = "vol-convert",
       .example = "vol-phantom protein -o - | vol-convert - --resample 128x128x128 --kernel b-spline "
                  "--type u8 --rescale 0,255 -o protein.vti",
       .references = "Keys 1981 (catmull-rom); Unser, Aldroubi & Eden 1993 (b-spline)"},
      argc, argv, [&](cli::Record& record) { return convert(o, record); });
}
