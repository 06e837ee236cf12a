#include "cli/volume_input.h"

#include "base/error.h"
#include "cli/options.h"
#include "io/any_volume.h"

namespace vol::cli {
namespace {

io::ReadOptions read_options(const VolumeInput& input) {
  io::ReadOptions options;
  options.array = input.array;
  options.volume = input.volume;
  options.missing = input.missing;
  if (!input.raw_dims.empty()) {
    io::RawLayout raw;
    raw.dims = parse_dims("--raw-dims", input.raw_dims);
    raw.type = volume::voxel_type_from_name(input.raw_type);
    raw.big_endian = input.raw_endian == "big";
    raw.skip = input.raw_skip;
    raw.spacing = parse_vec3("--raw-spacing", input.raw_spacing);
    options.raw = raw;
  }
  return options;
}

volume::Volume wanted(volume::Volume volume, const std::filesystem::path& path, const VolumeInput& input) {
  if (!input.index_volumes && io::is_index(volume)) {
    throw Error(
        io::display_name(path) +
        ": is an index volume, whose bytes are no values of a field; vol-convert unpacks its entries");
  }
  return volume;
}

}  // namespace

void add_volume_options(CLI::App& app, VolumeInput& input) {
  const auto* const group = kVolumeInputGroup;
  app.add_option("--array", input.array, "Which array, where a file has several [first scalar one]")
      ->group(group);
  app.add_option("--volume", input.volume, "Which volume of a 4-D file, from 0")->group(group);
  app.add_option("--missing", input.missing, "Value in place of NaN and infinity [they are refused]")
      ->check(check_finite)
      ->group(group);
  auto* dims =
      app.add_option("--raw-dims", input.raw_dims, "Read headerless data of this size, x fastest: 64x64x64")
          ->group(group);
  app.add_option("--raw-type", input.raw_type, "Voxel type of headerless data")
      ->check(CLI::IsMember({"i8", "u8", "i16", "u16", "i32", "u32", "f16", "f32", "f64"}))
      ->capture_default_str()
      ->needs(dims)
      ->group(group);
  app.add_option("--raw-endian", input.raw_endian, "Byte order of headerless data")
      ->check(CLI::IsMember({"little", "big"}))
      ->capture_default_str()
      ->needs(dims)
      ->group(group);
  app.add_option("--raw-skip", input.raw_skip, "Bytes before the first voxel of headerless data")
      ->check(check_whole_number)
      ->capture_default_str()
      ->needs(dims)
      ->group(group);
  app.add_option("--raw-spacing", input.raw_spacing,
                 "World distance between samples of headerless data: x,y,z")
      ->capture_default_str()
      ->needs(dims)
      ->group(group);
}

void add_volume_input(CLI::App& app, VolumeInput& input, const std::string& description) {
  app.add_option("input", input.path, description)->required()->group("Files");
  add_volume_options(app, input);
}

volume::Volume load(const VolumeInput& input, Record& record) {
  return load(input.path, input, record);
}

volume::Volume load(const std::filesystem::path& path, const VolumeInput& input, Record& record) {
  const io::ReadOptions options = read_options(input);
  record.input(path);
  return wanted(record.timed("read", [&] { return io::read_any_volume(path, options); }), path, input);
}

volume::Volume load(io::InputFile& file, const VolumeInput& input, Record& record) {
  const io::ReadOptions options = read_options(input);
  record.input(file.path());
  return wanted(record.timed("read", [&] { return io::read_any_volume(file, options); }), file.path(), input);
}

void save(const std::filesystem::path& path, volume::Volume& volume, Record& record,
          const std::string& format, bool compress) {
  for (const auto& [key, value] : record.provenance()) volume.attributes[key] = value;
  const auto lost = record.timed(
      "write", [&] { return io::write_any_volume(path, volume, {.format = format, .compress = compress}); });
  for (const auto& sentence : lost) record.warn(sentence);
  record.output(path);
}

}  // namespace vol::cli
