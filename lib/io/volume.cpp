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
  bool has_arrays;   ///< by name: ReadOptions::array
  bool has_volumes;  ///< by number: ReadOptions::volume
};

constexpr Format kFormats[] = {
    {"NRRD", is_nrrd, read_nrrd, false, false},
    {"legacy VTK", is_vtk_legacy, read_vtk_legacy, true, false},
    {"VTK XML", is_vtk_xml, read_vti, true, false},
    {"NIfTI-1", is_nifti, read_nifti, false, true},
    {"MetaImage", is_meta_image, read_meta_image, false, false},
};

using Path = std::filesystem::path;
using volume::Volume;

constexpr VolumeWriter kWriters[] = {
    {"nrrd", false, false,
     [](const Path& path, const Volume& v, const WriteOptions& o) {
       return write_nrrd(path, v, false, o.compress);
     }},
    {"nhdr", true, false,
     [](const Path& path, const Volume& v, const WriteOptions& o) {
       return write_nrrd(path, v, true, o.compress);
     }},
    {"mha", false, false,
     [](const Path& path, const Volume& v, const WriteOptions& o) {
       return write_meta_image(path, v, false, o.compress);
     }},
    {"mhd", true, false,
     [](const Path& path, const Volume& v, const WriteOptions& o) {
       return write_meta_image(path, v, true, o.compress);
     }},
    {"vti", false, false,
     [](const Path& path, const Volume& v, const WriteOptions& o) { return write_vti(path, v, o.compress); }},
    {"raw", false, true,
     [](const Path& path, const Volume& v, const WriteOptions&) { return write_raw(path, v); }},
};

const Format* find_format(InputFile& file) {
  const std::string_view start = file.peek(512);
  for (const Format& format : kFormats) {
    if (format.matches(start)) return &format;
  }
  return nullptr;
}

/// What a format cannot choose between must not be passed over: the user meant another file, or another tool.
void require_choice(const std::string& name, std::string_view format, bool has_arrays, bool has_volumes,
                    const ReadOptions& options) {
  if (!options.array.empty() && !has_arrays) {
    throw Error(name + ": " + std::string(format) + " has no arrays by name; read it without --array " +
                options.array);
  }
  if (options.volume && !has_volumes) {
    throw Error(name + ": " + std::string(format) + " has no numbered volumes; read it without --volume " +
                std::to_string(*options.volume));
  }
}

volume::Volume read_any(InputFile& file, const ReadOptions& options) {
  const std::string name = display_name(file.path());
  if (options.raw) {
    require_choice(name, "headerless data", false, false, options);
    return read_raw(file, options);
  }
  if (file.at_end()) throw Error(name + ": is empty");
  const Format* format = find_format(file);
  if (format == nullptr) {
    throw Error(
        name +
        ": is none of the volume formats NRRD, MetaImage, VTK image data, NIfTI-1, OpenVDB; for headerless"
        " data give --raw-dims and --raw-type");
  }
  require_choice(name, format->name, format->has_arrays, format->has_volumes, options);
  return format->read(file, options);
}

}  // namespace

bool is_index(const volume::Volume& volume) {
  const auto found = volume.attributes.find(kKindKey);
  return found != volume.attributes.end() && found->second == kIndexKind;
}

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

std::span<const VolumeWriter> volume_writers() {
  return kWriters;
}

const VolumeWriter& writer_for(const std::filesystem::path& path, const std::string& format,
                               std::span<const VolumeWriter> writers) {
  const bool to_stream = is_standard_stream(path);
  std::string wanted = lower_case(format);
  if (wanted.empty()) wanted = to_stream ? ".nrrd" : lower_case(path.extension().string());
  if (wanted.starts_with('.')) wanted.erase(0, 1);
  std::string names;
  for (const VolumeWriter& writer : writers) {
    if (to_stream && writer.is_two_files) {
      if (writer.name != wanted) continue;
      throw Error("standard output: '" + wanted + "' is two files; choose a format that is one");
    }
    if (writer.name == wanted) return writer;
    names.append(names.empty() ? "" : ", ").append(writer.name);
  }
  throw Error(
      output_name(path) + ": " +
      (wanted.empty() ? "has no extension; give --format" : "cannot write the format " + in_quotes(wanted)) +
      ", expected one of " + names);
}

std::vector<std::string> write_by(const VolumeWriter& writer, const std::filesystem::path& path,
                                  const volume::Volume& volume, const WriteOptions& options) {
  const bool widen = volume.voxel_type() == volume::VoxelType::f16 && !writer.takes_f16;
  return widen ? writer.write(path, widened(volume), options) : writer.write(path, volume, options);
}

std::vector<std::string> write_volume(const std::filesystem::path& path, const volume::Volume& volume,
                                      const WriteOptions& options) {
  return write_by(writer_for(path, options.format, kWriters), path, volume, options);
}

}  // namespace vol::io
