#include "io/volume.h"

#include <new>

#include "base/error.h"
#include "io/header_text.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"

namespace vol::io {
namespace {

struct Format {
  const char* name;
  bool (*matches)(std::string_view start);
  volume::Volume (*read)(InputFile& file, const ReadOptions& options);
};

constexpr Format kFormats[] = {
    {"NRRD", is_nrrd, read_nrrd},
    {"legacy VTK", is_vtk_legacy, read_vtk_legacy},
    {"VTK XML", is_vtk_xml, read_vti},
    {"NIfTI-1", is_nifti, read_nifti},
    {"MetaImage", is_meta_image, read_meta_image},
};

const Format* find_format(InputFile& file) {
  const std::string_view start = file.peek(512);
  for (const Format& format : kFormats) {
    if (format.matches(start)) return &format;
  }
  return nullptr;
}

volume::Volume read_any(InputFile& file, const ReadOptions& options) {
  if (options.raw) return read_raw(file, options);
  const std::string name = display_name(file.path());
  if (file.at_end()) throw Error(name + ": is empty");
  const Format* format = find_format(file);
  if (format == nullptr) {
    throw Error(
        name +
        ": is none of the volume formats NRRD, MetaImage, VTK image data, NIfTI-1; for headerless data"
        " give --raw-dims and --raw-type");
  }
  return format->read(file, options);
}

}  // namespace

std::string_view volume_format(InputFile& file) {
  const Format* format = find_format(file);
  return format == nullptr ? std::string_view() : format->name;
}

volume::Volume read_volume(const std::filesystem::path& path, const ReadOptions& options) {
  InputFile file(path);
  return read_volume(file, options);
}

volume::Volume read_volume(InputFile& file, const ReadOptions& options) {
  const std::string name = display_name(file.path());
  try {
    volume::Volume volume = read_any(file, options);
    narrow_if_marked(volume);
    try {
      volume::require_finite(volume, options.missing ? &*options.missing : nullptr);
    } catch (const Error& e) {
      throw Error(name, e);
    }
    return volume;
  } catch (const std::bad_alloc&) {
    throw Error(name + ": there is not enough memory for its voxels");
  }
}

std::vector<std::string> write_volume(const std::filesystem::path& path, const volume::Volume& volume,
                                      const WriteOptions& options) {
  const bool to_stream = is_standard_stream(path);
  std::string format = lower_case(options.format);
  if (format.empty() && to_stream) format = "nrrd";
  if (format.empty()) {
    format = lower_case(path.extension().string());
    if (!format.empty()) format.erase(0, 1);
  }
  const std::string name = to_stream ? "standard output" : path.string();
  if (volume.voxel_type() == volume::VoxelType::f16 && format != "raw") {
    return write_volume(path, widened(volume), options);
  }
  if (to_stream && (format == "nhdr" || format == "mhd")) {
    throw Error(name + ": '" + format + "' is two files; choose " + (format == "nhdr" ? "nrrd" : "mha"));
  }
  if (format == "nrrd" || format == "nhdr")
    return write_nrrd(path, volume, format == "nhdr", options.compress);
  if (format == "mha" || format == "mhd")
    return write_meta_image(path, volume, format == "mhd", options.compress);
  if (format == "vti") return write_vti(path, volume, options.compress);
  if (format == "raw") return write_raw(path, volume);
  throw Error(name + ": " +
              (format.empty() ? "has no extension" : "cannot write the format '" + format + "'") +
              ", expected one of nrrd, nhdr, mha, mhd, vti, raw");
}

}  // namespace vol::io
